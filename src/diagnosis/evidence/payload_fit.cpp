#include "diagnosis/evidence/payload_fit.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "diagnosis/evidence/point_load.hpp"
#include "diagnosis/evidence/clustered_fit.hpp"
#include "diagnosis/evidence/examiner.hpp"
#include "diagnosis/evidence/folds.hpp"
#include "diagnosis/evidence/numerics.hpp"
#include "math/student_t.hpp"

namespace veridyn {
namespace {

// Largest distance of solutions from other starts that fit as well: where the torques leave a
// valley, every point of it is an answer.
template <typename Numbers, typename ToNumbers>
Numbers valley(const LoadCost& f, const PointLoad& best, const ToNumbers& numbers) {
  Numbers widest = Numbers::Zero();
  for (const PointLoad& s : all_point_loads(f, best.moment())) {
    if (s.cost > best.cost + numerics::kAsGoodLoad * std::abs(best.cost)) continue;
    widest = widest.cwiseMax(
        (numbers(s, load_extent(f, s)) - numbers(best, load_extent(f, best))).cwiseAbs());
  }
  return widest;
}

// The fit of one load beside nuisances.
class LoadProblem {
 public:
  LoadProblem(const NormalBlocks& data, const Hypothesis& payload, ColumnSet nuisances,
              VectorXd weights)
      : data_(data), nuisances_(std::move(nuisances)), weights_(std::move(weights)) {
    for (const std::string& name : payload.columns) {
      const auto found = std::find(data.names().begin(), data.names().end(), name);
      load_.push_back(static_cast<int>(found - data.names().begin()));
    }
  }

  // Cost over the load's ten parameters, nuisances eliminated.
  LoadCost without(int cluster) const {
    const LoadCost sums = weighted(cluster);
    const Eigen::Index n = sums.b.size() - kBodyParameters;
    LoadCost out{sums.A.topLeftCorner(kBodyParameters, kBodyParameters),
                  sums.b.head(kBodyParameters)};
    if (n > 0) {
      const MatrixXd C = sums.A.topRightCorner(kBodyParameters, n);
      const RidgedSolver solver = nuisance_solver(sums);
      out.A -= C * solver.solve_columns(C.transpose());
      out.b -= C * solver.solve(sums.b.tail(n));
    }
    const VectorXd s = scale();
    out.A = s.asDiagonal() * out.A * s.asDiagonal();
    out.b = s.asDiagonal() * out.b;
    // In an unobservable direction the load is placed at zero.
    out.A.diagonal().segment(1, 3).array() += unseen_curvature(out);
    return out;
  }

  // Squared residual per joint with this load, nuisances fitted beside it.
  VectorXd residual2(const InertialParameters& phi) const {
    const LoadCost sums = weighted(-1);
    const Eigen::Index n = sums.b.size() - kBodyParameters;
    VectorXd x(sums.b.size());
    x.head(kBodyParameters) = scale().cwiseProduct(phi);
    if (n > 0) {
      x.tail(n) = nuisance_solver(sums).solve(
          sums.b.tail(n) - sums.A.bottomLeftCorner(n, kBodyParameters) * x.head(kBodyParameters));
    }
    return data_.residual2(all(), x, data_.total());
  }

 private:
  ColumnSet all() const {
    ColumnSet out = load_;
    out.insert(out.end(), nuisances_.begin(), nuisances_.end());
    return out;
  }

  static double unseen_curvature(const LoadCost& f) {
    return numerics::kUnseenLoad * f.A.diagonal().segment(1, 3).maxCoeff();
  }

  VectorXd scale() const {
    VectorXd out(kBodyParameters);
    for (int c = 0; c < kBodyParameters; ++c) out[c] = data_.scale()[load_[c]];
    return out;
  }

  static RidgedSolver nuisance_solver(const LoadCost& sums) {
    const Eigen::Index n = sums.b.size() - kBodyParameters;
    return RidgedSolver(sums.A.bottomRightCorner(n, n));
  }

