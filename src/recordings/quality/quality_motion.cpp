// Checks of motion, torques and currents, on the first rows of a recording.
#include <algorithm>
#include <cmath>

#include "model/correlated_joints.hpp"
#include "recordings/quality/quality_checks.hpp"
#include "recordings/signals/units.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/recordings/preprocessing.hpp"

namespace veridyn::quality {
namespace {

// Usual size of a load's change over 20 ms in consecutive windows of 0.1 s. Single wrong values do not count.
std::vector<double> ringing(const Head& head, const Channel& load) {
  const auto values = load.of(head.rows);
  const int lag = std::max(1, static_cast<int>(std::lround(numbers.ringing / head.step)));
  const int window = window_rows(head);
  std::vector<double> sizes;
  for (int first = 0; first + window + lag <= values.size(); first += window) {
    std::vector<double> changes;
    for (int k = first; k < first + window; ++k) changes.push_back(std::abs(values[k + lag] - values[k]));
    sizes.push_back(quantile(changes, 1.0 - numbers.rare));
  }
  return sizes;
}

// True if two columns have the same numbers, which change.
bool are_equal(const Column& one, const Column& other) {
  long changes = 0;
  for (Eigen::Index k = 0; k < one.size(); ++k) {
    if (!std::isfinite(one[k]) && !std::isfinite(other[k])) continue;
    if (one[k] != other[k]) return false;
    changes += k > 0 && std::abs(one[k] - one[k - 1]) > 0.0 ? 1 : 0;
  }
  return 2 * changes > one.size();
}

// Checks that the motion is sufficient after the filter's transients at either end are cut.
void check_duration(const Head& head, Findings* findings) {
  const PreprocessingOptions usual;
  const double cut = usual.drop_start + usual.drop_end;
  const double seconds = head.rows.time[head.rows.rows() - 1] - head.rows.time[0];
  if (!(seconds < cut + kLeastSeconds)) return;
  findings->add(Severity::kFault, QualityKind::kShortRecording, {}, {kNone, seconds, "s"},
                text("The recording lasts ", number(seconds), " s, of which an identification cuts ", number(usual.drop_start), " s at the start and ",
                     number(usual.drop_end), " s at the end (--drop-start and --drop-end change that): ", number(kEnoughSeconds), " s and more are needed."));
}

// Checks the unit of time: steps of a second and more within one motion mean another unit.
bool check_clock(const Head& head, Findings* findings) {
  if (head.step < kSlowClock) return false;
  double onward = 0.0;
  for (int j = 0; j < head.rows.joints(); ++j) onward += head.moves[static_cast<std::size_t>(j)] ? mean_step_product(head.rows.q.col(j)) : 0.0;
  if (!(onward > 0.0)) return false;
  const char* unit = recordings::unit_of_clock(head.step);
  findings->add(Severity::kFault, QualityKind::kTimeUnit, {"t"}, {kNone, head.step, "s"},
                text("One row every ", number(head.step), " s, and the arm moves on from row to row: the times are no seconds; --units t=", unit, " mends it."));
  return true;
}

void check_rest(const Head& head, Findings* findings) {
  for (int j = 0; j < head.rows.joints(); ++j) {
    const double range = head.moves[static_cast<std::size_t>(j)] ? kNone : range_of(head.rows.q.col(j));
    if (std::isnan(range)) continue;
    const Channel position{&kRecordingSignals[0], j};
    findings->add(Severity::kInfo, QualityKind::kJointAtRest, position.place(), {kNone, range, position.unit()},
                  text("Joint ", j + 1, " holds its position (within ", number(range),
                       "): its friction and inertia cannot be told from here; --fix JOINT=VALUE holds it there."));
  }
}

void check_common_motion(const Head& head, Findings* findings) {
  for (const std::vector<JointIndex>& group : correlated_joints(head.rows.q)) {
    std::vector<JointIndex> moving;
    std::copy_if(group.begin(), group.end(), std::back_inserter(moving), [&](JointIndex j) { return head.moves[static_cast<std::size_t>(j.value)]; });
    if (moving.size() < 2) continue;
    const auto same = [&](JointIndex j) { return are_equal(head.rows.q.col(moving.front().value), head.rows.q.col(j.value)); };
    findings->add(Severity::kWarning, QualityKind::kMoveAsOne, {"q", moving.front()}, {},
                  text("Joints ", numbers_from_one(moving),
                       std::all_of(moving.begin(), moving.end(), same) ? " have the same position in every row: was one column written twice? What depends on"
                                                                       : " move as one: what depends on",
                       " one of them cannot be told from the others."));
  }
}

// True if a signal has positive values and no negative ones.
bool has_no_sign(const Column& values) {
  const std::vector<double> all(values.begin(), values.end());
  return quantile(all, 0.0) >= 0.0 && quantile(all, 1.0) > 0.0;
}

// Checks one signal of torques or currents: its signs, and copies of other columns.
void check_load(const Head& head, const RecordingSignal& signal, Findings* findings) {
  std::vector<Channel> moving = head.moving_loads();
  moving.erase(std::remove_if(moving.begin(), moving.end(), [&](const Channel& c) { return !c.is(signal.values); }), moving.end());
  if (moving.size() > 1 && std::all_of(moving.begin(), moving.end(), [&](const Channel& c) { return has_no_sign(c.of(head.rows)); }))
    findings->add(Severity::kFault, QualityKind::kNoSign, {signal.name}, {},
                  text("No ", signal.name, " of any moving joint is ever negative: sizes without a sign, of which no model can be made."));
  for (const RecordingSignal& other : kRecordingSignals) {
    const bool other_load = is_load(other) && &other != &signal;
    for (int j = 0; j < head.rows.joints() && !other_load && (head.rows.*other.values).cols() > 0; ++j) {
      for (int i = 0; i < (&other == &signal ? j : head.rows.joints()); ++i) {
        if (!are_equal((head.rows.*other.values).col(i), (head.rows.*signal.values).col(j))) continue;
        findings->add(Severity::kFault, QualityKind::kSameColumn, {signal.name, JointIndex{j}}, {},
                      text(other.name, i + 1, " and ", signal.name, j + 1,
                           " hold the same numbers in every row: one column was written twice, and another is missing."));
      }
    }
  }
}

}  // namespace

void check_motion(const Head& head, Findings* findings) {
  if (std::none_of(head.moves.begin(), head.moves.end(), [](bool moves) { return moves; })) {
    findings->add(Severity::kInfo, QualityKind::kNoMotion, {}, {},
                  "No joint moves by more than 5 mrad or 5 mm: good for gravity and offsets only, which --at-rest identifies.");
    return;
  }
  if (check_clock(head, findings)) return;
  check_duration(head, findings);
  check_rest(head, findings);
  check_common_motion(head, findings);
  for (const RecordingSignal& signal : kRecordingSignals) {
    if (is_load(signal) && (head.rows.*signal.values).cols() > 0) check_load(head, signal, findings);
  }
}

void check_start_up(const Head& head, Findings* findings) {
  for (const RecordingSignal& signal : kRecordingSignals) {
    if (!is_load(signal)) continue;
    double until = 0.0, worst = 0.0;
    Channel worst_load{&signal, -1};
    for (const Channel& load : channels_of(head.rows)) {
      if (load.signal != &signal) continue;
      const std::vector<double> sizes = ringing(head, load);
      if (static_cast<int>(sizes.size()) < 2 * numbers.latest_start) continue;
      const double usual = quantile({sizes.begin() + numbers.latest_start, sizes.end()}, 1.0 - numbers.rare);
      int loud = 0, count = 0;  // one loud window is a step, as that of dry friction where a joint turns round
      for (int w = 0; w < numbers.latest_start && w <= loud + 1; ++w) {
        if (sizes[w] > numbers.loud * usual) loud = w + 1, ++count;
      }
      if (count < numbers.shortest_start || usual <= 0.0) continue;
      const double ratio = *std::max_element(sizes.begin(), sizes.begin() + loud) / usual;
      until = std::max(until, loud * window_rows(head) * head.step);
      if (ratio > worst) worst_load = load;
      worst = std::max(worst, ratio);
    }
    if (until == 0.0) continue;
    findings->add(Severity::kWarning, QualityKind::kStartUpTransient, worst_load.place(), {kNone, until, "s"},
                  text("The ", worst_load.load_word(), " rings for ", number(until), " s after the start, worst on joint ",
                       worst_load.joint + 1, " (", number(worst), " times the usual change): leave that part out."));
  }
}

}  // namespace veridyn::quality
