#include "veridyn/dynamics/torque_regressor.hpp"

#include <algorithm>
#include <cassert>
#include <utility>
#include <vector>

#include "arm_kernels.hpp"
#include "math/aligned_doubles.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

// Number of rows of a block: its columns are an odd number of cache lines, so that they do not evict each other
// from the cache.
constexpr int kBlockRows = 72;

// Pointers to the samples; throws InvalidInput if the sizes differ.
BatchInput input(const char* where, int joints, const MatrixRef& q, const MatrixRef& dq,
                 const MatrixRef& ddq) {
  require(q.cols() == joints && dq.cols() == joints && ddq.cols() == joints, where,
          ": q, dq and ddq have ", q.cols(), ", ", dq.cols(), " and ", ddq.cols(),
          " columns, but the arm has ", joints, " joints.");
  require(q.rows() == dq.rows() && q.rows() == ddq.rows(), where, ": q, dq and ddq have ", q.rows(),
          ", ", dq.rows(), " and ", ddq.rows(), " rows.");
  return {static_cast<int>(q.rows()),
          {q.data(), q.outerStride()},
          {dq.data(), dq.outerStride()},
          {ddq.data(), ddq.outerStride()}};
}

// The links with only those supporting coordinates whose index is from `first` to `end` - 1.
std::vector<Link> moved_by(const Links& tree, int first, int end) {
  std::vector<Link> links(tree.link, tree.link + tree.count);
  for (Link& link : links) {
    const auto at = [&](int m) { return tree.support[m].coordinate; };
    while (link.first_support < link.end_support && at(link.first_support) < first) ++link.first_support;
    while (link.first_support < link.end_support && at(link.end_support - 1) >= end) --link.end_support;
  }
  return links;
}

}  // namespace

TorqueRegressor::TorqueRegressor(const Model& arm)
    : tree_(arm, Tree::Keep::kMovingLinks),
      memory_(arm_kernels().regressor_workspace(tree_)),
      columns_(static_cast<size_t>(arm.joints())),
      first_column_(tree_.bodies.size() * static_cast<size_t>(arm.joints()), -1) {
  for (size_t b = 0; b < tree_.bodies.size(); ++b) {
    if (tree_.bodies[b].link < 0) continue;
    const Link& link = tree_.links[tree_.bodies[b].link];
    for (int m = link.first_support; m < link.end_support; ++m) {
      const auto i = static_cast<size_t>(tree_.supports[m].coordinate);
      first_column_[b * columns_.size() + i] = static_cast<int>(columns_[i].size());
      for (int c = 0; c < kBodyParameters; ++c)
        columns_[i].push_back(static_cast<int>(kBodyParameters * b) + c);
    }
  }
}

void TorqueRegressor::evaluate(const VectorRef& q, const VectorRef& dq, const VectorRef& ddq,
                               MatrixXd& Y) {
  const Links tree = tree_;
  assert(q.size() == tree.joints && dq.size() == tree.joints && ddq.size() == tree.joints &&
         Y.rows() == tree.joints && Y.cols() == kBodyParameters * tree.bodies);
  arm_kernels().regressor(tree, q.data(), dq.data(), ddq.data(), Y.data(), memory_.get());
}

void TorqueRegressor::evaluate(const MatrixRef& q, const MatrixRef& dq, const MatrixRef& ddq,
                              std::vector<MatrixXd>& Y) const {
  evaluate(q, dq, ddq, 0, joints(), Y);
}

void TorqueRegressor::evaluate(const MatrixRef& q, const MatrixRef& dq, const MatrixRef& ddq,
                              int first, int end, std::vector<MatrixXd>& Y) const {
  const BatchInput in = input("TorqueRegressor", joints(), q, dq, ddq);
  require(0 <= first && first <= end && end <= joints(), "TorqueRegressor: joints ", first, " to ",
          end, " of ", joints(), ".");
  Y.resize(joints());
  for (int i = first; i < end; ++i) {
    const auto cols = static_cast<Eigen::Index>(columns({i}).size());
    if (Y[i].rows() != in.rows || Y[i].cols() < cols) Y[i].resize(in.rows, cols);
  }
  Links tree = tree_;
  const std::vector<Link> links = moved_by(tree, first, end);
  tree.link = links.data();
  AlignedDoubles own;
  void* const workspace = own.get(arm_kernels().batch_workspace(tree) / sizeof(double));
  std::vector<double*> data(joints(), nullptr);
  const ColumnsByJoint<double> out{data.data(), first_column_.data()};
  if (in.rows <= 2 * kBlockRows) {
    for (int i = first; i < end; ++i) data[i] = Y[i].data();
    arm_kernels().batch_regressor(tree, in, out, workspace);
    return;
  }
  // Columns of many rows lie far apart in memory: blocks are computed side by side in the cache,
  // then copied out column by column.
  thread_local AlignedDoubles memory;
  size_t wide = 0;
  for (int i = first; i < end; ++i) wide += columns({i}).size();
  double* block = memory.get(wide * kBlockRows);
  for (int row = 0; row < in.rows; row += kBlockRows) {
    const int rows = std::min(kBlockRows, in.rows - row);
    double* next = block;
    for (int i = first; i < end; ++i) {
      data[i] = next;
      next += columns({i}).size() * static_cast<size_t>(rows);
    }
    const auto part = [row](const SampleColumns& of) {
      return SampleColumns{of.data + row, of.stride};
    };
    arm_kernels().batch_regressor(tree, {rows, part(in.q), part(in.dq), part(in.ddq)}, out,
                                     workspace);
    for (int i = first; i < end; ++i) {
      const double* from = data[i];
      const auto cols = static_cast<Eigen::Index>(columns({i}).size());
      for (Eigen::Index c = 0; c < cols; ++c, from += rows)
        std::copy_n(from, rows, Y[i].data() + c * in.rows + row);
    }
  }
}

