#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <complex>

#include "loop_search.hpp"

namespace veridyn {
namespace {

using Complex = Eigen::MatrixXcd;

// The loop over one hyperperiod with torques w added in each cycle and accelerations z, both
// weighted by the arms' own inertia: x <- A x + B w, z = C x + D w.
struct Lifted {
  MatrixXd A, B, C, D;
};

Lifted lifted_system(const ClosedLoop& loop, const MatrixXd& root) {
  const Eigen::Index n = loop.joints();
  const Eigen::Index N = loop.states();
  const Eigen::Index h = loop.hyperperiod();
  MatrixXd X = MatrixXd::Zero(N, N + h * n);
  X.leftCols(N).setIdentity();
  MatrixXd Z(h * n, N + h * n);
  for (Eigen::Index k = 0; k < h; ++k) {
    const MatrixXd before = X.middleRows(n, n);
    loop.advance(loop.first_cycle() + k, X);
    X.block(0, N + k * n, 2 * n, n) += loop.torque_input() * root;
    Z.middleRows(k * n, n) = root.transpose() * (X.middleRows(n, n) - before) / loop.period();
  }
  return {X.leftCols(N), X.rightCols(h * n), Z.leftCols(N), Z.rightCols(h * n)};
}

}  // namespace

double torque_error_gain(const LinearPoint& point, const Scenario& scenario, int frequencies) {
  const ClosedLoop loop(point, scenario, {});
  MatrixXd M = MatrixXd::Zero(loop.joints(), loop.joints());
  Eigen::Index at = 0;
  for (const LinearArm& arm : point.arms) {
    M.block(at, at, arm.joints(), arm.joints()) = arm.M;
    at += arm.joints();
  }
  const MatrixXd root = M.llt().matrixL();
  const Lifted s = lifted_system(loop, root);
  const Eigen::Index N = loop.states();
  double largest = 0.0;
  for (int k = 0; k <= frequencies; ++k) {
    // Logarithmic grid from a thousandth of the highest frequency.
    const double angle = M_PI * std::pow(1e-3, 1.0 - static_cast<double>(k) / frequencies);
    const Complex resolvent =
        std::polar(1.0, angle) * Complex::Identity(N, N) - s.A.cast<std::complex<double>>();
    const Complex T = s.C * resolvent.partialPivLu().solve(s.B.cast<std::complex<double>>()) + s.D;
    const double square = (T.adjoint() * T).norm();  // Frobenius: at least the largest eigenvalue
    largest = std::max(largest, std::sqrt(square));
  }
  return largest;
}

}  // namespace veridyn
