// Signals that are refreshed more slowly than the rows are written.
#include <algorithm>
#include <cmath>

#include "recordings/quality/quality_checks.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::quality {
namespace {

// Share of the rows in which a signal repeats its value, among those in which it changes by so many steps of its
// resolution that equal values are no coincidence.
struct Repeats {
  long rows = 0;
  double share = 0.0;
};

// Share of repeats of a signal that is refreshed regularly: that of its usual time between changes.
double regular_share(const Head& head, const MatrixXd& values, int joint, double least) {
  std::vector<double> held;  // rows
  int since = 0;
  for (int k = 1; k < values.rows(); ++k) {
    if (head.stale[static_cast<std::size_t>(k)]) since = 0;
    if (values(k, joint) == values(k - 1, joint)) continue;
    if (since > 0 && std::abs(values(k, joint) - values(since - 1, joint)) > least) held.push_back(k - since);
    since = k;
  }
  const double usual = quantile(held, 0.5);
  double rows = 0.0, count = 0.0;
  for (const double length : held) {
    if (length > 2.0 * usual) continue;  // a pause
    rows += length;
    ++count;
  }
  return rows > 0.0 ? 1.0 - count / rows : 0.0;
}

Repeats repeats_of(const Head& head, const MatrixXd& values, int joint) {
  double resolution = resolution_of(values, joint);
  // A velocity that was derived from a coarse position has its steps.
  if (&values == &head.rows.dq && head.step > 0.0) resolution = std::max(resolution, 0.5 * resolution_of(head.rows.q, joint) / head.step);
  Repeats repeats;
  long count = 0;
  for (int k = 2; k + 1 < values.rows(); ++k) {
    const auto stale = head.stale.begin() + k;
    if (*(stale - 1) || *stale || *(stale + 1)) continue;
    if (!(std::abs(values(k + 1, joint) - values(k - 2, joint)) > numbers.fine * resolution)) continue;
    ++repeats.rows;
    count += values(k, joint) == values(k - 1, joint) ? 1 : 0;
  }
  // A value that is held for longer than these three rows leaves windows without a change, which do not count above.
  if (repeats.rows > 0) repeats.share = std::max(share_of(count, repeats.rows), regular_share(head, values, joint, numbers.fine * resolution));
  return repeats;
}

}  // namespace

void check_stale_signals(const Head& head, Findings* findings) {
  for (const RecordingSignal& signal : kRecordingSignals) {
    const MatrixXd& values = head.rows.*signal.values;
    for (int j = 0; j < values.cols(); ++j) {
      const Repeats repeats = repeats_of(head, values, j);
      if (repeats.rows < numbers.fewest_fine) continue;
      const double share = repeats.share;
      if (share < numbers.repeating) continue;
      const Place place{signal.name, j + 1};
      findings->add(Severity::kWarning, "stale_signal", place, {share, kNone, ""},
                    text("The signal of ", named(place), " repeats its value in ", percent(share),
                         " of the rows in which it should change: refreshed too slowly, at about ", number((1.0 - share) / head.step), " Hz?"));
    }
  }
}

}  // namespace veridyn::quality
