#include "veridyn/excitation/excitation.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <set>
#include <utility>

#include "excitation/cautions.hpp"
#include "motion_quality.hpp"
#include "excitation/search/motion_search.hpp"
#include "slow_passes.hpp"
#include "math/most_rows.hpp"
#include "math/numbers.hpp"
#include "math/parallel.hpp"
#include "veridyn/identification/base_parameters.hpp"
#include "veridyn/regressor/standard_parameters.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr double kUsualShare = 0.01;  // share of essential parameters that is reported by default
// Distance from a bound, relative to the limit's size, below which the limit is active.
constexpr double kClose = 0.06;
constexpr double kSmallestSize = 0.1;  // [m] smallest size of a one-sided limit; else the size is its bound's
constexpr int kRounds = 3;            // rounds of new base columns and descents

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
  const double share = o.limit_share.value_or(1.0);
  require(share > 0.0 && share <= 1.0, "excitation: found a limit share of ", share,
          ", expected above 0 and at most 1.");
  require(o.speed > 0.0 && o.speed <= 1.0, "excitation: found a speed of ", o.speed,
          ", expected above 0 and at most 1, the share of the designed one.");
  require(o.braking > 0.0, "excitation: found a braking of ", o.braking, " 1/s, expected above 0.");
  require(o.essential >= 0.0 && o.essential < 1.0, "excitation: found an essential share of ",
          o.essential, ", expected 0 to 1.");
  require(
      o.essential == 0.0 || o.criterion != ExcitationCriterion::kDiscriminate,
      "excitation: found essential parameters with the criterion discriminate, which asks about "
      "rivals.");
  require(o.slow_passes >= 0 && o.slow_passes <= 100, "excitation: found ", o.slow_passes,
          " slow passes, expected 0 to 100.");
}

// Share of a range between MotionCheck's margins at both ends.
constexpr double kRangeOfSupervisor = 1.0 - 2.0 * 0.0025;
// A supervisor stops an arm at its speed limit, and the loop overshoots: a PID on psm-3dof exceeds the wanted
// peak by 1.5 %, noise included (simulate --controller pid --noise dvrk on a 0.1 Hz motion).
constexpr double kSpeedOfSupervisor = 0.98;

// The part of the joints' limits to use: a share of speed and acceleration, the middle of the range.
MotionLimits share_of(MotionLimits limits, const ExcitationOptions& options) {
  const std::optional<double>& share = options.limit_share;
  const VectorXd edge =
      0.5 * (1.0 - share.value_or(kRangeOfSupervisor)) * (limits.upper - limits.lower);
  limits.lower += edge;
  limits.upper -= edge;
  limits.velocity *= share.value_or(kSpeedOfSupervisor);
  limits.acceleration *= share.value_or(1.0);
  return limits;
}

// Active limits of a joint other than its own range and speed, and those that couple it to other joints.
UsedLimits used_limits(const std::vector<LimitMargin>& margins, JointIndex joint) {
  UsedLimits out{kNaN, kNaN, kNaN};
  for (const LimitMargin& m : margins) {
    if (m.joint && m.joint != joint) continue;
    const double size = m.upper - m.lower;
    const double largest = std::max(std::abs(m.lowest), std::abs(m.highest));
    if (m.kind == LimitKind::kPosition) out.range = (m.highest - m.lowest) / size;
    if (m.kind == LimitKind::kSpeed) out.velocity = largest / m.upper;
    if (m.kind == LimitKind::kTorque) out.effort = largest / m.upper;
    const double scale = std::isfinite(size) ? size : std::max(kSmallestSize, std::abs(std::isfinite(m.lower) ? m.lower : m.upper));
    if (m.margin < kClose * scale) out.held_by.push_back(m.name);
  }
  return out;
}

// The arm with values, if there is one.
std::optional<Model> with_values(const Model& arm, const ExcitationOptions& options) {
  if (options.powered) return options.powered;
  if (arm.inertial_values()) return arm;
  return std::nullopt;
}

// The parameters that a later identification of the arm will report.
std::vector<int> reported_base(const Model& arm) {
  const std::vector<int> free = identifiable_base_parameters(arm).independent;
  return free.empty() ? base_parameters(arm).independent : free;
}

bool have_same_parameters(const Model& a, const Model& b) {
  return parameter_names(standard_parameters(a)) == parameter_names(standard_parameters(b));
}

