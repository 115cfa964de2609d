// Finds torques and currents that stay at their limit, exactly (clipped numbers) or within noise (clipped
// amplifier), and those that are quantised coarsely.
#include <algorithm>
#include <cmath>

#include "math/quantisation.hpp"
#include "recordings/quality/quality_checks.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::quality {
namespace {

// Finds values at the extreme that are entered and left abruptly, or at two limits of equal size.
class ClipTally : public Tally {
 public:
  explicit ClipTally(const Head& head) : start_(head.rows.time[0]) {
    for (const Channel& channel : channels_of(head.rows)) {
      if (!is_load(*channel.signal)) continue;
      const auto values = channel.of(head.rows);
      const double range = between_quantiles({values.begin(), values.end()}, 0.0, 1.0);
      const double tolerance = std::max(kExact * range, numbers.step_share * resolution_of(values));
      for (const double sign : {1.0, -1.0}) extremes_.push_back({channel, sign, tolerance});
    }
  }

  void add(const Piece& piece) override {
    for (int k = std::max(piece.fresh, 1); k < piece.rows.rows(); ++k) {
      if (is_stale(piece.rows, k) || !is_moving(piece.rows, k)) continue;
      for (Extreme& extreme : extremes_) {
        const auto values = extreme.channel.of(piece.rows);
        if (std::isnan(values[k]) || std::isnan(values[k - 1])) continue;
        extreme.add(extreme.sign * values[k], extreme.sign * values[k - 1], piece.rows.time[k] - start_);
      }
    }
    rows_ += piece.rows.rows() - piece.fresh;
  }

  void conclude(Findings* findings) const override {
    for (std::size_t k = 0; k < extremes_.size(); ++k) {
      const Extreme& extreme = extremes_[k];
      if (!is_limit(extreme, extremes_[k ^ 1U])) continue;
      if (extreme.channel.is(&Recording::tau) && extreme.limit != 0.0) findings->add_saturated(extreme.stretches);
      const double share = share_of(extreme.rows, rows_);
      const double limit = extreme.sign * extreme.limit;
      findings->add(share > numbers.many_clipped ? Severity::kFault : Severity::kWarning, QualityKind::kSaturation, extreme.channel.place(),
                    {share, limit, extreme.channel.unit()},
                    text("The ", extreme.channel.load_word(), " of ", extreme.channel.name(), " sits exactly at its extreme ", number(limit), " in ",
                         extreme.rows, " rows (", percent(share), "), up to ", extreme.longest, " in a row: ",
                         limit == 0.0 ? "a dead zone, or a channel of one sign." : "saturated."));
    }
  }

 private:
  struct Extreme {
    Channel channel;
    double sign = 1.0;  // +1 for the largest, -1 for the smallest value
    double tolerance = 0.0;
    double limit = -std::numeric_limits<double>::infinity();  // extreme of sign * value
    long run = 0;
    double entry = 0.0;   // size of the step into the run
    bool abrupt = false;  // a run of at least three rows was entered and left abruptly
    long rows = 0;        // number of rows at the limit
    long longest = 0;
    long below = 0;  // rows at the next smaller value of the channel
    std::vector<SaturatedInterval> stretches = {};

    void add(double value, double before, double time) {
      const double two_steps = (1.0 + 1.0 / numbers.step_share) * tolerance;  // from the limit to the end of the
                                                                              // next value
      if (value > limit + tolerance) {
        const long rows_below = value < limit + two_steps ? rows : 0;
        *this = {channel, sign, tolerance, value};
        below = rows_below;
      }
      if (value < limit - tolerance && value > limit - two_steps) ++below;
      if (value >= limit - tolerance) {
        add_to_run(limit - before, time);
      } else if (run > 0) {
        close_run(limit - value);
      }
    }

    void add_to_run(double step, double time) {
      if (run == 0) {
        entry = step;
        stretches.push_back({{channel.joint}, time, time});
      }
      stretches.back().to = time;
      ++rows;
      longest = std::max(longest, ++run);
    }

