#include "diagnosis/search/vibration.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "diagnosis/numerics.hpp"
#include "math/spectral_lines.hpp"

namespace veridyn {
namespace {

double duration(const RecordingError& r) {
  return r.series.time.size() < 2 ? 0.0 : r.series.time.back() - r.series.time.front();
}

std::vector<double> centred(std::vector<double> x) {
  double mean = 0.0;
  for (const double v : x) mean += v / static_cast<double>(x.size());
  for (double& v : x) v -= mean;
  return x;
}

// Measured minus modelled torque of a joint, minus its mean.
std::vector<double> residual_of(const PredictionSeries& x, size_t joint) {
  std::vector<double> out;
  for (size_t k = 0; k < x.time.size(); ++k) out.push_back(x.measured[joint][k] - x.modelled[joint][k]);
  return centred(std::move(out));
}

double mean_square(const std::vector<double>& x) {
  double out = 0.0;
  for (const double v : x) out += v * v / static_cast<double>(x.size());
  return std::max(out, numerics::kTiny);
}

// Share that one angular frequency has in the mean square of a centred signal.
double share_of_line(const std::vector<double>& time, const std::vector<double>& signal, double frequency) {
  const double amplitude = line_amplitudes(time, signal, frequency, 0.0, 1).front();
  return 0.5 * amplitude * amplitude / mean_square(signal);
}

// Angular frequency of the largest line in the training recordings; 0: none of them is long enough.
double largest_line(const Identification& id, size_t joint) {
  double longest = 0.0, shortest = std::numeric_limits<double>::infinity(), highest = shortest;
  for (const RecordingError& r : id.train) {
    const double length = duration(r);
    if (length <= 0.0) return 0.0;
    longest = std::max(longest, length);
    shortest = std::min(shortest, length);
    highest = std::min(highest, 0.5 * static_cast<double>(r.series.time.size() - 1) / length);
  }
  if (id.preprocessing.cutoff > 0.0) highest = std::min(highest, id.preprocessing.cutoff);
  const double first = numerics::kVibrationWaves / shortest, step = numerics::kVibrationStep / longest;
  if (!(highest > first)) return 0.0;
  const auto count = static_cast<size_t>((highest - first) / step) + 1;
  std::vector<double> shares(count, 0.0);
  for (const RecordingError& r : id.train) {
    const std::vector<double> residual = residual_of(r.series, joint);
    const double all = mean_square(residual);
    const std::vector<double> lines =
        line_amplitudes(r.series.time, residual, 2.0 * M_PI * first, 2.0 * M_PI * step, count);
    for (size_t k = 0; k < count; ++k) shares[k] += lines[k] * lines[k] / all;
  }
  const size_t at = std::max_element(shares.begin(), shares.end()) - shares.begin();
  double top = static_cast<double>(at);
  if (at > 0 && at + 1 < count) {  // maximum of the parabola through three points
    const double bend = shares[at - 1] - 2.0 * shares[at] + shares[at + 1];
    if (bend < 0.0) top += 0.5 * (shares[at - 1] - shares[at + 1]) / bend;
  }
  return 2.0 * M_PI * (first + step * top);
}

}  // namespace

std::optional<Vibration> vibration_of(const Identification& id, int joint, const Thresholds& limits) {
  const auto j = static_cast<size_t>(joint);
  if (id.train.size() < 2 || id.test.empty()) return std::nullopt;
  const double frequency = largest_line(id, j);
  if (frequency == 0.0) return std::nullopt;
  Vibration out;
  out.frequency = frequency / (2.0 * M_PI);
  for (const RecordingError& r : id.test) {
    const PredictionSeries& x = r.series;
    if (duration(r) <= 0.0) return std::nullopt;
    const std::vector<double> residual = residual_of(x, j);
    const double share = share_of_line(x.time, residual, frequency);
    for (const auto* signals : {&x.q, &x.dq, &x.modelled}) {
      for (const std::vector<double>& signal : *signals) {
        if (share_of_line(x.time, centred(signal), frequency) > limits.line_of_motion * share) return std::nullopt;
      }
    }
    const auto all = static_cast<double>(id.test.size());
    out.share += share / all;
    out.amplitude += std::sqrt(2.0 * share * mean_square(residual)) / all;
  }
  if (out.share < limits.unnamed_share) return std::nullopt;
  return out;
}

}  // namespace veridyn
