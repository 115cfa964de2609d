#include "report/pages/page_series.hpp"

#include <algorithm>
#include <cmath>

namespace veridyn {
namespace {

using Column = std::vector<double>;

constexpr std::size_t kFewestSamples = 500;  // smallest number of samples of a curve; fewer would distort it
constexpr std::size_t kNumbers = 330000;     // largest number of numbers on a page; about 2.7 bytes each
constexpr std::size_t kColumns = 6;          // columns per joint: q, dq, ddq and three torques
constexpr double kSteps = 65533.0;           // number of steps between the ends of a packed column
constexpr unsigned kMissing = 65535;
constexpr double kTimeStep = 1e-4;           // [s] resolution of times
constexpr double kSameTime = 1e-6;           // [s] smaller differences are rounding

VectorXd vector_of(const Column& column) {
  return Eigen::Map<const VectorXd>(column.data(), static_cast<Eigen::Index>(column.size()));
}

// A column interpolated on another time grid; NaN outside.
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

// The extended model's torque at the recording's samples. It is shifted by the difference between
// the torques to which the two models were fitted (a finding may have corrected a drive gain or a
// delay), so that one measured curve serves both.
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

// Packed columns of a joint (from 0), every `step`-th sample.
Json joint_json(const PlottedRecording& recording, std::size_t joint, Eigen::Index step) {
  const PredictionSeries& s = recording.model->series;
  Json out;
  const auto add = [&](const char* name, const Column& column) {
    out[name] = packed_values(vector_of(column), step);
  };
  add("q", s.q[joint]);
  add("dq", s.dq[joint]);
  add("ddq", s.ddq[joint]);
  add("measured", s.measured[joint]);
  add("model", s.modelled[joint]);
  if (recording.extended != nullptr && recording.extended->series.time.size() > 1)
    add("extended", extended_torque(s, recording.extended->series, joint));
  return out;
}

}  // namespace

std::string base64(std::string_view bytes) {
  static const char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t k = 0; k < bytes.size(); k += 3) {
    unsigned group = 0;
    for (std::size_t i = 0; i < 3; ++i)
      group = group << 8 | (k + i < bytes.size() ? static_cast<unsigned char>(bytes[k + i]) : 0u);
    for (std::size_t i = 0; i < 4; ++i)
      out += k + i > bytes.size() ? '=' : kDigits[group >> (18 - 6 * i) & 63];
  }
  return out;
}

Json packed_values(const VectorRef& values, Eigen::Index step) {
  double low = INFINITY, high = -INFINITY;
  for (const double v : values) {
    if (!std::isfinite(v)) continue;
    low = std::min(low, v);
    high = std::max(high, v);
  }
  const double unit = high > low ? (high - low) / (kSteps - 1.0) : 0.0;
  const double from = unit > 0.0 ? unit * std::floor(low / unit) : std::isfinite(low) ? low : 0.0;
  std::string bytes;
  for (Eigen::Index k = 0; k < values.size(); k += step) {
    const unsigned at = !std::isfinite(values[k]) ? kMissing
                        : unit > 0.0 ? static_cast<unsigned>(std::lround((values[k] - from) / unit))
                                     : 0u;
    bytes += static_cast<char>(at & 255u);
    bytes += static_cast<char>(at >> 8);
  }
  return {{"from", from}, {"step", unit}, {"int16", base64(bytes)}};
}

Json times(const VectorRef& time, Eigen::Index step) {
  Json out = Json::array();
  for (Eigen::Index k = 0; k < time.size(); k += step)
    out.push_back(std::round(time[k] / kTimeStep) / (1.0 / kTimeStep));
  return out;
}

Json series_of(const std::string& command) {
  return {{"command", command}, {"joints", Json::array()}, {"arms", Json::array()},
          {"recordings", Json::array()}, {"left_out", 0}};
}

Json series_of(const std::string& command, const Model& arm) {
  Json out = series_of(command);
  for (const Coordinate& c : arm.coordinates())
    out["joints"].push_back(
        {{"name", c.name}, {"unit", position_unit(c)}, {"torque_unit", effort_unit(c)}});
  out["arms"].push_back(arm_json(arm));
  return out;
}

Json curve_json(const std::string& name, const std::string& style, Json values) {
  return {{"name", name}, {"style", style}, {"values", std::move(values)}};
}

Json plot_json(const char* kind, const std::string& title, const std::string& unit, Json curves) {
  return {{"kind", kind}, {"title", title}, {"unit", unit}, {"curves", std::move(curves)}};
}

Eigen::Index curve_step(Eigen::Index rows) {
  return std::max<Eigen::Index>(1, rows / kCurveSamples);
}

void add_recordings(Json& series, const std::vector<PlottedRecording>& recordings) {
  const std::size_t columns = kColumns * std::max<std::size_t>(1, series["joints"].size());
  const std::size_t most = std::max<std::size_t>(1, kNumbers / (columns * kFewestSamples));
  const std::size_t shown = std::min(recordings.size(), most);
  const std::size_t each = kNumbers / (columns * std::max<std::size_t>(1, shown));
  const double samples = std::min(static_cast<double>(kCurveSamples), static_cast<double>(each));
  series["left_out"] = recordings.size() - shown;
  for (std::size_t k = 0; k < shown; ++k) {
    const PredictionSeries& s = recordings[k].model->series;
    const auto step = std::max<Eigen::Index>(
        1, static_cast<Eigen::Index>(std::lround(static_cast<double>(s.time.size()) / samples)));
    Json joints = Json::array();
    for (std::size_t i = 0; i < s.q.size(); ++i) joints.push_back(joint_json(recordings[k], i, step));
    series["recordings"].push_back({{"source", recordings[k].model->source},
                                    {"role", recordings[k].role},
                                    {"time", times(vector_of(s.time), step)},
                                    {"joints", joints}});
  }
}

}  // namespace veridyn
