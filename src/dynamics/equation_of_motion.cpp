#include "veridyn/dynamics/equation_of_motion.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <new>
#include <vector>

#include "regressor_batch_kernels.hpp"
#include "state_model.hpp"
#include "veridyn/kinematics/tree.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {

namespace {

// [rad/s] or [m/s] of the differences for dh/ddq: h is quadratic in dq, so they are off by the step
// times a product of inertia, and by rounding.
constexpr double kVelocityStep = 1e-6;
constexpr double kPositionStep = 1e-6;  // [rad] or [m]

}  // namespace

struct EquationOfMotion::Lanes {
  static constexpr std::align_val_t kAlignment{64};

  Lanes(const Model& arm, const VectorRef& parameters)
      : tree(arm),
        phi(parameters),
        rows(full_lanes(arm.joints() + 1)),
        q(MatrixXd::Zero(rows, arm.joints())),
        dq(q),
        ddq(q),
        tau(q),
        workspace(::operator new(widest_batch_kernels().workspace(tree), kAlignment)),
        state(tree, phi),
        memory(state.workspace()) {
    for (int j = 0; j < arm.joints(); ++j) ddq(j + 1, j) = 1.0;
  }
  ~Lanes() { ::operator delete(workspace, kAlignment); }
  Lanes(const Lanes&) = delete;
  Lanes& operator=(const Lanes&) = delete;

  // Half-filled vectors cost more than full ones: they are loaded one by one.
  static int full_lanes(int needed) {
    const int lanes = widest_batch_kernels().lanes;
    return (needed + lanes - 1) / lanes * lanes;
  }

  // One state in all lanes.
  void fill(const VectorXd& at, const VectorXd& rate) {
    const int n = tree.joints;
    assert(at.size() == n && rate.size() == n);
    for (int i = 0; i < n; ++i) {
      std::fill_n(q.data() + i * rows, rows, at.data()[i]);
      std::fill_n(dq.data() + i * rows, rows, rate.data()[i]);
    }
  }

  // The torques of all lanes, and from them M and h.
  void run(MatrixXd& M, VectorXd& h) {
    const int n = tree.joints;
    assert(M.rows() == n && M.cols() == n && h.size() == n);
    const BatchInput in{rows, {q.data(), rows}, {dq.data(), rows}, {ddq.data(), rows}};
    widest_batch_kernels().torques(tree, in, phi.data(), tau.data(), workspace);
    for (int i = 0; i < n; ++i) {
      const double* lane = tau.data() + i * rows;
      h.data()[i] = lane[0];
      for (int j = 0; j <= i; ++j)
        M.data()[j * n + i] = M.data()[i * n + j] = lane[j + 1] - lane[0];
    }
  }

  // The same, and dh/ddq.
  void run_with_slopes(MatrixXd& M, VectorXd& h, MatrixXd& D) {
    const int n = tree.joints;
    for (int j = 0; j < n; ++j) dq.data()[j * rows + n + 1 + j] += kVelocityStep;
    run(M, h);
    for (int i = 0; i < n; ++i) {
      const double* lane = tau.data() + i * rows;
      for (int j = 0; j < n; ++j)
        D.data()[j * n + i] = (lane[n + 1 + j] - lane[0]) * (1.0 / kVelocityStep);
    }
  }

  Tree tree;
  VectorXd phi;
  int rows;
  // A row for rest, one for each unit acceleration, and where there is room one for each velocity.
  MatrixXd q, dq, ddq, tau;
  void* workspace;
  // Of M and h alone, one state.
  StateModel state;
  std::vector<double> memory;
};

EquationOfMotion::EquationOfMotion(const Model& arm, const VectorRef& phi) {
  const auto expected = static_cast<Eigen::Index>(kBodyParameters * arm.bodies().size());
  require(phi.size() == expected, "EquationOfMotion: phi has ", phi.size(), " entries, but arm '",
          arm.name(), "' has ", arm.bodies().size(), " bodies with ", kBodyParameters, " each.");
  lanes_ = std::make_unique<Lanes>(arm, phi);
}

EquationOfMotion::~EquationOfMotion() = default;
EquationOfMotion::EquationOfMotion(EquationOfMotion&&) noexcept = default;
EquationOfMotion& EquationOfMotion::operator=(EquationOfMotion&&) noexcept = default;

void EquationOfMotion::evaluate(const VectorXd& q, const VectorXd& dq, MatrixXd& M,
                                VectorXd& h) noexcept {
  assert(q.size() == h.size() && dq.size() == h.size() && M.rows() == h.size());
  state_kernels().equation(lanes_->state.view(), q.data(), dq.data(), M.data(), h.data(),
                           StateModel::aligned(lanes_->memory));
}

bool EquationOfMotion::slopes_are_free() const noexcept {
  return 2 * lanes_->tree.joints + 1 <= lanes_->rows;
}

void EquationOfMotion::evaluate_with_slopes(const VectorXd& q, const VectorXd& dq, MatrixXd& M,
                                            VectorXd& h, MatrixXd& D) noexcept {
  assert(slopes_are_free());
  lanes_->fill(q, dq);
  lanes_->run_with_slopes(M, h, D);
}

bool EquationOfMotion::surroundings_are_free() const noexcept {
  return 2 * lanes_->tree.joints + 2 <= lanes_->rows;
}

void EquationOfMotion::evaluate_surroundings(const VectorXd& q, const VectorXd& dq,
                                             const VectorXd& ddq, const VectorXd& way, MatrixXd& M,
                                             VectorXd& h, MatrixXd& D, VectorXd& change) noexcept {
  assert(surroundings_are_free());
  Lanes& l = *lanes_;
  const int n = l.tree.joints;
  const int last = 2 * n + 1;
  double length = 0.0;
  for (int i = 0; i < n; ++i) length = std::max(length, std::abs(way.data()[i]));
  const double scale = length > 0.0 ? kPositionStep / length : 0.0;
  l.fill(q, dq);
  for (int i = 0; i < n; ++i) {
    l.q.data()[i * l.rows + last] += scale * way.data()[i];
    l.ddq.data()[i * l.rows + last] = ddq.data()[i];
  }
  l.run_with_slopes(M, h, D);
  for (int i = 0; i < n; ++i) {
    double here = h.data()[i];
    for (int j = 0; j < n; ++j) here += M.data()[j * n + i] * ddq.data()[j];
    const double there = l.tau.data()[i * l.rows + last];
    change.data()[i] = scale > 0.0 ? (there - here) / scale : 0.0;
  }
}

}  // namespace veridyn