// A function that is true for a motion within all limits.
std::function<bool(const MotionSamples&)> within_limits(const LimitSignals& signals) {
  return [&signals](const MotionSamples& motion) {
    const std::vector<LimitMargin> margins = limit_margins(signals, motion);
    return std::all_of(margins.begin(), margins.end(),
                       [](const LimitMargin& m) { return m.margin >= 0.0; });
  };
}

// Joints that make slow passes: those of the two causes, each once; without causes all joints.
std::vector<int> slow_joints(const Question& question, const Model& arm) {
  const std::set<int> asked(question.rival_joints.begin(), question.rival_joints.end());
  if (!asked.empty()) return {asked.begin(), asked.end()};
  std::vector<int> all(arm.joints());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

// A question together with the regressors of the base columns that it is about.
struct Asked {
  Asked(const Model& arm, const std::vector<int>& columns, const ExcitationOptions& options,
        double seconds)
      : exact(arm, columns),
        rounded(arm, exact.base(), kRounding),
        question(make_question(arm, exact, rounded, options, seconds)) {}

  BaseRegressor exact, rounded;
  Question question;
};

// Runs the searches from all starts and describes the best motion that they find.
class Design {
 public:
  Design(const Model& arm, const ExcitationOptions& options, const NonlinearSolver& solver)
      : arm_(arm),
        options_(options),
        solver_(solver),
        periods_(std::max(2, static_cast<int>(std::lround(options.duration * options.frequency)))),
        limits_(motion_limits(arm)),
        space_(share_of(limits_, options), options.harmonics, options.frequency),
        signals_(arm, limits_, options.workspace, with_values(arm, options),
                 options.limit_share ? 0.0 : options.braking),
        progress_(options.progress, options.starts, MotionSearch::expected_iterations(options)) {}

  Excitation run();

 private:
  double seconds() const { return periods_ / options_.frequency; }
  bool stopped() const { return options_.stop && options_.stop(); }
  // True if the criterion depends on the choice of base columns.
  bool depends_on_base_choice() const {
    return options_.criterion == ExcitationCriterion::kCondition &&
           options_.scaling == ColumnScaling::kNorm;
  }
  MotionSamples samples(const VectorXd& x) const {
    return space_.trajectory(x).motion(periods_, options_.rate);
  }
  double cost(const Asked& asked, const VectorXd& x) const {
    return x.size() > 0 ? asked.question.cost(samples(x)) : kInfinity;
  }
  std::vector<int> best_base_columns(const std::vector<int>& base, const VectorXd& x) const;  ///< of the given size, for the motion x; `base` if the criterion does not depend on it
  // The best motion of one start, with suitable base columns; x is empty if no motion is within the limits.
  struct Candidate {
    std::shared_ptr<const Asked> asked;
    VectorXd x{};
    double cost = kInfinity;
  };
  Candidate polished_with_base_choice(Candidate best, int start, Found& found) const;
  Candidate search_from_start(const std::shared_ptr<const Asked>& asked, int start, Found& found) const;  ///< best motion from one start; sets found
  Candidate widen_joint_ranges(Candidate best, Found& found) const;
  double share_of_range(const VectorXd& x, int joint) const;  ///< range in x over the range of the limits
  // True for the criteria that need every joint to use its range.
  bool uses_whole_range() const {
    return options_.solver != ExcitationSolver::kRandom &&
           (options_.criterion == ExcitationCriterion::kDOptimal || options_.criterion == ExcitationCriterion::kAOptimal);
  }
  bool uses_range_on_all_joints(const VectorXd& x) const {
    for (int i = 0; i < space_.joints(); ++i) {
      if (share_of_range(x, i) < kLittleUse) return false;
    }
    return true;
  }
  VectorXd end_as_numbers(const Candidate& end, const Found& found) const;
  std::optional<Candidate> end_from_numbers(const std::shared_ptr<const Asked>& asked, const VectorXd& numbers, Found& found) const;
  void describe(const Candidate& best, const VectorXd& random, Excitation& out) const;

  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const Model& arm_;
  const ExcitationOptions& options_;
  const NonlinearSolver& solver_;
  int periods_;
  MotionLimits limits_;
  MotionSpace space_;
  LimitSignals signals_;
  mutable SearchProgress progress_;  // has its own lock
};

std::vector<int> Design::best_base_columns(const std::vector<int>& base, const VectorXd& x) const {
  if (!depends_on_base_choice() || x.size() == 0) return base;
  MatrixXd gram = gram_of_all_columns(arm_, samples(x));
  for (const MotionSamples& before : options_.given) {
    const double lasts = before.time[before.rows() - 1] - before.time[0];
    gram += lasts / seconds() * gram_of_all_columns(arm_, before);
  }
  return best_conditioned_columns(base, std::move(gram));
}

// Alternates between the choice of base columns for the motion and a final descent with them.
Design::Candidate Design::polished_with_base_choice(Candidate best, int start, Found& found) const {
  best.cost = cost(*best.asked, best.x);
  for (int round = 0; round < kRounds && best.x.size() > 0 && !stopped(); ++round) {
    const std::vector<int> columns = best_base_columns(best.asked->exact.base(), best.x);
    const bool same = columns == best.asked->exact.base();
    if (!same) {
      best.asked = std::make_shared<Asked>(arm_, columns, options_, seconds());
      best.cost = cost(*best.asked, best.x);
    }
    const MotionSearch searcher(space_, signals_, best.asked->question, options_, solver_,
                                progress_);
    const VectorXd next = searcher.polished(best.x, start, found);
    const double reached = cost(*best.asked, next);
    if (reached < best.cost) {
      best.x = next;
      best.cost = reached;
    }
    if (same) break;
  }
  return best;
}

Design::Candidate Design::search_from_start(const std::shared_ptr<const Asked>& asked, int start,
                                 Found& found) const {
  found = MotionSearch(space_, signals_, asked->question, options_, solver_, progress_).run(start);
  Candidate best{asked};
  for (const VectorXd& end : found.ends) {
    Candidate next = polished_with_base_choice({asked, end}, start, found);
    if (best.x.size() == 0 || next.cost < best.cost) best = std::move(next);
  }
  progress_.report_ended_search(start);
  return best;
}

double Design::share_of_range(const VectorXd& x, int joint) const {
  const MotionBounds bounds = space_.trajectory(x).bounds();
  return (bounds.upper[joint] - bounds.lower[joint]) / (limits_.upper[joint] - limits_.lower[joint]);
}

// The best motion in which joints with a small range get a larger one, beginning with the least used joint;
// joints that the limits block keep their range.
Design::Candidate Design::widen_joint_ranges(Candidate best, Found& found) const {
  if (!uses_whole_range() || best.x.size() == 0) return best;
  std::vector<int> order;
  for (int i = 0; i < space_.joints(); ++i) {
    const double most = (space_.limits().upper[i] - space_.limits().lower[i]) / (limits_.upper[i] - limits_.lower[i]);
    if (share_of_range(best.x, i) < kLittleUse && most > kLittleUse) order.push_back(i);
  }
  std::sort(order.begin(), order.end(), [&, from = best.x](int a, int b) { return share_of_range(from, a) < share_of_range(from, b); });
  const MotionSearch searcher(space_, signals_, best.asked->question, options_, solver_, progress_);
  for (const int joint : order) {
    if (stopped()) break;
    std::vector<int> wide = {joint};
    for (int i = 0; i < space_.joints(); ++i) {
      if (i != joint && share_of_range(best.x, i) >= kLittleUse) wide.push_back(i);
    }
    if (share_of_range(best.x, joint) >= kLittleUse) continue;
    const VectorXd next = searcher.widened(best.x, wide, limits_, found);
    const auto is_wide = [&](int i) { return share_of_range(next, i) >= kLittleUse; };
    if (next.size() == 0 || !std::all_of(wide.begin(), wide.end(), is_wide)) continue;
    best.x = next;
    best.cost = cost(*best.asked, next);
  }
  return best;
}

// A finished start as a vector of numbers: its cost, convergence and evaluations, then lists with their
// lengths.
VectorXd Design::end_as_numbers(const Candidate& end, const Found& found) const {
  std::vector<double> out = {end.cost, found.converged ? 1.0 : 0.0, static_cast<double>(found.evaluations)};
  const auto append = [&out](const auto& list) {
    out.push_back(static_cast<double>(list.size()));
    for (const auto number : list) out.push_back(static_cast<double>(number));
  };
  append(end.asked->exact.base());
  append(end.x);
  append(found.nearest);
  append(found.start);
  return Eigen::Map<const VectorXd>(out.data(), static_cast<Eigen::Index>(out.size()));
}

// The inverse of end_as_numbers(); nullopt if the numbers do not belong to this search.
std::optional<Design::Candidate> Design::end_from_numbers(const std::shared_ptr<const Asked>& asked, const VectorXd& numbers,
                                                      Found& found) const {
  Eigen::Index at = 3;
  bool fits = true;
  const auto next = [&] {
    fits = fits && at < numbers.size() && numbers[at] >= 0.0 && numbers[at] < static_cast<double>(numbers.size() - at);
    const auto size = fits ? static_cast<Eigen::Index>(numbers[at]) : 0;
    at += size + 1;
    return VectorXd(numbers.segment(fits ? at - size : 0, size));
  };
  const VectorXd base = next();
  const VectorXd x = next();
  Found kept;
  kept.nearest = next();
  kept.start = next();
  const auto parameters = static_cast<double>(standard_parameters(arm_).size());
  fits = fits && base.size() > 0 && base.allFinite() && base.minCoeff() >= 0.0 && base.maxCoeff() < parameters;
  for (const VectorXd* of_search : {&x, &std::as_const(kept.nearest), &std::as_const(kept.start)})
    fits = fits && (of_search->size() == 0 || (of_search->size() == space_.size() && of_search->allFinite()));
  if (!fits) return std::nullopt;
  kept.converged = numbers[1] != 0.0;
  kept.evaluations = static_cast<long>(numbers[2]);
  found = std::move(kept);
  Candidate out{asked, x, numbers[0]};
  const std::vector<int> columns(base.begin(), base.end());
  if (columns != asked->exact.base()) out.asked = std::make_shared<Asked>(arm_, columns, options_, seconds());
  return out;
}

void Design::describe(const Candidate& best, const VectorXd& random, Excitation& out) const {
  const Asked& asked = *best.asked;
  const MotionSamples motion = out.trajectory.motion(periods_, options_.rate);
  bool within = best.x.size() > 0;
  out.margins = limit_margins(signals_, out.trajectory);
  // A slower motion stays within every limit except those of torques, to which inertia may have contributed.
  if (within && options_.speed < 1.0 &&
      std::any_of(out.margins.begin(), out.margins.end(), [](const LimitMargin& m) { return m.margin < 0.0; })) {
    out.status = ExcitationStatus::kLimitsNotMet;
    within = false;
  }
  const MotionSamples passes =
      within ? slow_passes(space_.limits(), motion.q.row(0).transpose(),
                           slow_joints(asked.question, arm_), options_.slow_passes, options_.rate,
                           within_limits(signals_))
             : MotionSamples();
  if (passes.rows() > 0) {
    out.margins = joined(out.margins, limit_margins(signals_, passes));
    out.slow_seconds = passes.time[passes.rows() - 1];
  }
  out.motion = joined(motion, passes);
  out.lowest = lowest_point(arm_, options_.workspace.collisions.shapes, out.motion);
  out.cautions = cautions(arm_, options_, out.lowest, with_values(arm_, options_));
  for (int i = 0; i < arm_.joints(); ++i) out.used.push_back(used_limits(out.margins, {i}));
  out.limit_share = options_.limit_share.value_or(0.0);
  const BaseRegressor all(arm_);
  out.log_determinant =
      log_determinant(all.gram(motion) / static_cast<double>(motion.rows()), all.scale());
  const bool part = options_.essential > 0.0;
  const bool own = !part && options_.criterion != ExcitationCriterion::kAOptimal;
  const BaseRegressor whole(arm_, own ? asked.exact.base() : best_base_columns(all.base(), best.x));
  evaluate_motion(arm_, whole, motion, samples(random), options_, out);
  const double share = part ? options_.essential : kUsualShare;
  const EssentialColumns essential = essential_columns(arm_, share);
  if (part || !essential.non_essential.empty()) {
    const BaseRegressor kept(arm_, depends_on_base_choice() && part ? asked.exact.base() : essential.kept);
    out.essential = evaluate_essential(arm_, essential, share, kept, motion);
  }
  const std::optional<Model> known = values_of(arm_, options_);
  if (known) {
    out.prediction =
        predict_identification(*known, out.motion, options_.noise.value_or(expected_noise(*known, out.motion)),
                               options_.given, have_same_parameters(*known, arm_) ? reported_base(arm_) : std::vector<int>());
  }
  if (options_.between && options_.criterion == ExcitationCriterion::kDiscriminate)
    out.discrimination = evaluate_discrimination(asked.question, asked.question.exact_gram(motion));
  if (within && !std::isfinite(best.cost)) out.status = ExcitationStatus::kRankDeficient;
}

Excitation Design::run() {
  std::vector<int> columns;
  if (options_.criterion == ExcitationCriterion::kAOptimal) columns = reported_base(arm_);
  if (options_.essential > 0.0) columns = essential_columns(arm_, options_.essential).kept;
  const auto asked = std::make_shared<const Asked>(arm_, columns, options_, seconds());
  require(asked->exact.size() >= 1, "excitation: the torques of '", arm_.name(),
          "' depend on no parameters: it has neither bodies nor effects.");
  // Memory of the regressor over the whole motion: base columns, and about three times as many others.
  const double most = std::floor(most_rows(4.0 * arm_.joints() * asked->exact.size()));
  const double longest = std::max(options_.duration, seconds()) / options_.speed;  // two periods may last longer
  require(longest * options_.rate < most, "excitation: found ", longest, " s at ", options_.rate,
          " Hz and a base frequency of ", options_.frequency, " Hz, expected fewer than ", most,
          " rows, what this machine holds.");
  std::vector<Found> found(options_.starts);
  std::vector<Candidate> ends(found.size());
  if (options_.progress) options_.progress("searching", 0.0);
  parallel_for(options_.starts, options_.threads, [&](int start) {
    const auto own = static_cast<size_t>(start);
    const auto kept = options_.kept ? options_.kept(start) : std::nullopt;
    if (auto end = kept ? end_from_numbers(asked, *kept, found[own]) : std::nullopt) {
      ends[own] = std::move(*end);
      progress_.report_ended_search(start);
      return;
    }
    if (start > 0 && stopped()) return;
    ends[own] = search_from_start(asked, start, found[own]);
    if (options_.keep && !stopped()) options_.keep(start, end_as_numbers(ends[own], found[own]));
  });
  if (options_.progress) options_.progress("searching", 1.0);
  const auto rank = [](const Candidate& c) { return std::make_pair(c.x.size() == 0, c.cost); };
  const auto first =
      std::min_element(ends.begin(), ends.end(),
                       [&](const Candidate& a, const Candidate& b) { return rank(a) < rank(b); });
  Found& of_last = found[first - ends.begin()];
  Candidate last = widen_joint_ranges(*first, of_last);
  // Another start may have a better motion with large ranges.
  for (const Candidate& other : ends) {
    const bool wide = uses_whole_range() && other.x.size() > 0 && uses_range_on_all_joints(other.x);
    if (wide && last.x.size() > 0 && !uses_range_on_all_joints(first->x) && (!uses_range_on_all_joints(last.x) || other.cost < last.cost)) last = other;
  }
  const bool within = last.x.size() > 0;
  Excitation out{within ? ExcitationStatus::kDone : ExcitationStatus::kLimitsNotMet, arm_.name(),
                 options_.criterion, options_.solver,
                 space_.trajectory(within ? last.x : of_last.nearest).at_speed(options_.speed)};
  out.periods = periods_;
  out.speed = options_.speed;
  describe(last, found.front().start, out);
  for (const Found& f : found) out.evaluations += f.evaluations;
  out.interrupted = stopped();
  out.converged = of_last.converged;
  out.bounds = out.trajectory.bounds();
  out.limits = {limits_.lower, limits_.upper, limits_.velocity, limits_.acceleration};
  for (const Coordinate& coordinate : arm_.coordinates()) {
    out.joints.push_back(coordinate.name);
    out.units.push_back(position_unit(coordinate));
  }
  return out;
}

}  // namespace