    void close_run(double exit) {
      abrupt = abrupt || (run >= numbers.shortest_run && std::min(entry, exit) > numbers.abrupt * tolerance);
      run = 0;
    }
  };

  // True if a run at the extreme is longer than the crest of a wave could be: a parabola stays in its highest
  // step at most sqrt(2) + 1 times as long as in the next.
  static bool is_limit(const Extreme& one, const Extreme& opposite) {
    const bool symmetric = one.limit > one.tolerance && std::abs(one.limit - opposite.limit) <= one.tolerance &&
                           std::min(one.longest, opposite.longest) >= numbers.shortest_plateau;
    const auto is_flat = [](const Extreme& e) { return e.rows > (std::sqrt(2.0) + 1.0) * e.below; };
    return one.abrupt || (symmetric && is_flat(one) && is_flat(opposite));
  }

  std::vector<Extreme> extremes_;  // largest and smallest value alternate
  double start_ = 0.0;             // [s]
  long rows_ = 0;
};

// A run of rows in which a load stays close to its extreme.
struct Plateau {
  int first = 0;
  int last = 0;
};

// True if a parabola explains nearly all of a plateau's scatter: the top of a wave, or friction on which gravity or inertia rides.
// A torque at its limit scatters by noise, and its limit sags with the supply.
bool is_curved(const VectorXd& load, const Plateau& plateau) {
  const Eigen::Index length = plateau.last - plateau.first + 1;
  const Eigen::ArrayXd values = load.segment(plateau.first, length).array() - load.segment(plateau.first, length).mean();
  const Eigen::ArrayXd line = Eigen::ArrayXd::LinSpaced(length, -1.0, 1.0);
  const Eigen::ArrayXd bend = line.square() - line.square().mean();  // at right angles to the line and to the mean
  double explained = 0.0;
  for (const Eigen::ArrayXd* one : {&line, &bend}) explained += std::pow((values * *one).sum(), 2) / one->square().sum();
  return explained > numbers.curved * values.square().sum();
}

// True for saturation: the load rises from half to full and falls back in less than half the time
// that it stays there, and meanwhile the arm accelerates or decelerates by at least a quarter of
// its top speed (unlike on friction plateaus).
bool is_saturated(const Head& head, const VectorXd& load, const Plateau& plateau, double half, int joint) {
  const int length = plateau.last - plateau.first + 1;
  if (length < numbers.shortest_plateau || is_curved(load, plateau)) return false;
  int before = plateau.first;
  int after = plateau.last;
  while (before > 0 && load[before] > half && plateau.first - before <= length) --before;
  while (after + 1 < load.size() && load[after] > half && after - plateau.last <= length) ++after;
  if (2 * (plateau.first - before + after - plateau.last) > length || before == 0) return false;
  const auto q = head.rows.q.col(joint);
  const int lag = std::max(1, length / numbers.plateau_parts);
  const auto speed = [&](int k) { return (q[k] - q[k - lag]) / (head.rows.time[k] - head.rows.time[k - lag]); };
  if (plateau.first < lag || plateau.last <= plateau.first + lag) return false;
  double top = 0.0;
  for (int k = lag; k < q.size(); k += lag) top = std::max(top, std::abs(speed(k)));
  return std::abs(speed(plateau.last) - speed(plateau.first)) > numbers.speed_change * top;
}

// Values in saturated plateaus within 8 % of the largest one.
std::vector<double> plateau_values(const Head& head, const VectorXd& load, int joint) {
  std::vector<double> values;
  const double largest = load.maxCoeff();
  const auto is_near = [&](int k) { return load[k] > numbers.near_largest * largest; };
  for (int k = 0; k < load.size() && largest > 0.0; ++k) {
    if (!is_near(k)) continue;
    Plateau plateau{k, k};
    while (plateau.last + 1 < load.size() && is_near(plateau.last + 1)) ++plateau.last;
    k = plateau.last;
    if (is_saturated(head, load, plateau, 0.5 * largest, joint)) values.insert(values.end(), &load[plateau.first], &load[plateau.last] + 1);
  }
  return values;
}

// Number of times that a load steps from one end of its range to the other between two rows, while the joint
// moves on.
int overflows(const Head& head, const VectorXd& load, int joint) {
  const auto q = head.rows.q.col(joint);
  const double range = load.maxCoeff() - load.minCoeff();
  int out = 0;
  for (int k = 2; k + 1 < load.size(); ++k) {
    const bool moves_on = (q[k + 1] - q[k]) * (q[k - 1] - q[k - 2]) > 0.0;
    if (moves_on && std::abs(load[k] - load[k - 1]) > numbers.overflow * range) ++out;
  }
  return out;
}

// The values of a load, where the previous value replaces a missing one, so that a gap is no edge.
VectorXd without_gaps(const Channel& load, const Recording& rows) {
  VectorXd values = load.of(rows);
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    if (std::isnan(values[k])) values[k] = k > 0 ? values[k - 1] : 0.0;
  }
  return values;
}

}  // namespace

