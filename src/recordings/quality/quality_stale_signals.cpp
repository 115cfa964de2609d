// Finds signals that are refreshed more slowly than the rows are written.
#include <algorithm>
#include <cmath>

#include "recordings/quality/quality_checks.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::quality {
namespace {

// Share of rows that repeat the previous value in a regularly refreshed signal, from the usual time between its
// changes.
double regular_share(const Head& head, const Column& values, double least) {
  std::vector<double> held;  // [rows] times between changes
  int since = 0;
  for (int k = 1; k < values.size(); ++k) {
    if (head.stale[static_cast<std::size_t>(k)]) since = 0;
    if (values[k] == values[k - 1]) continue;
    if (since > 0 && std::abs(values[k] - values[since - 1]) > least) held.push_back(k - since);
    since = k;
  }
  const double usual = quantile(held, 0.5);
  double rows = 0.0, count = 0.0;
  for (const double length : held) {
    if (length > 2.0 * usual) continue;  // a pause of the motion
    rows += length;
    ++count;
  }
  return rows > 0.0 ? 1.0 - count / rows : 0.0;
}

// Share of the rows in which a signal repeats its value, among those in which it changes by so many steps of its
// resolution that equal values are no coincidence; 0 if these are few.
double share_of_repeats(const Head& head, const Channel& channel) {
  const auto values = channel.of(head.rows);
  double resolution = resolution_of(values);
  // A velocity derived from a coarse position has steps of the position's resolution over the time step.
  if (channel.is(&Recording::dq) && head.step > 0.0) resolution = std::max(resolution, 0.5 * resolution_of(head.rows.q.col(channel.joint)) / head.step);
  const double least = numbers.fine * resolution;
  long rows = 0, repeats = 0;
  for (int k = 2; k + 1 < values.size(); ++k) {
    const auto stale = head.stale.begin() + k;
    if (*(stale - 1) || *stale || *(stale + 1)) continue;
    if (!(std::abs(values[k + 1] - values[k - 2]) > least)) continue;
    ++rows;
    repeats += values[k] == values[k - 1] ? 1 : 0;
  }
  if (rows < numbers.fewest_fine) return 0.0;
  // Values held for more than these three rows are not counted above; regular_share() counts them.
  return std::max(share_of(repeats, rows), regular_share(head, values, least));
}

}  // namespace

void check_stale_signals(const Head& head, Findings* findings) {
  for (const Channel& channel : channels_of(head.rows)) {
    const double share = share_of_repeats(head, channel);
    if (share < numbers.repeating) continue;
    findings->add(Severity::kWarning, QualityKind::kStaleSignal, channel.place(), {share, kNone, ""},
                  text("The signal of ", channel.name(), " repeats its value in ", percent(share),
                       " of the rows in which it should change: refreshed too slowly, at about ", number((1.0 - share) / head.step), " Hz?"));
  }
}

}  // namespace veridyn::quality