void TorqueRegressor::torques(const MatrixRef& q, const MatrixRef& dq, const MatrixRef& ddq,
                             const VectorRef& phi, MatrixXd& tau) const {
  const BatchInput in = input("TorqueRegressor", joints(), q, dq, ddq);
  tau.resize(in.rows, joints());
  const Links tree = tree_;
  AlignedDoubles own;
  void* const workspace = own.get(arm_kernels().batch_workspace(tree) / sizeof(double));
  const std::vector<LinkInertia> inertia = inertias(phi);
  arm_kernels().batch_torques({tree, inertia.data()}, in, tau.data(), workspace);
}

void TorqueRegressor::gradient(const MatrixRef& q, const MatrixRef& dq, const MatrixRef& ddq,
                              const std::vector<MatrixXd>& weights, MatrixXd& slopes) const {
  const BatchInput in = input("TorqueRegressor", joints(), q, dq, ddq);
  require(weights.size() == columns_.size(), "TorqueRegressor: found weights for ", weights.size(),
          " joints, expected ", columns_.size(), ".");
  std::vector<const double*> data;
  for (int i = 0; i < joints(); ++i) {
    const MatrixXd& w = weights[i];
    const auto expected = static_cast<Eigen::Index>(columns({i}).size());
    require(w.rows() == in.rows && w.cols() == expected, "TorqueRegressor: the weights of joint ",
            i + 1, " are ", w.rows(), " x ", w.cols(), ", expected ", in.rows, " x ", expected,
            ".");
    data.push_back(w.data());
  }
  slopes.resize(in.rows, Eigen::Index{3} * joints());
  const Links tree = tree_;
  AlignedDoubles own;
  void* const workspace = own.get(arm_kernels().batch_workspace(tree) / sizeof(double));
  arm_kernels().batch_gradient(tree, in, {data.data(), first_column_.data()}, slopes.data(),
                               workspace);
}

void TorqueRegressor::torque_derivatives(const MatrixRef& q, const MatrixRef& dq, const MatrixRef& ddq,
                                   const VectorRef& phi, MatrixXd& slopes) const {
  const BatchInput in = input("TorqueRegressor", joints(), q, dq, ddq);
  slopes.resize(in.rows, Eigen::Index{3} * joints() * joints());
  const Links tree = tree_;
  AlignedDoubles own;
  void* const workspace = own.get(arm_kernels().batch_workspace(tree) / sizeof(double));
  const std::vector<LinkInertia> inertia = inertias(phi);
  arm_kernels().batch_derivatives({tree, inertia.data()}, in, slopes.data(), workspace);
}

std::vector<LinkInertia> TorqueRegressor::inertias(const VectorRef& phi) const {
  const auto expected = static_cast<Eigen::Index>(kBodyParameters * tree_.bodies.size());
  require(phi.size() == expected, "TorqueRegressor: phi has ", phi.size(),
          " entries, but the arm has ", tree_.bodies.size(), " bodies with ", kBodyParameters,
          " each.");
  std::vector<LinkInertia> out(tree_.links.size());
  link_inertias(tree_, phi.data(), out.data());
  return out;
}

MatrixXd torque_regressor(const Model& arm, const VectorRef& q, const VectorRef& dq,
                          const VectorRef& ddq) {
  const std::pair<const char*, const VectorRef*> all[] = {{"q", &q}, {"dq", &dq}, {"ddq", &ddq}};
  for (const auto& [name, v] : all)
    require(v->size() == arm.joints(), "torque_regressor: ", name, " has ", v->size(),
            " entries, but arm '", arm.name(), "' has ", arm.joints(), " joints.");
  MatrixXd Y(arm.joints(), static_cast<Eigen::Index>(kBodyParameters * arm.bodies().size()));
  TorqueRegressor(arm).evaluate(q, dq, ddq, Y);
  return Y;
}

}  // namespace veridyn
