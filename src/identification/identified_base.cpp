#include "identified_base.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

namespace veridyn {
namespace {

// Nine digits are far below any deviation and halve the length of the file.
double rounded(double value) {
  return std::strtod(fmt::format("{:.9g}", value).c_str(), nullptr);
}

double to_four_digits(double value) {
  return std::strtod(fmt::format("{:.4f}", value).c_str(), nullptr);
}

// Compresses a factor of the covariance to at most as many columns as rows, if it has more than
// kClustersKept.
MatrixXd compressed_scatter(const MatrixXd& scatter) {
  if (scatter.cols() <= std::max<Eigen::Index>(kClustersKept, scatter.rows())) return scatter;
  const Eigen::HouseholderQR<MatrixXd> qr(scatter.transpose());
  const Eigen::Index k = scatter.rows();
  return MatrixXd(qr.matrixQR().topRows(k).triangularView<Eigen::Upper>()).transpose();
}

// Share of each cluster in the squares of a joint's columns, root mean over the columns, independent of
// units.
MatrixXd motion_of(const std::vector<CompressedRecording>& recordings, int clusters) {
  const auto n = static_cast<Eigen::Index>(recordings.front().joints.size());
  std::vector<VectorXd> total(n);
  for (const CompressedRecording& r : recordings) {
    for (const auto& block : r.blocks) {
      for (size_t i = 0; i < block.size(); ++i) {
        const VectorXd squares = block[i].column_norms().cwiseAbs2();
        if (total[i].size() == 0) total[i] = VectorXd::Zero(squares.size());
        total[i] += squares;
      }
    }
  }
  MatrixXd out(clusters, n);
  Eigen::Index c = 0;
  for (const CompressedRecording& r : recordings) {
    for (const auto& block : r.blocks) {
      for (size_t i = 0; i < block.size(); ++i) {
        const Eigen::ArrayXd squares = block[i].column_norms().cwiseAbs2();
        const Eigen::ArrayXd of = total[i].array();
        const auto used = static_cast<double>((of > 0.0).count());
        const double share = (of > 0.0).select(squares / of.max(1e-300), 0.0).sum();
        out(c, static_cast<Eigen::Index>(i)) = used > 0.0 ? std::sqrt(share / used) : 0.0;
      }
      ++c;
    }
  }
  return out;
}

}  // namespace

IdentifiedBase identified_base(const BaseParameters& base,
                               const std::vector<StandardParameter>& parameters,
                               const BaseSolution& solution, const VectorRef& beta,
                               const std::vector<CompressedRecording>& recordings) {
  IdentifiedBase out;
  for (const CompressedRecording& r : recordings) out.recordings.push_back(std::filesystem::path(r.source).filename().string());
  out.clusters = solution.clusters;
  if (out.clusters <= kClustersKept)
    out.motion = motion_of(recordings, out.clusters).unaryExpr(&to_four_digits);
  const MatrixXd scatter = compressed_scatter(solution.scatter);
  for (int j = 0; j < base.size(); ++j) {
    IdentifiedParameter p;
    const auto own = static_cast<size_t>(base.independent[j]);
    p.name = parameters[own].name;
    p.unit = parameters[own].unit;
    for (Eigen::Index c = 0; c < base.K.cols(); ++c) {
      if (base.K(j, c) == 0.0) continue;
      p.combination[parameters[c].name] = rounded(base.K(j, c));
    }
    p.value = rounded(beta[j]);
    p.free = rounded(solution.beta[j]);
    p.scatter = scatter.row(j).transpose().unaryExpr(&rounded);
    out.parameters.push_back(std::move(p));
  }
  return out;
}

}  // namespace veridyn
