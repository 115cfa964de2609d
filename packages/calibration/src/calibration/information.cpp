#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "least_squares.hpp"

namespace veridyn::internal {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr double kSingular = 1e-14;  // relative to the largest eigenvalue of the scaled matrix

// The Moore-Penrose inverse of a symmetric matrix after scaling its columns to norm one.
MatrixXd scaled_inverse(const MatrixXd& H) {
  const VectorXd scale =
      H.diagonal().unaryExpr([](double d) { return d > 0.0 ? 1.0 / std::sqrt(d) : 0.0; });
  const MatrixXd scaled = scale.asDiagonal() * H * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(scaled);
  VectorXd inverse = eigen.eigenvalues();
  const double largest = inverse.size() > 0 ? inverse.maxCoeff() : 0.0;
  for (double& value : inverse) value = value > kSingular * largest ? 1.0 / value : 0.0;
  return scale.asDiagonal() * eigen.eigenvectors() * inverse.asDiagonal() *
         eigen.eigenvectors().transpose() * scale.asDiagonal();
}

}  // namespace

Information::Information(const LeastSquares& problem) {
  using Scope = LeastSquares::Scope;
  const auto& unknowns = problem.unknowns_;
  std::vector<int> offsets(unknowns.size(), 0);
  for (std::size_t k = 0; k < unknowns.size(); ++k)
    offsets[k] = problem.shared_offset(static_cast<int>(k));
  const int n = problem.shared_size();
  reduced_ = MatrixXd::Zero(n, n);
  std::map<int, MatrixXd> own;
  for (const Observation& o : problem.observations()) {
    if (!o.active) continue;
    residuals_ += o.size;
    std::vector<const double*> x;
    std::vector<RowMajor> J;
    std::vector<double*> places;
    for (const int u : o.unknowns) {
      x.push_back(unknowns[LeastSquares::at(u)].x.data());
      J.emplace_back(o.size, unknowns[LeastSquares::at(u)].x.size());
    }
    for (RowMajor& block : J) places.push_back(block.data());
    VectorXd r(o.size);
    o.residual(x.data(), r.data(), places.data());
    for (std::size_t a = 0; a < J.size(); ++a) {
      const int ua = o.unknowns[a];
      const bool local = unknowns[LeastSquares::at(ua)].scope == Scope::kLocal;
      if (local) {
        MatrixXd& H = own.try_emplace(ua, MatrixXd::Zero(J[a].cols(), J[a].cols())).first->second;
        H.noalias() += J[a].transpose() * J[a];
      }
      for (std::size_t b = 0; b < J.size(); ++b) {
        const int ub = o.unknowns[b];
        if (unknowns[LeastSquares::at(ub)].scope == Scope::kLocal) continue;
        const int row = offsets[LeastSquares::at(ub)];
        if (local) {
          Local& l = local_[ua];
          if (l.coupling.size() == 0) l.coupling = MatrixXd::Zero(n, J[a].cols());
          l.coupling.middleRows(row, J[b].cols()).noalias() += J[b].transpose() * J[a];
        } else {
          reduced_.block(offsets[LeastSquares::at(ua)], row, J[a].cols(), J[b].cols()).noalias() +=
              J[a].transpose() * J[b];
        }
      }
    }
  }
  unknowns_ = n;
  for (auto& [u, H] : own) {
    Local& l = local_[u];
    if (l.coupling.size() == 0) l.coupling = MatrixXd::Zero(n, H.cols());
    l.inverse = scaled_inverse(H);
    reduced_.noalias() -= l.coupling * l.inverse * l.coupling.transpose();
    unknowns_ += static_cast<int>(H.cols());
  }
  inverse_ = scaled_inverse(reduced_);
}

MatrixXd Information::covariance(const MatrixXd& shared,
                                 const std::map<int, MatrixXd>& local) const {
  MatrixXd d = shared;
  MatrixXd out = MatrixXd::Zero(shared.rows(), shared.rows());
  for (const auto& [u, g] : local) {
    const auto found = local_.find(u);
    if (found == local_.end()) continue;
    d.noalias() -= g * found->second.inverse * found->second.coupling.transpose();
    out.noalias() += g * found->second.inverse * g.transpose();
  }
  return out + d * inverse_ * d.transpose();
}

}  // namespace veridyn::internal
