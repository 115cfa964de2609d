#include "identification/drive_gains/gain_fit.hpp"
#include "identification/identification_numbers.hpp"
#include "math/numbers.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "math/clustered_statistics.hpp"

namespace veridyn {
namespace {

using Clusters = std::vector<std::vector<SquareRootInformation>>;

std::vector<GainEquation> equations_of(const std::vector<SquareRootInformation>& joints,
                                       const GainData::Columns& columns) {
  std::vector<GainEquation> out;
  for (const SquareRootInformation& factor : joints) out.push_back(gain_equation(factor, columns));
  return out;
}

void add(std::vector<SquareRootInformation>& sum, const std::vector<SquareRootInformation>& more) {
  sum.resize(more.size());
  for (size_t j = 0; j < more.size(); ++j) sum[j].merge(more[j]);
}

std::vector<GainEquation> all_equations(const Clusters& clusters,
                                        const GainData::Columns& columns) {
  std::vector<SquareRootInformation> total;
  for (const auto& cluster : clusters) add(total, cluster);
  return equations_of(total, columns);
}

// Computes sigma and the solution only.
GainFit solved(const GainData& data, const std::vector<bool>& loaded,
               const std::vector<GainEquation>& equations, const GainData::Columns& columns) {
  GainFit fit;
  fit.loaded = loaded;
  fit.columns = columns;
  fit.clusters = data.cluster_count();
  fit.sigma.resize(static_cast<Eigen::Index>(equations.size()));
  for (size_t j = 0; j < equations.size(); ++j) {
    const GainEquation& e = equations[j];
    const double noise = std::max(std::sqrt(e.rho2 / std::max(e.rows, 1.0)), identifying::kLeastNoise * e.z.norm());
    fit.sigma[static_cast<Eigen::Index>(j)] = noise > 0.0 ? noise : 1.0;  // one if there is no current
  }
  fit.solution = solve_gains(equations, fit.sigma, start_gains(equations, fit.sigma));
  // Repeats the fit with the noise estimated from its residual.
  fit.sigma = residual_current(equations, fit.solution).cwiseMax(fit.sigma);
  fit.solution = solve_gains(equations, fit.sigma, fit.solution);
  return fit;
}

// Solutions without one cluster each: x and p of each solution form a column.
MatrixXd delete_one_estimates(const Clusters& clusters, const GainFit& fit) {
  const size_t count = clusters.size();
  std::vector<std::vector<SquareRootInformation>> after(count);
  for (size_t c = count - 1; c > 0; --c) {
    after[c - 1] = after[c];
    add(after[c - 1], clusters[c]);
  }
  MatrixXd out(fit.solution.y.size() + fit.joints(), static_cast<Eigen::Index>(count));
  std::vector<SquareRootInformation> before;
  for (size_t c = 0; c < count; ++c) {
    std::vector<SquareRootInformation> rest = before;
    if (c + 1 < count) add(rest, after[c]);
    const GainSolution s = solve_gains(equations_of(rest, fit.columns), fit.sigma, fit.solution);
    out.col(c) << s.y / s.scale, s.p();
    add(before, clusters[c]);
  }
  return out;
}

VectorXd mass_shares(const GainData& data, const Clusters& clusters,
                     const std::vector<KnownMass>& loads, const GainFit& fit) {
  VectorXd mass2 = VectorXd::Zero(fit.joints());
  VectorXd current2 = VectorXd::Zero(fit.joints());
  for (size_t c = 0; c < clusters.size(); ++c) {
    const size_t recording = data.recording_of_cluster(c);
    if (!fit.loaded[recording]) continue;
    const int load = data.load_of(recording);
    const double mass = loads[load].mass;
    const std::string column = GainData::load_columns(load).front();
    for (Eigen::Index j = 0; j < fit.joints(); ++j) {
      const SquareRootInformation& factor = clusters[c][j];
      const auto at = std::find(factor.columns().begin(), factor.columns().end(), column);
      current2[j] += factor.rhs_norm2();
      if (at == factor.columns().end()) continue;
      mass2[j] += std::pow(mass * factor.column_norms()[at - factor.columns().begin()], 2);
    }
  }
  return mass2.cwiseSqrt().array() * fit.solution.p().array().abs() /
         current2.array().sqrt().max(1e-300);
}

}  // namespace

GainFit fit_gains(const GainData& data, const std::vector<KnownMass>& loads,
                  const std::vector<bool>& loaded) {
  const Clusters clusters = data.clusters(loaded);
  const GainData::Columns columns = data.columns(loaded);
  const std::vector<GainEquation> equations = all_equations(clusters, columns);
  GainFit fit = solved(data, loaded, equations, columns);
  fit.deviation = jackknife_deviations(delete_one_estimates(clusters, fit));
  const VectorXd shares = independent_shares(equations, fit.sigma, fit.solution);
  for (Eigen::Index j = 0; j < fit.joints(); ++j) {
    if (shares[j] < identifying::numbers.untied) fit.deviation[fit.solution.y.size() + j] = kInfinity;
  }
  fit.mass_share = mass_shares(data, clusters, loads, fit);
  return fit;
}

GainFit best_division(const GainData& data, const std::vector<KnownMass>& loads) {
  const size_t recordings = data.recording_count();
  std::vector<bool> best;
  double least = kInfinity;
  for (unsigned mask = 1; mask < (1u << (recordings - 1)); ++mask) {
    std::vector<bool> loaded(recordings, false);
    for (size_t r = 1; r < recordings; ++r) loaded[r] = ((mask >> (r - 1)) & 1u) != 0;
    const GainData::Columns columns = data.columns(loaded);
    const std::vector<GainEquation> equations = all_equations(data.clusters(loaded), columns);
    const double noise = solved(data, loaded, equations, columns).sigma.array().log().sum();
    if (!best.empty() && noise >= least) continue;
    best = loaded;
    least = noise;
  }
  GainFit fit = fit_gains(data, loads, best);
  if (direction(fit) >= 0.0) return fit;
  best.flip();
  return fit_gains(data, loads, best);
}

double direction(const GainFit& fit) {
  const VectorXd p = fit.solution.p();
  double sum = 0.0;
  for (Eigen::Index j = 0; j < fit.joints(); ++j) {
    const double t = p[j] / std::max(fit.p_deviation(j), 1e-300);
    sum += std::copysign(t * t, t);
  }
  return sum;
}

}  // namespace veridyn
