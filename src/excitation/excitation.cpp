#include "veridyn/excitation/excitation.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "column_names.hpp"
#include "motion_search.hpp"
#include "slow_passes.hpp"
#include "veridyn/math/most_rows.hpp"
#include "veridyn/math/parallel.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr double kNamedPart = 0.1;  // of a direction of norm one

void check(const ExcitationOptions& o) {
  require(o.frequency > 0.0 && std::isfinite(o.frequency), "excitation: found a frequency of ",
          o.frequency, " Hz, expected a positive one.");
  require(o.harmonics >= 2, "excitation: found ", o.harmonics,
          " harmonics, expected at least 2: a single wave cannot start at rest.");
  require(o.duration > 0.0 && o.duration < 1e6, "excitation: found a duration of ", o.duration,
          " s, expected a positive one.");
  require(o.rate > 2.0 * o.frequency * o.harmonics && o.rate <= 1e5, "excitation: found a rate of ",
          o.rate, " Hz, expected more than twice the highest harmonic, ",
          2.0 * o.frequency * o.harmonics, " Hz, and at most 1e5 Hz.");
  require(o.starts >= 1 && o.iterations >= 1, "excitation: found ", o.starts, " starts of ",
          o.iterations, " iterations, expected at least one of each.");
  require(o.limit_share > 0.0 && o.limit_share <= 1.0, "excitation: found a limit share of ",
          o.limit_share, ", expected above 0 and at most 1.");
  require(o.slow_passes >= 0 && o.slow_passes <= 100, "excitation: found ", o.slow_passes,
          " slow passes, expected 0 to 100.");
  require(has_solver(o.solver), "excitation: this build has no ", name_of(o.solver),
          "; random is always there.");
}

// What may be used of the joints' limits: a share of speed and acceleration, the middle of the
// range.
MotionLimits share_of(MotionLimits limits, double share) {
  const VectorXd edge = 0.5 * (1.0 - share) * (limits.upper - limits.lower);
  limits.lower += edge;
  limits.upper -= edge;
  limits.velocity *= share;
  limits.acceleration *= share;
  return limits;
}

// The arm whose values are known, if one is.
std::optional<Model> with_values(const Model& arm, const ExcitationOptions& options) {
  if (options.powered) return options.powered;
  if (arm.inertial_values()) return arm;
  return std::nullopt;
}

// Whether a motion keeps all limits.
std::function<bool(const MotionSamples&)> within_limits(const LimitSignals& signals) {
  return [&signals](const MotionSamples& motion) {
    const std::vector<LimitMargin> margins = limit_margins(signals, motion);
    return std::all_of(margins.begin(), margins.end(),
                       [](const LimitMargin& m) { return m.margin >= 0.0; });
  };
}

// Those that the rivals are on, each once, or else all.
std::vector<int> slow_joints(const Question& question, const Model& arm) {
  const std::set<int> asked(question.rival_joints.begin(), question.rival_joints.end());
  if (!asked.empty()) return {asked.begin(), asked.end()};
  std::vector<int> all(static_cast<size_t>(arm.joints()));
  std::iota(all.begin(), all.end(), 0);
  return all;
}

double range_condition_number(const MatrixXd& W) {
  const VectorXd range = (W.colwise().maxCoeff() - W.colwise().minCoeff()).transpose();
  if (!(range.minCoeff() > 0.0)) return std::numeric_limits<double>::infinity();
  const MatrixXd scaled = W * range.cwiseInverse().asDiagonal();
  return plain_condition_number(scaled.transpose() * scaled);
}

// Of the smallest eigenvalue of the Gram matrix, columns of norm one.
std::vector<std::pair<std::string, double>> weakest_direction(const MatrixXd& gram,
                                                              const BaseRegressor& regressor,
                                                              const Model& arm) {
  const VectorXd d = gram.diagonal().cwiseSqrt().cwiseMax(1e-100).cwiseInverse();
  const MatrixXd scaled = d.asDiagonal() * gram * d.asDiagonal();
  const VectorXd direction = Eigen::SelfAdjointEigenSolver<MatrixXd>(scaled).eigenvectors().col(0);
  const std::vector<ColumnName> names = column_names(arm);
  std::vector<std::pair<std::string, double>> out;
  for (int b = 0; b < regressor.size(); ++b) {
    const auto column = static_cast<size_t>(regressor.base()[static_cast<size_t>(b)]);
    if (std::abs(direction[b]) > kNamedPart) out.emplace_back(names[column].name, direction[b]);
  }
  std::sort(out.begin(), out.end(),
            [](const auto& a, const auto& b) { return std::abs(a.second) > std::abs(b.second); });
  return out;
}

Discrimination discrimination(const Question& question, const MatrixXd& gram,
                              const ExcitationOptions& options) {
  const auto label = [](const RivalCause& r) {
    return r.place.empty() ? r.effect : r.effect + ":" + r.place;
  };
  Discrimination out;
  out.first = label(options.between->first);
  out.second = label(options.between->second);
  const auto [first, second] = rivals_left(gram, question.scale, question.rivals);
  const auto share = [](const RivalLeft& r) {
    return r.alone > 0.0 ? std::sqrt(r.left / r.alone) : 0.0;
  };
  out.first_left = std::sqrt(first.left);
  out.second_left = std::sqrt(second.left);
  out.first_share = share(first);
  out.second_share = share(second);
  out.bodies_known = question.bodies_known;
  return out;
}

}  // namespace

