// Checks of motion, torques and currents, on the first rows of a recording.
#include <algorithm>
#include <cmath>

#include "math/correlated_columns.hpp"
#include "recordings/quality/quality_checks.hpp"
#include "recordings/signals/units.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/recordings/preprocessing.hpp"

namespace veridyn::quality {
namespace {

// Usual size of the change over 20 ms in consecutive windows of 0.1 s: single wrong values do not count, nor do rows in which the
// joint, and with it the sign of its friction, turns round.
std::vector<double> ringing(const Head& head, const MatrixXd& values, int joint) {
  const int lag = std::max(1, static_cast<int>(std::lround(numbers.ringing / head.step)));
  const int window = window_rows(head);
  const auto step = [&](int k) { return head.rows.q(std::max(k, 1), joint) - head.rows.q(std::max(k, 1) - 1, joint); };
  std::vector<double> sizes;
  for (int first = 0; first + window + lag <= values.rows(); first += window) {
    std::vector<double> changes;
    for (int k = first; k < first + window; ++k) {
      if (!(step(k) * step(k + lag) < 0.0)) changes.push_back(std::abs(values(k + lag, joint) - values(k, joint)));
    }
    sizes.push_back(changes.empty() ? 0.0 : quantile(changes, 1.0 - numbers.rare));
  }
  return sizes;
}

// True if two columns have the same numbers, which change.
bool are_equal(const MatrixXd& one, int i, const MatrixXd& other, int j) {
  double changes = 0.0;
  for (Eigen::Index k = 0; k < one.rows(); ++k) {
    if (!std::isfinite(one(k, i)) && !std::isfinite(other(k, j))) continue;
    if (one(k, i) != other(k, j)) return false;
    if (k > 0) changes += std::abs(one(k, i) - one(k - 1, i)) > 0.0 ? 1.0 : 0.0;
  }
  return 2.0 * changes > static_cast<double>(one.rows());
}

// Checks that the motion is sufficient after the filter's transients at either end are cut.
void check_duration(const Head& head, Findings* findings) {
  const PreprocessingOptions usual;
  const double cut = usual.drop_start + usual.drop_end;
  const double seconds = head.rows.time[head.rows.rows() - 1] - head.rows.time[0];
  if (!(seconds < cut + kLeastSeconds)) return;
  findings->add(Severity::kFault, "short_recording", {}, {kNone, seconds, "s"},
                text("The recording lasts ", number(seconds), " s, of which an identification cuts ", number(usual.drop_start), " s at the start and ",
                     number(usual.drop_end), " s at the end (--drop-start and --drop-end change that): ", number(kEnoughSeconds), " s and more are needed."));
}

// Checks the unit of time: steps of a second and more within one motion mean another unit.
bool check_clock(const Head& head, Findings* findings) {
  if (head.step < kSlowClock) return false;
  double onward = 0.0;
  for (int j = 0; j < head.rows.joints(); ++j) {
    for (int k = 2; k < head.rows.rows(); ++k) {
      const double before = head.rows.q(k - 1, j) - head.rows.q(k - 2, j), after = head.rows.q(k, j) - head.rows.q(k - 1, j);
      if (std::isfinite(before) && std::isfinite(after) && head.moves[static_cast<std::size_t>(j)]) onward += before * after;
    }
  }
  if (!(onward > 0.0)) return false;
  const char* unit = recordings::unit_of_clock(head.step);
  findings->add(Severity::kFault, "time_unit", {"t", 0}, {kNone, head.step, "s"},
                text("One row every ", number(head.step), " s, and the arm moves on from row to row: the times are no seconds; --units t=", unit, " mends it."));
  return true;
}

}  // namespace

void check_motion(const Head& head, Findings* findings) {
  if (std::none_of(head.moves.begin(), head.moves.end(), [](bool moves) { return moves; })) {
    findings->add(Severity::kInfo, "no_motion", {}, {},
                  "No joint moves by more than 5 mrad or 5 mm: good for gravity and offsets only, which --at-rest identifies.");
    return;
  }
  if (check_clock(head, findings)) return;
  check_duration(head, findings);
  for (int j = 0; j < head.rows.joints(); ++j) {
    if (head.moves[j]) continue;
    const double range = range_of(head.rows.q, j);
    if (std::isnan(range)) continue;
    const Place place{"q", j + 1};
    findings->add(Severity::kInfo, "joint_at_rest", place, {kNone, range, unit_of("q")},
                  text("Joint ", j + 1, " holds its position (within ", number(range),
                       "): its friction and inertia cannot be told from here; --fix JOINT=VALUE holds it there."));
  }
  for (const std::vector<int>& group : correlated_columns(head.rows.q)) {
    std::vector<int> moving;
    for (const int j : group) {
      if (head.moves[j]) moving.push_back(j);
    }
    if (moving.size() < 2) continue;
    const auto same = [&](int j) { return are_equal(head.rows.q, moving.front(), head.rows.q, j); };
    findings->add(Severity::kWarning, "move_as_one", {"q", moving.front() + 1}, {},
                  text("Joints ", numbers_from_one(moving),
                       std::all_of(moving.begin(), moving.end(), same) ? " have the same position in every row: was one column written twice? What depends on"
                                                                       : " move as one: what depends on",
                       " one of them cannot be told from the others."));
  }
  for (const Load& load : loads_of(head.rows)) {
    int moving = 0, unsigned_ones = 0;
    for (int j = 0; j < head.rows.joints(); ++j) {
      if (!head.moves[static_cast<std::size_t>(j)]) continue;
      const std::vector<double> values = column_of(*load.values, j);
      ++moving;
      unsigned_ones += quantile(values, 0.0) >= 0.0 && quantile(values, 1.0) > 0.0 ? 1 : 0;
    }
    if (moving > 1 && unsigned_ones == moving)
      findings->add(Severity::kFault, "no_sign", {load.name, 0}, {},
                    text("No ", load.name, " of any moving joint is ever negative: sizes without a sign, of which no model can be made."));
    for (const RecordingSignal& signal : kRecordingSignals) {
      const MatrixXd& others = head.rows.*signal.values;
      if (&others != load.values && (signal.values == &Recording::tau || signal.values == &Recording::current)) continue;
      for (int j = 0; j < head.rows.joints() && others.cols() > 0; ++j) {
        for (int i = 0; i < (&others == load.values ? j : head.rows.joints()); ++i) {
          if (are_equal(others, i, *load.values, j))
            findings->add(Severity::kFault, "same_column", {load.name, j + 1}, {},
                          text(signal.name, i + 1, " and ", load.name, j + 1, " hold the same numbers in every row: one column was written twice, and another is missing."));
        }
      }
    }
  }
}

void check_start_up(const Head& head, Findings* findings) {
  for (const Load& load : loads_of(head.rows)) {
    double until = 0.0;
    double worst = 0.0;
    Place place{load.name, 0};
    for (int j = 0; j < head.rows.joints(); ++j) {
      const std::vector<double> sizes = ringing(head, *load.values, j);
      if (static_cast<int>(sizes.size()) < 2 * numbers.latest_start) continue;
      const double usual = quantile({sizes.begin() + numbers.latest_start, sizes.end()}, 1.0 - numbers.rare);
      int loud = 0;
      for (int w = 0; w < numbers.latest_start && w <= loud + 1; ++w) {
        if (sizes[w] > numbers.loud * usual) loud = w + 1;
      }
      if (loud < numbers.shortest_start || usual <= 0.0) continue;
      const double ratio = *std::max_element(sizes.begin(), sizes.begin() + loud) / usual;
      const int window = window_rows(head);
      until = std::max(until, loud * window * head.step);
      if (ratio > worst) place.joint = j + 1;
      worst = std::max(worst, ratio);
    }
    if (until == 0.0) continue;
    findings->add(Severity::kWarning, "start_up_transient", place, {kNone, until, "s"},
                  text("The ", word_of_load(load.name), " rings for ",
                       number(until), " s after the start, worst on joint ", place.joint, " (",
                       number(worst), " times the usual change): leave that part out."));
  }
}

void check_period(const MotionPeriod& period, Findings* findings) {
  if (!period.found()) return;
  findings->add(Severity::kInfo, "period", {}, {kNone, period.seconds, "s"},
                text("The motion repeats every ", period.seconds, " s, ", number(period.repeats),
                     " times: repeats give the noise floor."));
}

}  // namespace veridyn::quality
