// Torques and currents exactly at their limit (clipped numbers), and in coarse steps.
#include <algorithm>
#include <cmath>

#include "math/quantisation.hpp"
#include "recordings/quality/quality_checks.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::quality {
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
  const double next = 1.0 + 1.0 / numbers.step_share;  // tolerances between the limit and the end of the next value
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

// The top of a wave, a parabola, stays in its highest step at most sqrt(2) + 1 times as long as in the next.
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