Excitation optimise_excitation(const Model& arm, const ExcitationOptions& options) {
  check(options);
  const auto begun = std::chrono::steady_clock::now();
  require(arm.joints() >= 1, "excitation: the arm '", arm.name(), "' has no coordinates.");
  const BaseRegressor exact(arm);
  const BaseRegressor rounded(arm, kRounding);
  require(exact.size() >= 1, "excitation: the torques of '", arm.name(),
          "' depend on no parameters: it has neither bodies nor effects.");
  // The regressor of the whole motion: base columns, and perhaps three times as many others.
  const double most = std::floor(most_rows(4.0 * arm.joints() * exact.size()));
  require(options.duration * options.rate < most, "excitation: found ", options.duration, " s at ",
          options.rate, " Hz, expected fewer than ", most, " rows, what this machine holds.");
  const int periods =
      std::max(2, static_cast<int>(std::lround(options.duration * options.frequency)));
  const MotionLimits limits = motion_limits(arm);
  const MotionSpace space(share_of(limits, options.limit_share), options.harmonics,
                          options.frequency);
  const LimitSignals signals(arm, limits, options.workspace, with_values(arm, options));
  const Question question =
      make_question(arm, exact, rounded, options, periods / options.frequency);
  const bool stages = options.criterion == ExcitationCriterion::kCondition;
  SearchProgress progress(options.progress, options.starts,
                          (stages ? kStages : 1) * options.iterations);
  const MotionSearch search(space, signals, question, options, progress);

  const auto verdict = [&](const FourierTrajectory& t) {
    const MotionSamples motion = t.motion(periods, options.rate);
    return MatrixXd(question.exact->gram(motion, question.row_weights) /
                        static_cast<double>(motion.rows()) +
                    question.exact_given);
  };
  std::vector<Found> found(static_cast<size_t>(options.starts));
  if (options.progress) options.progress("searching", 0.0);
  parallel_for(options.starts, options.threads, [&](int start) {
    Found& own = found[static_cast<size_t>(start)];
    own = search.run(start);
    own.cost = std::numeric_limits<double>::infinity();
    if (own.x.size() > 0) own.cost = question.verdict(verdict(space.trajectory(own.x)));
  });
  if (options.progress) options.progress("searching", 1.0);
  Found& best = *std::min_element(found.begin(), found.end(), [](const Found& a, const Found& b) {
    return std::make_pair(a.x.size() == 0, a.cost) < std::make_pair(b.x.size() == 0, b.cost);
  });

  const bool within = best.x.size() > 0;
  if (within && !(options.stop && options.stop())) {
    const VectorXd last = search.polished(best);
    const double cost =
        last.size() > 0 ? question.verdict(verdict(space.trajectory(last))) : best.cost;
    if (cost < best.cost) {
      best.x = last;
      best.cost = cost;
    }
  }
  Excitation out{within ? ExcitationStatus::kDone : ExcitationStatus::kLimitsNotMet, arm.name(),
                 options.criterion, options.solver,
                 space.trajectory(within ? best.x : best.nearest)};
  out.periods = periods;
  out.base_parameters = exact.size();
  const MotionSamples motion = out.trajectory.motion(periods, options.rate);
  out.margins = limit_margins(signals, out.trajectory);
  const MotionSamples passes =
      within ? slow_passes(space.limits(), motion.q.row(0).transpose(), slow_joints(question, arm),
                           options.slow_passes, options.rate, within_limits(signals))
             : MotionSamples();
  if (passes.rows() > 0) {
    out.margins = joined(out.margins, limit_margins(signals, passes));
    out.slow_seconds = passes.time[passes.rows() - 1];
  }
  out.motion = joined(motion, passes);
  const MatrixXd gram = exact.gram(motion) / static_cast<double>(motion.rows());
  out.condition_number = scaled_condition_number(gram);
  out.plain_condition_number = plain_condition_number(gram);
  out.range_condition_number = range_condition_number(exact.stacked(motion));
  MatrixXd with_given = gram;
  for (const MotionSamples& motion_before : options.given) {
    const auto rows = static_cast<double>(motion_before.rows());
    const double lasts = motion_before.time[motion_before.rows() - 1] - motion_before.time[0];
    with_given += lasts / (periods / options.frequency) / rows * exact.gram(motion_before);
  }
  out.condition_number_with_given = scaled_condition_number(with_given);
  const MatrixXd& basis = exact.orthogonal_basis();
  out.orthogonal_condition_number = scaled_condition_number(basis.transpose() * gram * basis);
  out.log_determinant = log_determinant(gram, exact.scale());
  out.weakest = weakest_direction(gram, exact, arm);
  const std::optional<Model> known = options.valued ? options.valued : with_values(arm, options);
  if (known) {
    out.prediction = predict_identification(
        *known, out.motion, options.noise.value_or(usual_noise(*known)), options.given);
  }
  const MotionSamples random = space.trajectory(found.front().start).motion(periods, options.rate);
  out.start_condition_number = scaled_condition_number(exact.gram(random));
  for (const Found& f : found) out.evaluations += f.evaluations;
  if (options.between && options.criterion == ExcitationCriterion::kDiscriminate) {
    out.discrimination = discrimination(question, verdict(out.trajectory), options);
  }
  if (within && !std::isfinite(best.cost)) out.status = ExcitationStatus::kRankDeficient;
  out.interrupted = options.stop && options.stop();
  out.converged = best.converged;
  out.bounds = out.trajectory.bounds();
  out.limits = {limits.lower, limits.upper, limits.velocity, limits.acceleration};
  for (const Coordinate& coordinate : arm.coordinates()) {
    out.joints.push_back(coordinate.name);
    out.units.push_back(position_unit(coordinate));
  }
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return out;
}

}  // namespace veridyn
