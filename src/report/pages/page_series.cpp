#include "report/pages/page_series.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/json/json_value.hpp"

namespace veridyn {
namespace {

using Column = std::vector<double>;

constexpr std::size_t kFewestSamples = 500;  // below that a curve loses its shape
constexpr std::size_t kNumbers = 500000;     // on a page; about 8 bytes each
constexpr std::size_t kColumns = 6;          // columns of a joint: q, dq, ddq and three torques
constexpr double kResolution = 1e-4;         // share of a column's range
constexpr double kSameTime = 1e-6;           // [s]

std::size_t thinning(std::size_t rows, std::size_t wanted) {
  return std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(
                                      static_cast<double>(rows) / static_cast<double>(wanted))));
}

Column thinned(const Column& column, std::size_t step) {
  Column out;
  for (std::size_t k = 0; k < column.size(); k += step) out.push_back(column[k]);
  return out;
}

// Decimals that resolve a range.
int decimals(const Column& column) {
  double low = INFINITY;
  double high = -INFINITY;
  for (const double v : column) {
    if (!std::isfinite(v)) continue;
    low = std::min(low, v);
    high = std::max(high, v);
  }
  if (!(high > low)) return 6;
  return std::clamp(static_cast<int>(std::ceil(-std::log10(kResolution * (high - low)))), 0, 12);
}

std::string number(double value, int digits) {
  if (!std::isfinite(value)) return "null";
  std::string out = fmt::format("{:.{}f}", value, digits);
  if (digits > 0) {
    out.erase(out.find_last_not_of('0') + 1);
    if (out.back() == '.') out.pop_back();
  }
  return out == "-0" ? "0" : out;
}

std::string list(const Column& column, int digits) {
  std::string out = "[";
  for (const double v : column) {
    if (out.size() > 1) out += ',';
    out += number(v, digits);
  }
  return out + "]";
}

// A column on another time grid, interpolated; NaN outside.
Column on_grid(const Column& time, const Column& values, const Column& wanted) {
  Column out;
  std::size_t k = 0;
  for (const double t : wanted) {
    while (k + 1 < time.size() && time[k + 1] < t - kSameTime) ++k;
    const bool inside = k + 1 < time.size() && t > time[k] - kSameTime;
    if (!inside) {
      out.push_back(NAN);
      continue;
    }
    const double share = std::clamp((t - time[k]) / (time[k + 1] - time[k]), 0.0, 1.0);
    out.push_back(values[k] + share * (values[k + 1] - values[k]));
  }
  return out;
}

bool same_grid(const PredictionSeries& a, const PredictionSeries& b) {
  return a.time.size() == b.time.size() && !a.time.empty() &&
         std::abs(a.time.front() - b.time.front()) < kSameTime &&
         std::abs(a.time.back() - b.time.back()) < kSameTime;
}

// The extended model's torque at the recording's samples. It keeps its distance from the torque
// that it was fitted to, which a finding may have corrected (a drive gain, a delay), so that one
// measured curve serves both models.
Column extended_torque(const PredictionSeries& model, const PredictionSeries& extended,
                       std::size_t joint) {
  Column error;
  for (std::size_t k = 0; k < extended.time.size(); ++k) {
    error.push_back(extended.measured[joint][k] - extended.modelled[joint][k]);
  }
  if (!same_grid(model, extended)) error = on_grid(extended.time, error, model.time);
  Column out = model.measured[joint];
  for (std::size_t k = 0; k < out.size(); ++k) out[k] -= error[k];
  return out;
}

std::string joint_json(const PlottedRecording& recording, std::size_t joint, std::size_t step) {
  const PredictionSeries& s = recording.model->series;
  std::string out;
  const auto add = [&](const char* name, const Column& column, int digits) {
    out += fmt::format("{}\"{}\": {}", out.empty() ? "{" : ", ", name,
                       list(thinned(column, step), digits));
  };
  const int digits = decimals(s.measured[joint]);
  add("q", s.q[joint], decimals(s.q[joint]));
  add("dq", s.dq[joint], decimals(s.dq[joint]));
  add("ddq", s.ddq[joint], decimals(s.ddq[joint]));
  add("measured", s.measured[joint], digits);
  add("model", s.modelled[joint], digits);
  if (recording.extended != nullptr && recording.extended->series.time.size() > 1) {
    add("extended", extended_torque(s, recording.extended->series, joint), digits);
  }
  return out + "}";
}

std::string recording_json(const PlottedRecording& recording, std::size_t samples) {
  const PredictionSeries& s = recording.model->series;
  const std::size_t step = thinning(s.time.size(), samples);
  std::string joints;
  for (std::size_t i = 0; i < s.q.size(); ++i) {
    joints += fmt::format("{}{}", joints.empty() ? "" : ",\n", joint_json(recording, i, step));
  }
  const Json head = {{"source", recording.model->source}, {"role", recording.role}};
  const std::string names = head.dump(-1, ' ', false, Json::error_handler_t::replace);
  return fmt::format("{}, \"time\": {}, \"joints\": [\n{}]}}", names.substr(0, names.size() - 1),
                     list(thinned(s.time, step), 4), joints);
}

}  // namespace

std::string number_list(const std::vector<double>& values) {
  return list(values, decimals(values));
}

std::string series_json(const Model& arm, const std::vector<PlottedRecording>& recordings,
                        const std::string& command) {
  Json joints = Json::array();
  for (const Coordinate& c : arm.coordinates()) {
    joints.push_back({{"name", c.name},
                      {"unit", c.prismatic ? "m" : "rad"},
                      {"torque_unit", c.prismatic ? "N" : "N m"}});
  }
  const std::size_t columns = kColumns * std::max<std::size_t>(1, arm.coordinates().size());
  const std::size_t most = std::max<std::size_t>(1, kNumbers / (columns * kFewestSamples));
  const std::size_t shown = std::min(recordings.size(), most);
  const std::size_t samples =
      std::min(static_cast<std::size_t>(kCurveSamples), kNumbers / (columns * std::max<std::size_t>(1, shown)));
  Json head = {{"command", command}, {"joints", joints}, {"left_out", recordings.size() - shown}};
  std::string out = head.dump(-1, ' ', false, Json::error_handler_t::replace);
  out.pop_back();
  out += ",\n\"recordings\": [";
  for (std::size_t k = 0; k < shown; ++k) {
    out += k > 0 ? ",\n" : "\n";
    out += recording_json(recordings[k], samples);
  }
  return out + "]}\n";
}

}  // namespace veridyn
