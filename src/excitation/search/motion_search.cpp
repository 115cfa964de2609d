#include "excitation/search/motion_search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>


namespace veridyn {
namespace {

constexpr int kDraws = 32;            // number of random motions, of which the best starts a search
constexpr int kTrials = 16;           // number of random motions that start short descents
constexpr int kTrialIterations = 30;  // iterations of each short descent
constexpr int kFollowed = 3;          // number of short descents that are continued to the end
constexpr int kCriterionInstantsPerWave = 24;  // instants per shortest wave at which the criterion is evaluated
// Instants per shortest wave at which limits are evaluated; violations between them are removed afterwards.
constexpr int kLimitsPerWave = 14;
static_assert(kStages == 2, "one for each sharpness");
constexpr double kSharpness[] = {2.0, 16.0};  // successive values of the sharpness of the smooth condition number
constexpr double kLastSharpness = 100.0;      // sharpness for the best motion of all searches
constexpr int kNarrowings = 5;                // most rounds that tighten limits for the times between samples
constexpr double kWide = 1.01;                // margin above a requested range, because bounds are adapted afterwards
constexpr double kInside = 1e-7;              // margin for rounding, as a share of a limit's scale

constexpr double kRoundingShare = 1e-12;  // share of a joint's limits that stays free

}  // namespace

MotionSearch::MotionSearch(const MotionSpace& space, const LimitSignals& signals,
                           const Question& question, const ExcitationOptions& options,
                           const NonlinearSolver& solver, SearchProgress& progress)
    : space_(space),
      signals_(signals),
      question_(question),
      options_(options),
      solver_(solver),
      progress_(progress) {}

int MotionSearch::expected_iterations(const ExcitationOptions& options) {
  if (options.solver == ExcitationSolver::kRandom) return options.iterations;
  const bool condition = options.criterion == ExcitationCriterion::kCondition;
  const int descents = condition ? kStages + 1 : 1;
  return kTrials * std::min(kTrialIterations, options.iterations) +
         kFollowed * descents * options.iterations;
}

MotionSearch::Bounds MotionSearch::signal_bounds() const {
  const int n = space_.joints();
  Bounds out{VectorXd(signals_.count()), VectorXd(signals_.count())};
  for (int k = 0; k < signals_.count(); ++k) {
    const bool torque = signals_[k].name.rfind("torque", 0) == 0;
    const double share = torque ? options_.limit_share.value_or(kTorqueOfSupervisor) : 1.0;
    out.lower[k] = share * signals_[k].lower;
    out.upper[k] = share * signals_[k].upper;
  }
  const MotionLimits& own = space_.limits();
  out.lower.head(3 * n) << own.lower, -own.velocity, -own.acceleration;
  out.upper.head(3 * n) << own.upper, own.velocity, own.acceleration;
  return out;
}

double MotionSearch::smooth_cost(const VectorXd& x, double sharpness) const {
  return question_.objective(space_, sharpness, kCriterionInstantsPerWave * space_.harmonics()).value(x);
}

bool MotionSearch::is_within(const VectorXd& x, const Bounds& bounds) const {
  if (!has_more_than_joints()) return true;
  Bounds same = bounds;
  return !tighten_bounds(x, same);
}

std::vector<VectorXd> MotionSearch::drawn_starts(int start, const Bounds& bounds, Found& found) const {
  RandomNumbers random(options_.seed, static_cast<unsigned>(start));
  const bool only = options_.solver == ExcitationSolver::kRandom;
  const int draws = only ? options_.iterations : kDraws;
  using Ranked = std::pair<std::pair<bool, double>, VectorXd>;
  std::vector<Ranked> best;
  for (int k = 0; k < draws; ++k) {
    const VectorXd x = fitted_to_joints(space_, space_.random(random));
    if (k == 0) found.start = x;
    if (k > 0 && options_.stop && options_.stop()) break;
    ++found.evaluations;
    best.push_back({{!is_within(x, bounds), smooth_cost(x, kSharpness[0])}, x});
    std::stable_sort(best.begin(), best.end(),
                     [](const Ranked& a, const Ranked& b) { return a.first < b.first; });
    if (best.size() > static_cast<size_t>(kTrials)) best.pop_back();
    if (only) progress_.step(start, "random motions");
  }
  std::vector<VectorXd> out;
  for (Ranked& ranked : best) out.push_back(std::move(ranked.second));
  return out;
}

std::vector<VectorXd> MotionSearch::best_descents(const std::vector<VectorXd>& from, const Bounds& bounds,
                                          int start, Found& found) const {
  std::vector<std::pair<double, VectorXd>> ends;
  for (const VectorXd& x : from) {
    const VectorXd end = descend(x, bounds, {kSharpness[0], kTrialIterations}, start, found);
    if (end.size() > 0) ends.emplace_back(smooth_cost(end, kSharpness[0]), end);
    if (options_.stop && options_.stop()) break;
  }
  if (ends.empty()) return {from.front()};
  std::stable_sort(ends.begin(), ends.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<VectorXd> out;
  for (size_t k = 0; k < std::min(ends.size(), static_cast<size_t>(kFollowed)); ++k)
    out.push_back(std::move(ends[k].second));
  return out;
}

VectorXd MotionSearch::descend(const VectorXd& from, const Bounds& bounds, const Descent& descent,
                               int start, Found& found) const {
  GridConstraints limits(space_, signals_, kLimitsPerWave * space_.harmonics());
  limits.set_bounds(bounds.lower, bounds.upper);
  limits.set_spans(descent.spans);
  const MotionObjective objective =
      question_.objective(space_, descent.sharpness, kCriterionInstantsPerWave * space_.harmonics());
  SearchProgram program(objective, limits, space_.size());
  SolverOptions solver;
  solver.iterations = std::min(options_.iterations, descent.iterations);
  solver.stop = [&] {
    const auto& best = program.best();
    const bool condition = question_.criterion == ExcitationCriterion::kCondition;
    std::string news = "no motion within the limits yet";
    if (best) {
      news = condition ? fmt::format("condition number {:.4g}", std::exp(best->value))
                       : fmt::format("criterion {:.5g}", best->value);
      news +=
          fmt::format("; tightest limit: {}, {:.2f} % left", signals_[best->violation.signal].name,
                      std::max(0.0, -100.0 * best->violation.size));
    }
    progress_.step(start, news);
    return options_.stop && options_.stop();
  };
  const SolverResult result = solver_(program, from, solver);
  found.evaluations += program.evaluations();
  found.converged = result.converged;
  return program.best() ? program.best()->x : VectorXd();
}

VectorXd MotionSearch::projected_into_limits(const VectorXd& from, const Bounds& bounds) const {
  GridConstraints limits(space_, signals_, kLimitsPerWave * space_.harmonics());
  limits.set_bounds(bounds.lower, bounds.upper);
  WidestViolation program(limits, space_.size());
  VectorXd start(space_.size() + 1);
  start << fitted_to_joints(space_, from),
      std::max(0.0, limits.violation(limits.values(from)).size);
  SolverOptions solver;
  solver.iterations = options_.iterations;
  solver.stop = options_.stop;
  return solver_(program, start, solver).x.head(space_.size());
}

bool MotionSearch::tighten_bounds(const VectorXd& x, Bounds& bounds) const {
  bool crossed = false;
  const Bounds wide = signal_bounds();
  const std::vector<LimitMargin> margins = limit_margins(signals_, space_.trajectory(x));
  for (int k = 3 * space_.joints(); k < signals_.count(); ++k) {
    const auto m = std::find_if(margins.begin(), margins.end(), [&](const LimitMargin& margin) {
      return margin.name == signals_[k].name;
    });
    if (m == margins.end()) continue;
    const double inside = kInside * signals_[k].scale;
    const double over = m->highest - wide.upper[k];
    const double under = wide.lower[k] - m->lowest;
    if (over > 0.0) bounds.upper[k] -= 1.2 * over + inside;
    if (under > 0.0) bounds.lower[k] += 1.2 * under + inside;
    crossed = crossed || over > 0.0 || under > 0.0;
  }
  return crossed;
}

VectorXd MotionSearch::track_minimum(VectorXd x, int start, Found& found) const {
  Bounds bounds = signal_bounds();
  VectorXd good = is_within(x, bounds) ? fitted_to_joints(space_, x) : VectorXd();
  const auto accept = [&](const VectorXd& next) {
    x = next;
    if (!is_within(x, signal_bounds())) return false;
    good = x;
    return true;
  };
  const bool condition = question_.criterion == ExcitationCriterion::kCondition;
  for (const double sharpness : kSharpness) {
    if (!condition && sharpness != kSharpness[0]) break;
    const Descent descent{sharpness, options_.iterations};
    VectorXd next = descend(x, bounds, descent, start, found);
    if (next.size() == 0 && good.size() == 0) {
      x = projected_into_limits(x, bounds);
      next = descend(x, bounds, descent, start, found);
    }
    if (next.size() == 0) break;
    bool held = accept(fitted_to_joints(space_, next));
    for (int round = 0; !held && round < kNarrowings; ++round) {
      tighten_bounds(x, bounds);
      next = descend(x, bounds, descent, start, found);
      if (next.size() == 0) break;
      held = accept(fitted_to_joints(space_, next));
    }
  }
  found.nearest = x;
  return good;
}

Found MotionSearch::run(int start) const {
  Found found;
  const Bounds bounds = signal_bounds();
  std::vector<VectorXd> from = drawn_starts(start, bounds, found);
  found.nearest = from.front();
  if (options_.solver == ExcitationSolver::kRandom) {
    if (is_within(from.front(), bounds)) found.ends = {from.front()};
    return found;
  }
  from = best_descents(from, bounds, start, found);
  for (const VectorXd& x : from) {
    const VectorXd end = track_minimum(x, start, found);
    if (end.size() > 0) found.ends.push_back(end);
  }
  return found;
}

VectorXd MotionSearch::polished(const VectorXd& from, int start, Found& found) const {
  const bool random = options_.solver == ExcitationSolver::kRandom;
  const bool over = options_.stop && options_.stop();
  const bool condition = question_.criterion == ExcitationCriterion::kCondition;
  if (random || over || !condition) return {};
  const Descent descent{kLastSharpness, options_.iterations};
  const VectorXd next = descend(from, signal_bounds(), descent, start, found);
  if (next.size() == 0) return {};
  const VectorXd fitted = fitted_to_joints(space_, next);
  return is_within(fitted, signal_bounds()) ? fitted : VectorXd();
}

VectorXd MotionSearch::widened(const VectorXd& from, const std::vector<int>& joints, const MotionLimits& limits,
                               Found& found) const {
  const int p = space_.per_joint();
  const int instants = kLimitsPerWave * space_.harmonics();
  // The start has the wanted ranges, if the speeds allow it; each span is between the instants of the joint's
  // extremes.
  VectorXd x = from;
  const MotionBounds bounds = space_.trajectory(from).bounds();
  Descent descent{kSharpness[0], options_.iterations};
  const MotionSamples samples = space_.samples(space_.basis(period_instants(space_.frequency(), instants)), from);
  for (const int i : joints) {
    const double least = kWide * kLittleUse * (limits.upper[i] - limits.lower[i]);
    const double now = bounds.upper[i] - bounds.lower[i];
    if (now < least) x.segment(i * p + 1, p - 1) *= least / now;
    GridConstraints::Span span{i, 0, 0, least};
    samples.q.col(i).maxCoeff(&span.high);
    samples.q.col(i).minCoeff(&span.low);
    descent.spans.push_back(span);
  }
  // Descends from the unchanged motion and from the widened one, which may lead to different optima.
  VectorXd best;
  for (const VectorXd& start : {from, fitted_to_joints(space_, x)}) {
    Bounds inside = signal_bounds();
    VectorXd at = start;
    for (int round = 0; round <= kNarrowings; ++round) {
      const VectorXd next = descend(at, inside, descent, 0, found);
      if (next.size() == 0) break;
      at = fitted_to_joints(space_, next);
      if (!is_within(at, signal_bounds())) {
        tighten_bounds(at, inside);
        continue;
      }
      if (best.size() == 0 || smooth_cost(at, kSharpness[0]) < smooth_cost(best, kSharpness[0])) best = at;
      break;
    }
  }
  return best;
}

VectorXd fitted_to_joints(const MotionSpace& space, const VectorXd& x) {
  VectorXd out = x;
  const MotionLimits& limits = space.limits();
  const int p = space.per_joint();
  const MotionBounds bounds = space.trajectory(x).bounds();
  for (int i = 0; i < space.joints(); ++i) {
    auto own = out.segment(i * p, p);
    const double room = limits.upper[i] - limits.lower[i];
    const double share = std::min({1.0, room / (bounds.upper[i] - bounds.lower[i]),
                                   limits.velocity[i] / bounds.velocity[i],
                                   limits.acceleration[i] / bounds.acceleration[i]}) *
                         (1.0 - kRoundingShare);
    own.tail(p - 1) *= share;
    // The extremes about the mean position are scaled with the motion.
    const double mean = space.middle_of(i) + space.size_of(i) * own[0];
    const double low = share * (bounds.lower[i] - mean);
    const double high = share * (bounds.upper[i] - mean);
    const double edge = 0.2 * kRoundingShare * room;
    const double moved =
        std::max(limits.lower[i] + edge - low, std::min(mean, limits.upper[i] - edge - high));
    own[0] = (moved - space.middle_of(i)) / space.size_of(i);
  }
  return out;
}

}  // namespace veridyn