  // Weighted sums of all clusters but one (-1: of all), over load and nuisances, scaled columns.
  LoadCost weighted(int cluster) const {
    const ColumnSet columns = all();
    const auto k = static_cast<Eigen::Index>(columns.size());
    LoadCost out{MatrixXd::Zero(k, k), VectorXd::Zero(k)};
    for (int j = 0; j < data_.joints(); ++j) {
      const auto at = static_cast<size_t>(j);
      for (Eigen::Index r = 0; r < k; ++r) {
        const int row = columns[r];
        out.b[r] += weights_[j] * (data_.total().g[at][row] -
                                   (cluster < 0 ? 0.0 : data_.cluster(cluster).g[at][row]));
        for (Eigen::Index c = 0; c < k; ++c) {
          const int column = columns[c];
          out.A(r, c) +=
              weights_[j] * (data_.total().G[at](row, column) -
                             (cluster < 0 ? 0.0 : data_.cluster(cluster).G[at](row, column)));
        }
      }
    }
    return out;
  }

  const NormalBlocks& data_;
  ColumnSet load_;
  ColumnSet nuisances_;
  VectorXd weights_;
};

Eigen::Matrix<double, 6, 1> possible(const Eigen::Matrix<double, 6, 1>& L) {
  Eigen::Matrix3d I;
  I << L[0], L[1], L[3], L[1], L[2], L[4], L[3], L[4], L[5];
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(I);
  const Eigen::Matrix3d P = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
                            eigen.eigenvectors().transpose();
  Eigen::Matrix<double, 6, 1> out;
  out << P(0, 0), P(0, 1), P(1, 1), P(0, 2), P(1, 2), P(2, 2);
  return out;
}

}  // namespace

std::vector<ColumnSet> nuisance_sets(const AugmentedModel& asked, const NormalBlocks& data,
                                     FrameIndex frame) {
  std::vector<ColumnSet> out(1);
  for (const std::string& effect : elementary_effects()) {
    ColumnSet next = out.back();
    for (const Hypothesis& h : asked.hypotheses) {
      if (effect_of(h.cause) != effect || !h.joint || is_load(h)) continue;
      if (!asked.model.moves(frame.value, h.joint->value)) continue;
      const Axis& axis = term_of(asked.model, h).axis;
      if ((axis.coefficients.array() != 0.0).count() != 1) continue;
      const ColumnSet own = columns_of(data, h);
      next.insert(next.end(), own.begin(), own.end());
    }
    out.push_back(next);
  }
  return out;
}

PayloadEstimate fit_payload(const AugmentedModel& asked, const NormalBlocks& data,
                            const Hypothesis& payload, BesideLoad beside) {
  const FrameIndex frame = *frame_of(payload.cause);
  std::vector<ColumnSet> sets = nuisance_sets(asked, data, frame);
  if (beside == BesideLoad::kNothing) sets.resize(1);
  ColumnSet all = columns_of(data, payload);
  all.insert(all.end(), sets.back().begin(), sets.back().end());
  const VectorXd w = joint_weights(data, all);
  const LoadProblem problem(data, payload, sets.back(), w);
  const LoadCost whole = problem.without(-1);
  const PointLoad main = fit_point_load(whole, nullptr);
  PayloadEstimate out;
  out.frame = asked.model.frames()[frame.value].name;
  out.phi = main.phi;
  out.mass = main.mass();
  out.moment = main.moment();
  out.com =
      main.mass() > 0.0 ? Eigen::Vector3d(main.moment() / main.mass()) : Eigen::Vector3d::Zero();
  const Eigen::Matrix<double, 6, 1> beyond = load_extent(whole, main);
  out.inertia = possible(beyond);
  // Scatter between phases, and between what else may have changed with the load.
  const int clusters = data.clusters();
  using Numbers = Eigen::Matrix<double, 13, 1>;
  const auto numbers = [](const PointLoad& s, const Eigen::Matrix<double, 6, 1>& L) {
    Numbers v;
    v << s.mass(), s.moment(), s.moment() / std::max(s.mass(), numerics::kSameAxis), L;
    return v;
  };
  const Numbers centre = numbers(main, beyond);
  MatrixXd without(kBodyParameters + 3, clusters);
  for (int c = 0; c < clusters; ++c) {
    const LoadCost f = problem.without(c);
    const PointLoad s = fit_point_load(f, &main);
    without.col(c) = numbers(s, load_extent(f, s));
  }
  const Numbers variance = jackknife_deviations(without).cwiseAbs2();
  Numbers drift = valley<Numbers>(whole, main, numbers);
  for (size_t k = 0; k + 1 < sets.size(); ++k) {
    const LoadCost f = LoadProblem(data, payload, sets[k], w).without(-1);
    const PointLoad s = fit_point_load(f, &main);
    drift = drift.cwiseMax((numbers(s, load_extent(f, s)) - centre).cwiseAbs());
  }
  const double t = student_t_quantile(numerics::kOutside, std::max(1, clusters - 1));
  const Numbers half = (t * t * variance + drift.cwiseAbs2()).cwiseSqrt();
  out.mass_low = std::max(0.0, out.mass - half[0]);
  out.mass_high = out.mass + half[0];
  out.moment_half_width = half.segment<3>(1);
  out.com_half_width = half.segment<3>(4);
  out.inertia_half_width = half.tail<6>();
  out.seen = seen_directions(whole, main);
  for (int k = 0; k < 3; ++k) {
    if (out.seen[k]) continue;
    out.com_half_width[k] = payload.reach;
    out.moment_half_width[k] = out.mass_high * payload.reach;
  }
  const VectorXd drift_only = problem.residual2(InertialParameters::Zero());
  const double weighted = w.dot(drift_only);
  out.explained = weighted > 0.0 ? -main.cost / weighted : 0.0;
  const VectorXd as_it_stands = data.total().b2.cwiseMax(numerics::kTiny);
  out.error_with_drift = (drift_only.array() / as_it_stands.array()).sqrt();
  out.error_with_load = (problem.residual2(main.phi).array() / as_it_stands.array()).sqrt();
  return out;
}

double compact_share(const NormalBlocks& data, const Hypothesis& payload, const ColumnSet& beside,
                     const VectorXd& weights) {
  const LoadCost f = LoadProblem(data, payload, beside, weights).without(-1);
  const double free = f.b.dot(RidgedSolver(f.A).solve(f.b));
  return free > 0.0 ? std::clamp(-fit_point_load(f, nullptr, payload.reach).cost / free, 0.0, 1.0)
                    : 0.0;
}

bool same_torques(const NormalBlocks& data, const Hypothesis& a, const Hypothesis& b) {
  const ColumnSet A = columns_of(data, a);
  const ColumnSet B = columns_of(data, b);
  if (A.size() != B.size() || A.empty()) return false;
  const auto k = static_cast<Eigen::Index>(A.size());
  MatrixXd AA = MatrixXd::Zero(k, k);
  MatrixXd AB = AA;
  VectorXd BB = VectorXd::Zero(k);
  for (const JointSquares& G : data.total().G) {
    for (Eigen::Index r = 0; r < k; ++r) {
      BB[r] += G(B[r], B[r]);
      for (Eigen::Index c = 0; c < k; ++c) {
        AA(r, c) += G(A[r], A[c]);
        AB(r, c) += G(A[r], B[c]);
      }
    }
  }
  const VectorXd spanned = (AB.transpose() * RidgedSolver(AA).solve_columns(AB)).diagonal();
  return ((BB - spanned).array() <= numerics::kSameSpan * BB.array()).all();
}

}  // namespace veridyn
