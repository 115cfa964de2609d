#include "diagnosis/preparation/instruments.hpp"

#include <algorithm>
#include <cmath>

#include "diagnosis/load_fit.hpp"
#include "diagnosis/numerics.hpp"
#include "math/clustered_statistics.hpp"
#include "math/decompositions.hpp"
#include "math/student_t.hpp"

namespace veridyn {
namespace {

// Moments of one cluster over scaled columns.
struct Moments {
  MatrixXd AA, ZA;
  VectorXd Ab, Zb;

  explicit Moments(Eigen::Index k)
      : AA(MatrixXd::Zero(k, k)),
        ZA(MatrixXd::Zero(k, k)),
        Ab(VectorXd::Zero(k)),
        Zb(VectorXd::Zero(k)) {}

  void add(double sign, const Moments& other) {
    AA += sign * other.AA;
    ZA += sign * other.ZA;
    Ab += sign * other.Ab;
    Zb += sign * other.Zb;
  }
};

VectorXd norms_of(const std::vector<RepeatedRows>& joints, const VectorXd& weights) {
  VectorXd out = VectorXd::Zero(joints.front().A.cols());
  for (size_t j = 0; j < joints.size(); ++j)
    out += weights[static_cast<Eigen::Index>(j)] *
           joints[j].A.colwise().squaredNorm().transpose();
  return out.cwiseSqrt().cwiseMax(numerics::kTiny);
}

std::vector<Moments> moments_of(const std::vector<RepeatedRows>& joints, const VectorXd& weights,
                                const VectorXd& scale) {
  std::vector<Moments> out;
  for (size_t j = 0; j < joints.size(); ++j) {
    const RepeatedRows& rows = joints[j];
    const double w = weights[static_cast<Eigen::Index>(j)];
    for (Eigen::Index r = 0; r < rows.b.size(); ++r) {
      const auto cluster = static_cast<size_t>(rows.cluster[r]);
      while (out.size() <= cluster) out.emplace_back(scale.size());
      const VectorXd a = rows.A.row(r).transpose().cwiseQuotient(scale);
      const VectorXd z = rows.Z.row(r).transpose().cwiseQuotient(scale);
      Moments& m = out[cluster];
      m.AA += w * a * a.transpose();
      m.ZA += w * z * a.transpose();
      m.Ab += w * rows.b[r] * a;
      m.Zb += w * rows.b[r] * z;
    }
  }
  return out;
}

VectorXd least_squares(const Moments& m) {
  return solve_scaled(m.AA, m.Ab);
}

VectorXd instrumental(const Moments& m) {
  return Eigen::ColPivHouseholderQR<MatrixXd>(m.ZA).solve(m.Zb);
}

}  // namespace

InstrumentalEstimate compare_with_instruments(const std::vector<RepeatedRows>& joints,
                                              const VectorXd& weights) {
  const VectorXd scale = norms_of(joints, weights);
  const std::vector<Moments> clusters = moments_of(joints, weights, scale);
  Moments all(scale.size());
  for (const Moments& m : clusters) all.add(1.0, m);
  InstrumentalEstimate out;
  out.least_squares = least_squares(all);
  out.instrumental = instrumental(all);
  out.degrees_of_freedom = std::max(1.0, static_cast<double>(clusters.size()) - 1.0);
  MatrixXd without(scale.size(), static_cast<Eigen::Index>(clusters.size()));
  for (size_t c = 0; c < clusters.size(); ++c) {
    Moments rest = all;
    rest.add(-1.0, clusters[c]);
    without.col(c) = instrumental(rest) - least_squares(rest);
  }
  out.deviation = jackknife_deviations(without);
  out.p_value = VectorXd::Ones(scale.size());
  const VectorXd contrast = out.instrumental - out.least_squares;
  for (Eigen::Index k = 0; k < contrast.size(); ++k) {
    if (out.deviation[k] > 0.0 && std::isfinite(contrast[k]))
      out.p_value[k] = student_t_two_sided(contrast[k] / out.deviation[k], out.degrees_of_freedom);
  }
  out.least_squares = out.least_squares.cwiseQuotient(scale);
  out.instrumental = out.instrumental.cwiseQuotient(scale);
  out.deviation = out.deviation.cwiseQuotient(scale);
  return out;
}

}  // namespace veridyn