std::unique_ptr<Tally> clip_tally(const Head& head) { return std::make_unique<ClipTally>(head); }

void check_saturated_plateaus(const Head& head, Findings* findings) {
  for (const Channel& load : head.moving_loads()) {
    const VectorXd values = without_gaps(load, head.rows);
    const std::string the_load = text("The ", load.load_word(), " of ", load.name());
    if (const int steps = overflows(head, values, load.joint); steps >= numbers.fewest_overflows) {
      findings->add(Severity::kFault, QualityKind::kOverflow, load.place(), {kNone, values.maxCoeff(), load.unit()},
                    text(the_load, " steps from one end of its range (", number(values.minCoeff()), " to ", number(values.maxCoeff()),
                         ") to the other ", counted(steps, "time"), " while the joint moves on: a register that overflows?"));
      continue;
    }
    // Within one step of a coarse torque a wave is as flat as a limit.
    const std::vector<double> changes = changes_of(values);
    if (!changes.empty() && quantile(changes, numbers.ends) > (1.0 - numbers.near_largest) * values.cwiseAbs().maxCoeff()) continue;
    for (const double sign : {1.0, -1.0}) {
      const std::vector<double> held = plateau_values(head, sign * values, load.joint);
      if (held.empty()) continue;
      const double limit = sign * quantile(held, 0.5);
      const double share = share_of(static_cast<long>(held.size()), head.rows.rows());
      findings->add(Severity::kWarning, QualityKind::kSaturation, load.place(), {share, limit, load.unit()},
                    text(the_load, " stays at ", number(limit), ", its extreme, for ", held.size(), " rows (", percent(share),
                         ") while the joint changes speed: saturated?"));
    }
  }
}

void check_torque_steps(const Head& head, Findings* findings) {
  for (const Channel& load : head.moving_loads()) {
    const auto values = load.of(head.rows);
    const std::vector<double> changes = changes_of(values);
    std::vector<double> present;  // finite values whose previous one is finite
    double square = 0.0;
    for (int k = 1; k < values.size(); ++k) {
      if (!std::isfinite(values[k] - values[k - 1])) continue;
      present.push_back(values[k]);
      square += values[k] * values[k];
    }
    if (static_cast<int>(changes.size()) < numbers.fewest_changes) continue;
    const double range = between_quantiles(present, numbers.ends, 1.0 - numbers.ends);
    if (!quantile_exceeds(changes, numbers.ends, numbers.coarse * range)) continue;
    const double step = quantile(changes, numbers.ends);
    const double rms = std::sqrt(square / static_cast<double>(present.size()));
    findings->add(Severity::kWarning, QualityKind::kTorqueQuantised, load.place(), {step / range, step, load.unit()},
                  text("The ", load.load_word(), " of ", load.name(), " goes in steps of about ", number(step),
                       ": these alone are an error of ", percent(kStepToDeviation * step / rms), " of its root mean square."));
  }
}

}  // namespace veridyn::quality
