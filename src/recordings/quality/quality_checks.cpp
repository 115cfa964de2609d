#include "recordings/quality/quality_checks.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "veridyn/math/require.hpp"

namespace veridyn::quality {
namespace {

// True if two numbers are exactly equal or both missing.
bool same(double a, double b) {
  return a == b || (std::isnan(a) && std::isnan(b));
}

std::vector<double> list_of(const Column& values) {
  return {values.data(), values.data() + values.size()};
}

std::vector<double>::iterator quantile_position(std::vector<double>& values, double share) {
  return values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
}

void remove_missing(std::vector<double>& values) {
  values.erase(std::remove_if(values.begin(), values.end(), [](double x) { return std::isnan(x); }),
               values.end());
}

}  // namespace

void Findings::add(Severity severity, QualityKind kind, const Place& place, const Size& size, const std::string& sentence) {
  quality_->findings.push_back({quality_->file, kind, place.signal, place.joint, size.share, size.value, size.unit, severity, sentence});
}

void Findings::add_saturated(const std::vector<SaturatedInterval>& intervals) {
  quality_->saturated.insert(quality_->saturated.end(), intervals.begin(), intervals.end());
}

std::string Channel::name() const {
  return text("joint ", joint + 1, " (", signal->name, joint + 1, ")");
}

std::string Channel::unit() const {
  if (is(&Recording::q)) return "rad or m";
  if (is(&Recording::dq)) return "rad/s or m/s";
  if (is(&Recording::tau)) return "N m or N";
  return is(&Recording::current) ? "A" : "";
}

std::vector<Channel> channels_of(const Recording& rows) {
  std::vector<Channel> channels;
  for (const RecordingSignal& signal : kRecordingSignals) {
    for (int j = 0; j < (rows.*signal.values).cols(); ++j) channels.push_back({&signal, j});
  }
  return channels;
}

std::string number(double value) {
  char digits[32];
  if (value == 0.0) return "0";  // never "-0"
  std::snprintf(digits, sizeof digits,
                std::abs(value) >= kPlainFrom && std::abs(value) < kPlainTo ? "%.0f" : "%.4g", value);
  return digits;
}

std::string percent(double share) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.2g %%", 100.0 * share);
  return share >= kWhole ? "100 %" : digits;
}

std::string counted(long count, const std::string& noun) {
  return text(count, " ", noun, count == 1 ? "" : "s");
}

double share_of(long count, long rows) {
  return static_cast<double>(count) / static_cast<double>(rows);
}

double quantile(std::vector<double> values, double share) {
  remove_missing(values);
  if (values.empty()) return kNone;
  const auto place = quantile_position(values, share);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

bool quantile_exceeds(const std::vector<double>& values, double share, double bound) {
  const auto count = [&](auto counted) { return std::count_if(values.begin(), values.end(), counted); };
  const auto present = count([](double x) { return !std::isnan(x); });
  return present > 0 && count([=](double x) { return x <= bound; }) <=
                            static_cast<std::ptrdiff_t>(share * static_cast<double>(present - 1));
}

double between_quantiles(std::vector<double> values, double low, double high) {
  remove_missing(values);
  if (values.empty()) return kNone;
  const auto upper = quantile_position(values, high);
  std::nth_element(values.begin(), upper, values.end());
  const double at_high = *upper;
  const auto lower = quantile_position(values, low);
  if (lower != upper) std::nth_element(values.begin(), lower, upper);
  return at_high - *lower;
}

double range_of(const Column& values) {
  return between_quantiles(list_of(values), numbers.ends, 1.0 - numbers.ends);
}

std::vector<double> changes_of(const Column& values) {
  std::vector<double> changes;
  for (Eigen::Index k = 1; k < values.size(); ++k) {
    const double change = std::abs(values[k] - values[k - 1]);
    if (change > 0.0) changes.push_back(change);
  }
  return changes;
}

double resolution_of(const Column& values) {
  std::vector<double> changes = changes_of(values);
  return changes.empty() ? 0.0 : quantile(std::move(changes), numbers.ends);
}

bool is_moving(const Recording& rows, int k) {
  if (rows.dq.cols() > 0) return (rows.dq.row(k).array() != 0.0).any();
  return (rows.q.row(k).array() != rows.q.row(std::max(0, k - kContext)).array()).any();
}

bool is_stale(const Recording& rows, int k) {
  if (k == 0) return false;
  bool any = false;
  for (const RecordingSignal& signal : kRecordingSignals) {
    const MatrixXd& values = rows.*signal.values;
    for (int j = 0; j < values.cols(); ++j) {
      if (!same(values(k, j), values(k - 1, j))) return false;
      any = any || !std::isnan(values(k, j));
    }
  }
  return any && is_moving(rows, k);
}

double mean_step_product(const Column& q) {
  double onward = 0.0;
  for (Eigen::Index k = 2; k < q.size(); ++k) {
    const double product = (q[k - 1] - q[k - 2]) * (q[k] - q[k - 1]);
    if (std::isfinite(product)) onward += product;
  }
  return onward;
}

Head::Head(const Recording& recording) : rows(recording) {
  const int count = rows.rows();
  std::vector<double> steps;
  for (int k = 1; k < count; ++k) steps.push_back(rows.time[k] - rows.time[k - 1]);
  step = quantile(steps, 0.5);
  shortest = quantile(steps, numbers.ends);
  longest = quantile(steps, 1.0 - numbers.ends);
  for (int j = 0; j < rows.joints(); ++j) moves.push_back(range_of(rows.q.col(j)) > numbers.resting_range);
  for (int k = 0; k < count; ++k) stale.push_back(is_stale(rows, k));
}

std::vector<Channel> Head::moving_loads() const {
  std::vector<Channel> loads = channels_of(rows);
  const auto is_other = [this](const Channel& c) { return !is_load(*c.signal) || !moves[static_cast<std::size_t>(c.joint)]; };
  loads.erase(std::remove_if(loads.begin(), loads.end(), is_other), loads.end());
  return loads;
}

int window_rows(const Head& head) {
  return std::max(numbers.shortest_window, static_cast<int>(std::lround(numbers.window / head.step)));
}

}  // namespace veridyn::quality
