#include "veridyn/dynamics/equation_of_motion.hpp"

#include <algorithm>
#include <cassert>
#include <new>
#include <vector>

#include "regressor_batch_kernels.hpp"
#include "veridyn/kinematics/tree.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {

namespace {

// [rad/s] or [m/s] of the differences for dh/ddq: h is quadratic in dq, so they are off by the step
// times a product of inertia, and by rounding.
constexpr double kVelocityStep = 1e-6;

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
        workspace(::operator new(widest_batch_kernels().workspace(tree), kAlignment)) {
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

  Tree tree;
  VectorXd phi;
  int rows;
  // A row for rest, one for each unit acceleration, and where there is room one for each velocity.
  MatrixXd q, dq, ddq, tau;
  void* workspace;
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
  lanes_->fill(q, dq);
  lanes_->run(M, h);
}

bool EquationOfMotion::slopes_are_free() const noexcept {
  return 2 * lanes_->tree.joints + 1 <= lanes_->rows;
}

void EquationOfMotion::evaluate_with_slopes(const VectorXd& q, const VectorXd& dq, MatrixXd& M,
                                            VectorXd& h, MatrixXd& D) noexcept {
  assert(slopes_are_free());
  Lanes& l = *lanes_;
  const int n = l.tree.joints;
  l.fill(q, dq);
  for (int j = 0; j < n; ++j) l.dq.data()[j * l.rows + n + 1 + j] += kVelocityStep;
  l.run(M, h);
  for (int i = 0; i < n; ++i) {
    const double* lane = l.tau.data() + i * l.rows;
    for (int j = 0; j < n; ++j)
      D.data()[j * n + i] = (lane[n + 1 + j] - lane[0]) * (1.0 / kVelocityStep);
  }
}

}  // namespace veridyn