bool is_built_in(ExcitationSolver solver) {
#ifndef VERIDYN_WITH_IPOPT
  if (solver == ExcitationSolver::kIpopt) return false;
#endif
#ifndef VERIDYN_WITH_NLOPT
  if (solver == ExcitationSolver::kNlopt) return false;
#endif
  return solver <= ExcitationSolver::kRandom;
}

Excitation optimise_excitation(const Model& arm, const ExcitationOptions& options) {
  require(is_built_in(options.solver), "excitation: found the solver ", name_of(options.solver),
          ", with which this library was not built.");
#ifdef VERIDYN_WITH_IPOPT
  if (options.solver == ExcitationSolver::kIpopt)
    return optimise_excitation(arm, options, solve_with_ipopt);
#endif
#ifdef VERIDYN_WITH_NLOPT
  if (options.solver == ExcitationSolver::kNlopt)
    return optimise_excitation(arm, options, solve_with_nlopt);
#endif
  return optimise_excitation(arm, options, solve_with_interior_point);
}

Excitation optimise_excitation(const Model& file, const ExcitationOptions& options,
                               const NonlinearSolver& solver) {
  check(options);
  const Model arm = with_friction(file, options.friction);
  const auto begun = std::chrono::steady_clock::now();
  require(arm.joints() >= 1, "excitation: the arm '", arm.name(), "' has no coordinates.");
  Excitation out = Design(arm, options, solver).run();
  out.touching = options.workspace.collisions.touching;
  out.friction_remark = friction_remark(file, arm);
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return out;
}

}  // namespace veridyn
