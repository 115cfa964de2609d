// Torques and currents at their limit: exactly (clipped numbers), or within noise (clipped
// amplifier); and in coarse steps.
#include <algorithm>
#include <cmath>

#include "math/quantisation.hpp"
#include "recordings/quality/quality_checks.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::quality {
namespace {

// A run of rows in which a load stays close to its extreme.
struct Plateau {
  int first = 0;
  int last = 0;
};

// True for saturation: the load rises from half to full and falls back in less than half the time
// that it stays there, and meanwhile the arm accelerates or decelerates by at least a quarter of
// its top speed (unlike on friction plateaus).
bool is_saturated(const Head& head, const VectorXd& load, const Plateau& plateau, double half,
                  int joint) {
  const int length = plateau.last - plateau.first + 1;
  if (length < numbers.shortest_plateau) return false;
  int before = plateau.first;
  int after = plateau.last;
  while (before > 0 && load[before] > half && plateau.first - before <= length) --before;
  while (after + 1 < load.size() && load[after] > half && after - plateau.last <= length) ++after;
  if (2 * (plateau.first - before + after - plateau.last) > length || before == 0) return false;
  const auto& q = head.rows.q;
  const int lag = std::max(1, length / numbers.plateau_parts);
  const auto speed = [&](int k) {
    return (q(k, joint) - q(k - lag, joint)) / (head.rows.time[k] - head.rows.time[k - lag]);
  };
  if (plateau.first < lag || plateau.last <= plateau.first + lag) return false;
  double top = 0.0;
  for (int k = lag; k < q.rows(); k += lag) top = std::max(top, std::abs(speed(k)));
  return std::abs(speed(plateau.last) - speed(plateau.first)) > numbers.speed_change * top;
}

// Number of rows in saturated plateaus within 8 % of the largest value.
int plateau_rows(const Head& head, const VectorXd& load, int joint, double* limit) {
  const double largest = *std::max_element(load.data(), load.data() + load.size());
  if (!(largest > 0.0)) return 0;
  int rows = 0;
  std::vector<double> levels;
  for (int k = 0; k < load.size(); ++k) {
    if (!(load[k] > numbers.near_largest * largest)) continue;
    Plateau plateau{k, k};
    while (plateau.last + 1 < load.size() && load[plateau.last + 1] > numbers.near_largest * largest)
      ++plateau.last;
    k = plateau.last;
    if (!is_saturated(head, load, plateau, 0.5 * largest, joint)) continue;
    rows += plateau.last - plateau.first + 1;
    for (int r = plateau.first; r <= plateau.last; ++r) levels.push_back(load[r]);
  }
  *limit = quantile(std::move(levels), 0.5);
  return rows;
}

// Number of steps from one end of the range to the other between two rows, while the joint moves on.
int overflows(const Head& head, const VectorXd& load, int joint) {
  const auto& q = head.rows.q;
  const double range = load.maxCoeff() - load.minCoeff();
  int out = 0;
  for (int k = 2; k + 1 < load.size(); ++k) {
    const bool moves_on = (q(k + 1, joint) - q(k, joint)) * (q(k - 1, joint) - q(k - 2, joint)) > 0.0;
    if (moves_on && std::abs(load[k] - load[k - 1]) > numbers.overflow * range) ++out;
  }
  return out;
}

}  // namespace

ClipTally::ClipTally(const Head& head) : start_(head.rows.rows() > 0 ? head.rows.time[0] : 0.0) {
  for (const RecordingSignal& signal : kRecordingSignals) {
    const std::string name = signal.name;
    if (name != "tau" && name != "i") continue;
    const MatrixXd& values = head.rows.*signal.values;
    for (int j = 0; j < values.cols(); ++j) {
      const double range = between_quantiles(column_of(values, j), 0.0, 1.0);
      const double tolerance = std::max(kExact * range, numbers.step_share * resolution_of(values, j));
      for (const double sign : {1.0, -1.0}) extremes_.push_back({{name, j + 1}, sign, tolerance});
    }
  }
}

void ClipTally::close_run(double after, Extreme* extreme) const {
  const double exit = extreme->limit - after;
  if (extreme->run >= numbers.shortest_run && std::min(extreme->entry, exit) > numbers.abrupt * extreme->tolerance) {
    extreme->abrupt = true;
  }
  extreme->run = 0;
}

void ClipTally::add_value(double value, double before, double time, Extreme* extreme) const {
  const double next = 1.0 + 1.0 / numbers.step_share;  // distance from the limit to the end of the next value, in tolerances
  if (value > extreme->limit + extreme->tolerance) {
    const Place place = extreme->place;
    const long below = value < extreme->limit + next * extreme->tolerance ? extreme->rows : 0;
    *extreme = {place, extreme->sign, extreme->tolerance};
    extreme->limit = value;
    extreme->below = below;
  }
  if (value < extreme->limit - extreme->tolerance && value > extreme->limit - next * extreme->tolerance) ++extreme->below;
  if (value >= extreme->limit - extreme->tolerance) {
    if (extreme->run == 0) {
      extreme->entry = extreme->limit - before;
      extreme->stretches.push_back({extreme->place.joint - 1, time, time});
    }
    extreme->stretches.back().to = time;
    ++extreme->run;
    ++extreme->rows;
    extreme->longest = std::max(extreme->longest, extreme->run);
  } else if (extreme->run > 0) {
    close_run(value, extreme);
  }
}

