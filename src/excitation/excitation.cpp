#include "veridyn/excitation/excitation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "candidates.hpp"
#include "math/random_numbers.hpp"
#include "veridyn/excitation/base_regressor.hpp"
#include "veridyn/kinematics/motion_limits.hpp"
#include "veridyn/math/parallel.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr int kInstants = 150;    // of one period, at which the criterion looks
constexpr int kRandomDraws = 20;  // before each local search
constexpr double kStepUp =
    1.5;  // after a success; 1.5 * 0.9^4 is about one: one success in five keeps the step
constexpr double kStepDown = 0.9;
constexpr double kFewChanges = 8.0;  // variables that one step changes, on average

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
  require(o.duration * o.rate <= 1e8, "excitation: ", o.duration, " s at ", o.rate,
          " Hz are too many rows.");
  require(o.starts >= 1 && o.evaluations >= 1, "excitation: found ", o.starts, " starts of ",
          o.evaluations, " evaluations, expected at least one of each.");
  require(o.limit_share > 0.0 && o.limit_share <= 1.0, "excitation: found a limit share of ",
          o.limit_share, ", expected above 0 and at most 1.");
}

class Objective {
 public:
  Objective(const Model& arm, const ExcitationOptions& options)
      : regressor_(arm),
        basis_(period_instants(options.frequency, kInstants), options.frequency, options.harmonics),
        criterion_(options.criterion) {}

  int base_parameters() const { return regressor_.size(); }
  MatrixXd gram(const FourierTrajectory& t) const {
    return regressor_.gram(t.samples(basis_)) / kInstants;
  }
  double condition_number(const FourierTrajectory& t) const {
    return scaled_condition_number(gram(t));
  }
  double log_determinant_of(const FourierTrajectory& t) const {
    return log_determinant(gram(t), regressor_.scale());
  }

  // Smaller is better.
  double cost(const FourierTrajectory& t) const {
    return criterion_ == ExcitationCriterion::kCondition ? std::log(condition_number(t))
                                                         : -log_determinant_of(t);
  }

 private:
  BaseRegressor regressor_;
  FourierBasis basis_;
  ExcitationCriterion criterion_;
};

struct Found {
  VectorXd x;
  double cost = std::numeric_limits<double>::infinity();
  double start_condition_number = 0.0;
};

Found search(const Candidates& candidates, const Objective& objective,
             const ExcitationOptions& options, int start) {
  RandomNumbers random(options.seed, static_cast<unsigned>(start));
  Found best;
  const int draws = std::min(kRandomDraws, options.evaluations);
  for (int k = 0; k < draws; ++k) {
    const VectorXd x = candidates.random(random);
    const FourierTrajectory trajectory = candidates.trajectory(x);
    const double cost = objective.cost(trajectory);
    if (k == 0) best.start_condition_number = objective.condition_number(trajectory);
    if (k == 0 || cost < best.cost) {
      best.x = x;
      best.cost = cost;
    }
  }
  double step = 0.5;
  const double chance = std::min(1.0, kFewChanges / candidates.size());
  for (int k = draws; k < options.evaluations; ++k) {
    VectorXd x = best.x;
    for (double& value : x) {
      if (random.uniform() < chance) value += step * random.normal();
    }
    const double cost = objective.cost(candidates.trajectory(x));
    const bool better = cost < best.cost;
    step = std::clamp(step * (better ? kStepUp : kStepDown), 1e-3, 2.0);
    if (!better) continue;
    best.x = std::move(x);
    best.cost = cost;
  }
  return best;
}

}  // namespace

Excitation optimise_excitation(const Model& arm, const ExcitationOptions& options) {
  check(options);
  require(arm.joints() >= 1, "excitation: the arm '", arm.name(), "' has no coordinates.");
  const Candidates candidates(arm, options);
  const Objective objective(arm, options);
  require(objective.base_parameters() >= 1, "excitation: the torques of '", arm.name(),
          "' depend on no parameters: it has neither bodies nor effects.");
  std::vector<Found> found(static_cast<size_t>(options.starts));
  if (options.progress) options.progress("searching", 0.0);
  parallel_for(options.starts, options.threads, [&](int start) {
    found[static_cast<size_t>(start)] = search(candidates, objective, options, start);
  });
  if (options.progress) options.progress("searching", 1.0);
  const Found& best = *std::min_element(
      found.begin(), found.end(), [](const Found& a, const Found& b) { return a.cost < b.cost; });

  const MotionLimits limits = motion_limits(arm);
  Excitation out{ExcitationStatus::kDone, arm.name(), options.criterion,
                 candidates.trajectory(best.x)};
  out.periods = std::max(2, static_cast<int>(std::lround(options.duration * options.frequency)));
  out.base_parameters = objective.base_parameters();
  out.condition_number = objective.condition_number(out.trajectory);
  out.log_determinant = objective.log_determinant_of(out.trajectory);
  out.start_condition_number = found.front().start_condition_number;
  out.evaluations = static_cast<long>(options.starts) * options.evaluations;
  if (!std::isfinite(out.condition_number)) out.status = ExcitationStatus::kRankDeficient;
  out.bounds = out.trajectory.bounds();
  out.limits = {limits.lower, limits.upper, limits.velocity, limits.acceleration};
  for (const Coordinate& coordinate : arm.coordinates()) {
    out.joints.push_back(coordinate.name);
    out.units.push_back(position_unit(coordinate));
  }
  return out;
}

}  // namespace veridyn
