#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

#include "closed_loop.hpp"

// Decompositions of the closed loop's matrices, in one file: they are slow to compile.

namespace veridyn {

MatrixXd power(MatrixXd A, int n) {
  MatrixXd out = MatrixXd::Identity(A.rows(), A.cols());
  for (; n > 0; n /= 2) {
    if (n % 2 == 1) out = (A * out).eval();
    if (n > 1) A = (A * A).eval();
  }
  return out;
}

double spectral_radius(const MatrixXd& A) {
  if (!A.allFinite()) return std::numeric_limits<double>::infinity();
  const Eigen::EigenSolver<MatrixXd> solver(A, false);
  if (solver.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  return solver.eigenvalues().cwiseAbs().maxCoeff();
}

std::vector<std::pair<double, double>> eigenvalues(const MatrixXd& A) {
  std::vector<std::pair<double, double>> out;
  if (!A.allFinite()) return out;
  const Eigen::EigenSolver<MatrixXd> solver(A, false);
  if (solver.info() != Eigen::Success) return out;
  for (Eigen::Index k = 0; k < A.rows(); ++k)
    out.emplace_back(solver.eigenvalues()[k].real(), solver.eigenvalues()[k].imag());
  return out;
}

// Scaling and squaring of a Taylor series: [A B; 0 0] t to a norm below a quarter, where 12 terms
// leave errors below 1e-16.
void discretise(const MatrixXd& A, const MatrixXd& B, double t, MatrixXd& transition,
                MatrixXd& input) {
  const Eigen::Index n = A.rows();
  const Eigen::Index m = B.cols();
  MatrixXd whole = MatrixXd::Zero(n + m, n + m);
  whole.topLeftCorner(n, n) = A * t;
  whole.topRightCorner(n, m) = B * t;
  const double norm = whole.cwiseAbs().rowwise().sum().maxCoeff();
  const int squarings = norm > 0.25 ? static_cast<int>(std::ceil(std::log2(norm / 0.25))) : 0;
  whole /= std::pow(2.0, squarings);
  MatrixXd sum = MatrixXd::Identity(n + m, n + m);
  MatrixXd term = sum;
  for (int k = 1; k <= 12; ++k) {
    term = (term * whole / k).eval();
    sum += term;
  }
  for (int k = 0; k < squarings; ++k) sum = (sum * sum).eval();
  transition = sum.topLeftCorner(n, n);
  input = sum.topRightCorner(n, m);
}

}  // namespace veridyn
