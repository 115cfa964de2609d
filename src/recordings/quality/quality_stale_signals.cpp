// Signals that are refreshed more slowly than the rows are written.
#include <algorithm>
#include <cmath>

#include "recordings/quality/quality_checks.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::quality {
namespace {

// Number of repeats of a signal's value, among rows in which the signal changes by so many steps of its
// resolution that equal values are no coincidence.
struct Repeats {
  long rows = 0;
  long count = 0;
};

Repeats repeats_of(const Head& head, const MatrixXd& values, int joint) {
  double resolution = resolution_of(values, joint);
  // A velocity that was derived from a coarse position has its steps.
  if (&values == &head.rows.dq && head.step > 0.0) resolution = std::max(resolution, 0.5 * resolution_of(head.rows.q, joint) / head.step);
  Repeats repeats;
  for (int k = 2; k + 1 < values.rows(); ++k) {
    const auto stale = head.stale.begin() + k;
    if (*(stale - 1) || *stale || *(stale + 1)) continue;
    if (!(std::abs(values(k + 1, joint) - values(k - 2, joint)) > numbers.fine * resolution)) continue;
    ++repeats.rows;
    repeats.count += values(k, joint) == values(k - 1, joint) ? 1 : 0;
  }
  return repeats;
}

}  // namespace

void check_stale_signals(const Head& head, Findings* findings) {
  for (const RecordingSignal& signal : kRecordingSignals) {
    const MatrixXd& values = head.rows.*signal.values;
    for (int j = 0; j < values.cols(); ++j) {
      const Repeats repeats = repeats_of(head, values, j);
      if (repeats.rows < numbers.fewest_fine) continue;
      const double share = share_of(repeats.count, repeats.rows);
      if (share < numbers.repeating) continue;
      const Place place{signal.name, j + 1};
      findings->add(Severity::kWarning, "stale_signal", place, {share, kNone, ""},
                    text("The signal of ", named(place), " repeats its value in ", percent(share),
                         " of the rows in which it should change: refreshed too slowly?"));
    }
  }
}

}  // namespace veridyn::quality
