#include "diagnosis/causes/payload_fit.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "diagnosis/evidence/clustered_fit.hpp"
#include "diagnosis/numerics.hpp"
#include "math/student_t.hpp"

namespace veridyn {
namespace {

constexpr int kSteps = 60;

// || phi ||: phi' A phi - 2 b' phi + c over the ten parameters of the load, nuisances fitted.
struct Quadratic {
  MatrixXd A;
  VectorXd b;

  double cost(const VectorXd& phi) const { return phi.dot(A * phi) - 2.0 * b.dot(phi); }
};

struct Solution {
  InertialParameters phi = InertialParameters::Zero();
  double cost = 0.0;
  double mass() const { return phi[0]; }
  Eigen::Vector3d moment() const { return phi.segment<3>(1); }
};

InertialParameters point_mass(double mass, const Eigen::Vector3d& h) {
  InertialParameters phi;
  phi << mass, h, (h.y() * h.y() + h.z() * h.z()) / mass, -h.x() * h.y() / mass,
      (h.x() * h.x() + h.z() * h.z()) / mass, -h.x() * h.z() / mass, -h.y() * h.z() / mass,
      (h.x() * h.x() + h.y() * h.y()) / mass;
  return phi;
}

// Derivative of point_mass() by (ln m, h).
Eigen::Matrix<double, 10, 4> slopes(double mass, const Eigen::Vector3d& h) {
  Eigen::Matrix<double, 10, 4> J = Eigen::Matrix<double, 10, 4>::Zero();
  const InertialParameters phi = point_mass(mass, h);
  J(0, 0) = mass;
  J.block<6, 1>(4, 0) = -phi.segment<6>(4);
  for (int k = 0; k < 3; ++k) J(1 + k, 1 + k) = 1.0;
  const double x = h.x() / mass;
  const double y = h.y() / mass;
  const double z = h.z() / mass;
  J.block<6, 3>(4, 1) << 0.0, 2.0 * y, 2.0 * z,  // xx
      -y, -x, 0.0,                               // xy
      2.0 * x, 0.0, 2.0 * z,                     // yy
      -z, 0.0, -x,                               // xz
      0.0, -z, -y,                               // yz
      2.0 * x, 2.0 * y, 0.0;                     // zz
  return J;
}

// Levenberg and Marquardt from one start; the centre stays within `reach` of the frame.
Solution descend(const Quadratic& f, double mass, Eigen::Vector3d h, double reach) {
  const auto within = [&](const Eigen::Vector3d& moment, double of) -> Eigen::Vector3d {
    return moment.cwiseMin(of * reach).cwiseMax(-of * reach);
  };
  h = within(h, mass);
  Solution best{point_mass(mass, h), 0.0};
  best.cost = f.cost(best.phi);
  double damping = numerics::kFirstDamping;
  for (int step = 0; step < kSteps; ++step) {
    const Eigen::Matrix<double, 10, 4> J = slopes(mass, h);
    const Eigen::Vector4d g = J.transpose() * (f.b - f.A * best.phi);
    Eigen::Matrix4d H = J.transpose() * f.A * J;
    const Eigen::Vector4d scale = H.diagonal().cwiseMax(numerics::kNoise * H.diagonal().maxCoeff() + numerics::kTiny);
    H.diagonal() += damping * scale;
    const Eigen::Vector4d d = RidgedSolver(H).solve(g);
    const double next_mass =
        std::clamp(mass * std::exp(std::clamp(d[0], -1.0, 1.0)), numerics::kLightest, numerics::kHeaviest);
    const Eigen::Vector3d next_h = within(h + d.tail<3>(), next_mass);
    const InertialParameters phi = point_mass(next_mass, next_h);
    const double cost = f.cost(phi);
    if (!(cost < best.cost)) {
      damping *= numerics::kMoreDamping;
      if (damping > numerics::kMostDamping) break;
      continue;
    }
    const bool small = best.cost - cost < numerics::kConverged * std::abs(cost);
    mass = next_mass;
    h = next_h;
    best = {phi, cost};
    damping = std::max(damping * numerics::kLessDamping, numerics::kNoise);
    if (small) break;
  }
  return best;
}

std::vector<Solution> all_solutions(const Quadratic& f, const Eigen::Vector3d& h,
                                    double reach = numerics::kAnywhere) {
  std::vector<Solution> out;
  for (const double mass : numerics::kFirstMasses) {
    for (const double share : {1.0, numerics::kFirstPlaces, -numerics::kFirstPlaces}) out.push_back(descend(f, mass, share * h, reach));
  }
  return out;
}

// What the torques ask for beyond the point mass, about its centre; least squares, made possible
// (no negative moment of inertia).
Eigen::Matrix<double, 6, 1> extent(const Quadratic& f, const Solution& s) {
  MatrixXd A = f.A.bottomRightCorner(6, 6);
  A.diagonal() *= 1.0 + numerics::kLoadPrior;
  A.diagonal().array() += numerics::kTiny;
  return RidgedSolver(A).solve((f.b - f.A * s.phi).tail(6));
}

Solution fit_point(const Quadratic& f, const Solution* near, double reach = numerics::kAnywhere) {
  if (near != nullptr) return descend(f, near->mass(), near->moment(), reach);
  MatrixXd first = f.A.block(1, 1, 3, 3);
  first.diagonal() *= 1.0 + numerics::kLoadRidge;
  first.diagonal().array() += numerics::kTiny;
  const Eigen::Vector3d h = RidgedSolver(first).solve(f.b.segment(1, 3));
  Solution best;
  for (const Solution& s : all_solutions(f, h, reach)) {
    if (s.cost < best.cost) best = s;
  }
  return best;
}

// Largest distance of solutions from other starts that fit as well: where the torques leave a
// valley, every point of it is an answer.
template <typename Numbers, typename ToNumbers>
Numbers valley(const Quadratic& f, const Solution& best, const ToNumbers& numbers) {
  Numbers widest = Numbers::Zero();
  for (const Solution& s : all_solutions(f, best.moment())) {
    if (s.cost > best.cost + numerics::kAsGoodLoad * std::abs(best.cost)) continue;
    widest =
        widest.cwiseMax((numbers(s, extent(f, s)) - numbers(best, extent(f, best))).cwiseAbs());
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

  // Over the load's ten parameters, nuisances eliminated.
  Quadratic without(int cluster) const {
    const Quadratic sums = weighted(cluster);
    const Eigen::Index n = sums.b.size() - kBodyParameters;
    Quadratic out{sums.A.topLeftCorner(kBodyParameters, kBodyParameters),
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
    // Where the torques see nothing of a direction, the load lies at its zero.
    out.A.diagonal().segment(1, 3).array() += unseen_curvature(out);
    return out;
  }

  // Whether the torques see a load move along each axis of its frame: more than what holds it at
  // zero does.
  static std::array<bool, 3> seen(const Quadratic& f, const Solution& at) {
    const Eigen::Matrix<double, 10, 4> J = slopes(at.mass(), at.moment());
    const Eigen::Vector4d curvature = (J.transpose() * f.A * J).diagonal();
    const double most = curvature.tail<3>().maxCoeff();
    std::array<bool, 3> out{};
    for (size_t k = 0; k < out.size(); ++k)
      out[k] = curvature[static_cast<Eigen::Index>(k) + 1] > 2.0 * numerics::kUnseenLoad * most;
    return out;
  }

  // Squared residual per joint with this load, nuisances fitted beside it.
  VectorXd residual2(const InertialParameters& phi) const {
    const Quadratic sums = weighted(-1);
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

  static double unseen_curvature(const Quadratic& f) {
    return numerics::kUnseenLoad * f.A.diagonal().segment(1, 3).maxCoeff();
  }

  VectorXd scale() const {
    VectorXd out(kBodyParameters);
    for (int c = 0; c < kBodyParameters; ++c) out[c] = data_.scale()[load_[static_cast<size_t>(c)]];
    return out;
  }

  static RidgedSolver nuisance_solver(const Quadratic& sums) {
    const Eigen::Index n = sums.b.size() - kBodyParameters;
    return RidgedSolver(sums.A.bottomRightCorner(n, n), numerics::kLoadRidge);
  }

  // Weighted sums of all clusters but one (-1: of all), over load and nuisances, scaled columns.
  Quadratic weighted(int cluster) const {
    const ColumnSet columns = all();
    const auto k = static_cast<Eigen::Index>(columns.size());
    Quadratic out{MatrixXd::Zero(k, k), VectorXd::Zero(k)};
    for (int j = 0; j < data_.joints(); ++j) {
      const auto at = static_cast<size_t>(j);
      for (Eigen::Index r = 0; r < k; ++r) {
        const int row = columns[static_cast<size_t>(r)];
        out.b[r] += weights_[j] * (data_.total().g[at][row] -
                                   (cluster < 0 ? 0.0 : data_.cluster(cluster).g[at][row]));
        for (Eigen::Index c = 0; c < k; ++c) {
          const int column = columns[static_cast<size_t>(c)];
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

std::vector<ColumnSet> nuisance_sets(const Inquiry& q, const NormalBlocks& data,
                                     FrameIndex frame) {
  std::vector<ColumnSet> out(1);
  for (const std::string& effect : elementary_effects()) {
    ColumnSet next = out.back();
    for (const Hypothesis& h : q.augmented.hypotheses) {
      if (effect_of(h.cause) != effect || !h.joint || is_load(h)) continue;
      if (!q.augmented.model.moves(frame.value, h.joint->value)) continue;
      const Axis& axis = term_of(q.augmented.model, h).axis;
      if ((axis.coefficients.array() != 0.0).count() != 1) continue;
      const ColumnSet own = columns_of(data, h);
      next.insert(next.end(), own.begin(), own.end());
    }
    out.push_back(next);
  }
  return out;
}

PayloadEstimate fit_payload(const Inquiry& q, const NormalBlocks& data, const Hypothesis& payload) {
  const FrameIndex frame = *frame_of(payload.cause);
  const std::vector<ColumnSet> sets = nuisance_sets(q, data, frame);
  ColumnSet all = columns_of(data, payload);
  all.insert(all.end(), sets.back().begin(), sets.back().end());
  const VectorXd w = joint_weights(data, all);
  const LoadProblem problem(data, payload, sets.back(), w);
  const Quadratic whole = problem.without(-1);
  const Solution main = fit_point(whole, nullptr);
  PayloadEstimate out;
  out.frame = q.augmented.model.frames()[static_cast<size_t>(frame.value)].name;
  out.phi = main.phi;
  out.mass = main.mass();
  out.moment = main.moment();
  out.com =
      main.mass() > 0.0 ? Eigen::Vector3d(main.moment() / main.mass()) : Eigen::Vector3d::Zero();
  const Eigen::Matrix<double, 6, 1> beyond = extent(whole, main);
  out.inertia = possible(beyond);
  // Scatter between phases, and between what else may have changed with the load.
  const int clusters = data.clusters();
  using Numbers = Eigen::Matrix<double, 13, 1>;
  const auto numbers = [](const Solution& s, const Eigen::Matrix<double, 6, 1>& L) {
    Numbers v;
    v << s.mass(), s.moment(), s.moment() / std::max(s.mass(), numerics::kSameAxis), L;
    return v;
  };
  const Numbers centre = numbers(main, beyond);
  MatrixXd without(kBodyParameters + 3, clusters);
  for (int c = 0; c < clusters; ++c) {
    const Quadratic f = problem.without(c);
    const Solution s = fit_point(f, &main);
    without.col(c) = numbers(s, extent(f, s));
  }
  const Numbers variance = jackknife_deviations(without).cwiseAbs2();
  Numbers drift = valley<Numbers>(whole, main, numbers);
  for (size_t k = 0; k + 1 < sets.size(); ++k) {
    const Quadratic f = LoadProblem(data, payload, sets[k], w).without(-1);
    const Solution s = fit_point(f, &main);
    drift = drift.cwiseMax((numbers(s, extent(f, s)) - centre).cwiseAbs());
  }
  const double t = student_t_quantile(numerics::kOutside, std::max(1, clusters - 1));
  const Numbers half = (t * t * variance + drift.cwiseAbs2()).cwiseSqrt();
  out.mass_low = std::max(0.0, out.mass - half[0]);
  out.mass_high = out.mass + half[0];
  out.moment_half_width = half.segment<3>(1);
  out.com_half_width = half.segment<3>(4);
  out.inertia_half_width = half.tail<6>();
  out.seen = LoadProblem::seen(whole, main);
  for (int k = 0; k < 3; ++k) {
    if (out.seen[static_cast<size_t>(k)]) continue;
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
  const Quadratic f = LoadProblem(data, payload, beside, weights).without(-1);
  MatrixXd A = f.A;
  A.diagonal() *= 1.0 + numerics::kLoadRidge;
  A.diagonal().array() += numerics::kTiny;
  const double free = f.b.dot(RidgedSolver(A).solve(f.b));
  return free > 0.0 ? std::clamp(-fit_point(f, nullptr, payload.reach).cost / free, 0.0, 1.0) : 0.0;
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
      BB[r] += G(B[static_cast<size_t>(r)], B[static_cast<size_t>(r)]);
      for (Eigen::Index c = 0; c < k; ++c) {
        AA(r, c) += G(A[static_cast<size_t>(r)], A[static_cast<size_t>(c)]);
        AB(r, c) += G(A[static_cast<size_t>(r)], B[static_cast<size_t>(c)]);
      }
    }
  }
  AA.diagonal() *= 1.0 + numerics::kLoadRidge;
  const VectorXd spanned = (AB.transpose() * RidgedSolver(AA).solve_columns(AB)).diagonal();
  return ((BB - spanned).array() <= numerics::kSameSpan * BB.array()).all();
}

}  // namespace veridyn