void ClipTally::add(const Piece& piece) {
  for (int k = std::max(piece.fresh, 1); k < piece.rows.rows(); ++k) {
    if (is_stale(piece.rows, k) || !is_moving(piece.rows, k)) continue;
    for (Extreme& extreme : extremes_) {
      const MatrixXd& values = extreme.place.signal == "tau" ? piece.rows.tau : piece.rows.current;
      const int j = extreme.place.joint - 1;
      if (std::isnan(values(k, j)) || std::isnan(values(k - 1, j))) continue;
      add_value(extreme.sign * values(k, j), extreme.sign * values(k - 1, j), piece.rows.time[k] - start_, &extreme);
    }
  }
  rows_ += piece.rows.rows() - piece.fresh;
}

// True if a run at the extreme is too long for the top of a wave: a parabola stays in its highest step at
// most sqrt(2) + 1 times as long as in the next.
bool ClipTally::is_limit(const Extreme& one, const Extreme& opposite) const {
  const bool symmetric = one.limit > one.tolerance && std::abs(one.limit - opposite.limit) <= one.tolerance &&
                         std::min(one.longest, opposite.longest) >= numbers.shortest_plateau;
  const auto is_flat = [](const Extreme& e) { return e.rows > (std::sqrt(2.0) + 1.0) * e.below; };
  return one.abrupt || (symmetric && is_flat(one) && is_flat(opposite));
}

void ClipTally::conclude(Findings* findings, std::vector<SaturatedInterval>* saturated) const {
  for (size_t k = 0; k < extremes_.size(); ++k) {
    const Extreme& extreme = extremes_[k];
    if (!is_limit(extreme, extremes_[k ^ 1U])) continue;
    if (extreme.place.signal == "tau" && extreme.limit != 0.0)
      saturated->insert(saturated->end(), extreme.stretches.begin(), extreme.stretches.end());
    const double share = share_of(extreme.rows, rows_);
    const double limit = extreme.sign * extreme.limit;
    findings->add(share > numbers.many_clipped ? Severity::kFault : Severity::kWarning, "saturation", extreme.place,
                  {share, limit, unit_of(extreme.place.signal)},
                  text("The ", word_of_load(extreme.place.signal), " of ",
                       named(extreme.place), " sits exactly at its extreme ", number(limit), " in ",
                       extreme.rows, " rows (", percent(share), "), up to ", extreme.longest, " in a row: ",
                       limit == 0.0 ? "a dead zone, or a channel of one sign." : "saturated."));
  }
}

void check_saturated_plateaus(const Head& head, Findings* findings) {
  for (const Load& load : loads_of(head.rows)) {
    for (int j = 0; j < head.rows.joints(); ++j) {
      if (!head.moves[j]) continue;
      const Place place{load.name, j + 1};
      VectorXd values = load.values->col(j);
      // A missing value is replaced by the previous one, so that a gap is no edge.
      for (Eigen::Index k = 0; k < values.size(); ++k) {
        if (std::isnan(values[k])) values[k] = k > 0 ? values[k - 1] : 0.0;
      }
      if (const int steps = overflows(head, values, j); steps >= numbers.fewest_overflows) {
        findings->add(Severity::kFault, "overflow", place, {kNone, values.maxCoeff(), unit_of(load.name)},
                      text("The ", word_of_load(place.signal), " of ", named(place), " steps from one end of its range (", number(values.minCoeff()), " to ",
                           number(values.maxCoeff()), ") to the other ", counted(steps, "time"), " while the joint moves on: a register that overflows?"));
        continue;
      }
      for (const double sign : {1.0, -1.0}) {
        double limit = 0.0;
        const int rows = plateau_rows(head, sign * values, j, &limit);
        if (rows == 0) continue;
        const double share = static_cast<double>(rows) / head.rows.rows();
        findings->add(
            Severity::kWarning, "saturation", place, {share, sign * limit, unit_of(load.name)},
            text("The ", word_of_load(place.signal), " of ", named(place),
                 " stays at ", number(sign * limit), ", its extreme, for ", rows, " rows (",
                 percent(share), ") while the joint changes speed: saturated?"));
      }
    }
  }
}

void check_torque_steps(const Head& head, Findings* findings) {
  for (const Load& load : loads_of(head.rows)) {
    for (int j = 0; j < head.rows.joints(); ++j) {
      if (!head.moves[j]) continue;
      std::vector<double> values;
      std::vector<double> changes;
      for (int k = 1; k < head.rows.rows(); ++k) {
        const double now = (*load.values)(k, j);
        const double change = std::abs(now - (*load.values)(k - 1, j));
        if (!std::isfinite(now) || !std::isfinite(change)) continue;
        values.push_back(now);
        if (change > 0.0) changes.push_back(change);
      }
      if (static_cast<int>(changes.size()) < numbers.fewest_changes) continue;
      const double range = between_quantiles(values, numbers.ends, 1.0 - numbers.ends);
      if (!quantile_exceeds(changes, numbers.ends, numbers.coarse * range)) continue;
      const double step = quantile(changes, numbers.ends);
      double square = 0.0;
      for (const double v : values) square += v * v;
      const double rms = std::sqrt(square / static_cast<double>(values.size()));
      const Place place{load.name, j + 1};
      findings->add(Severity::kWarning, "torque_quantised", place, {step / range, step, unit_of(load.name)},
                    text("The ", word_of_load(place.signal), " of ", named(place), " goes in steps of about ",
                         number(step), ": these alone are an error of ", percent(kStepToDeviation * step / rms),
                         " of its root mean square."));
    }
  }
}

}  // namespace veridyn::quality
