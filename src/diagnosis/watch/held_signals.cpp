#include "diagnosis/watch/held_signals.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "math/numbers.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::watching {
namespace {

// change of a value >= kFine of the smallest ones of its signal: equal values between are no coincidence.
constexpr double kFine = 4.0;

}  // namespace

std::optional<HeldSignals::Stopped> HeldSignals::compare(const Row& row, const VectorXd& path, const VectorXd& fastest,
                                                         std::optional<double> sound) {
  const Eigen::Index n = arm_.joints(), count = row.x.size();
  latest_ = row.t;
  if (value_.size() == 0) {
    value_ = row.x;
    since_ = VectorXd::Constant(count, row.t);
    from_ = path;
    longest_ = VectorXd::Zero(count);
    never_changed_.assign(static_cast<size_t>(count), 1);
    stopped_.assign(static_cast<size_t>(count), 0);
  }
  std::optional<Stopped> out;
  for (Eigen::Index i = 0; i < count; ++i) {
    char& never = never_changed_[static_cast<size_t>(i)];
    char& stopped = stopped_[static_cast<size_t>(i)];
    const double held = row.t - since_[i];
    if (row.x[i] != value_[i]) {
      if (held <= numbers_.held) interpolate(i, row);
      if (never == 0 && sound) longest_[i] = std::max(longest_[i], *sound - since_[i]);
      never = stopped = 0;
      value_[i] = row.x[i];
      from_[i] = path[i];
      since_[i] = row.t;
      continue;
    }
    const bool moves = std::abs(path[i] - from_[i]) > numbers_.rest_share * fastest[i % n] * held;
    const bool longer = held > std::max(numbers_.pause, 2.0 * longest_[i]);
    if (stopped == 0 && (never != 0 || !moves || !longer)) continue;
    stopped = 1;
    const double since = out ? std::min(out->since, since_[i]) : since_[i];
    out = Stopped{since, text(i < n ? "q" : "tau", i % n + 1, " (", arm_.coordinates()[i % n].name, ") stays at ", value_[i], " while the joint moves")};
  }
  return out;
}

// On a line from the signal's last new value to that of the row.
void HeldSignals::interpolate(Eigen::Index i, const Row& row) {
  const double slope = (row.x[i] - value_[i]) / (row.t - since_[i]);
  for (auto r = waiting_.rbegin(); r != waiting_.rend() && r->t > since_[i]; ++r) r->x[i] = value_[i] + slope * (r->t - since_[i]);
}

std::optional<Row> HeldSignals::next() {
  if (waiting_.empty()) return {};
  const double t = waiting_.front().t;
  for (const double since : since_) {
    if (since < t && latest_ - since <= numbers_.held) return {};
  }
  Row out = std::move(waiting_.front());
  waiting_.pop_front();
  return out;
}

double HeldSignals::refresh_time(const std::deque<Row>& rows, Eigen::Index signals, double longest) {
  double slowest = 0.0;
  for (Eigen::Index i = 0; i < signals; ++i) {
    const auto change = [&](size_t k) { return std::abs(rows[k].x[i] - rows[k - 1].x[i]); };
    double resolution = kInfinity;
    for (size_t k = 1; k < rows.size(); ++k) resolution = change(k) > 0.0 ? std::min(resolution, change(k)) : resolution;
    double held = 0.0, count = 0.0, since = rows.front().t;
    for (size_t k = 1; k < rows.size(); ++k) {
      if (!(change(k) > 0.0)) continue;
      const double time = rows[k].t - std::exchange(since, rows[k].t);
      if (time > longest || change(k) < kFine * resolution) continue;
      held += time;
      count += 1.0;
    }
    if (count > 0.0) slowest = std::max(slowest, held / count);
  }
  return slowest;
}

}  // namespace veridyn::watching
