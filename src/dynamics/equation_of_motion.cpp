#include "veridyn/dynamics/equation_of_motion.hpp"

#include <cassert>
#include <new>
#include <vector>

#include "regressor_batch_kernels.hpp"
#include "veridyn/kinematics/tree.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {

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

  Tree tree;
  VectorXd phi;
  int rows;
  MatrixXd q, dq, ddq, tau;  // a row for rest and one for each unit acceleration
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
  Lanes& l = *lanes_;
  const int n = l.tree.joints;
  const int rows = l.rows;
  assert(q.size() == n && dq.size() == n && M.rows() == n && M.cols() == n && h.size() == n);
  for (int i = 0; i < n; ++i) {
    double* q_lanes = l.q.data() + i * rows;
    double* dq_lanes = l.dq.data() + i * rows;
    for (int lane = 0; lane < rows; ++lane) {
      q_lanes[lane] = q.data()[i];
      dq_lanes[lane] = dq.data()[i];
    }
  }
  const BatchInput in{rows, {l.q.data(), rows}, {l.dq.data(), rows}, {l.ddq.data(), rows}};
  widest_batch_kernels().torques(l.tree, in, l.phi.data(), l.tau.data(), l.workspace);
  for (int i = 0; i < n; ++i) {
    const double* lane = l.tau.data() + i * rows;
    h.data()[i] = lane[0];
    for (int j = 0; j <= i; ++j) M.data()[j * n + i] = M.data()[i * n + j] = lane[j + 1] - lane[0];
  }
}

}  // namespace veridyn
