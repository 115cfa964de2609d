#include "diagnosis/causes/ripple.hpp"

#include <algorithm>
#include <cmath>

#include "diagnosis/evidence/numerics.hpp"
#include "math/median.hpp"
#include "math/spectral_lines.hpp"

namespace veridyn {
namespace {

constexpr double kStep = 0.5;  // of the grid, in waves per travel
constexpr size_t kMostOrders = 2;

struct Cloud {
  std::vector<double> s, r;
};

// Position and residual of one joint, of all training recordings, evenly thinned.
Cloud cloud_of(const Identification& id, size_t joint) {
  Cloud out;
  size_t total = 0;
  for (const RecordingError& recording : id.train) total += recording.series.time.size();
  const size_t step = std::max<size_t>(1, total / static_cast<size_t>(numerics::kSpectrumSamples));
  for (const RecordingError& recording : id.train) {
    const PredictionSeries& x = recording.series;
    for (size_t k = 0; k < x.time.size(); k += step) {
      out.s.push_back(x.q[joint][k]);
      out.r.push_back(x.measured[joint][k] - x.modelled[joint][k]);
    }
  }
  return out;
}

std::vector<double> peaks(const Cloud& c, const Thresholds& limits) {
  if (c.s.size() < numerics::kFewestSpectrumSamples) return {};
  const auto [low, high] = std::minmax_element(c.s.begin(), c.s.end());
  const double travel = *high - *low;
  if (travel <= 0.0) return {};
  const double unit = 2.0 * M_PI / travel;  // one wave per travel
  const auto count = static_cast<size_t>(
      std::max(0.0, std::ceil((limits.ripple_finest - limits.ripple_waves) / kStep)));
  const std::vector<double> sizes = line_amplitudes(c.s, c.r, limits.ripple_waves * unit, kStep * unit, count);
  if (sizes.empty()) return {};
  const double floor = limits.ripple_prominence * median(sizes);
  std::vector<std::pair<double, double>> found;
  for (size_t k = 1; k + 1 < sizes.size(); ++k) {
    if (sizes[k] < floor || sizes[k] < sizes[k - 1] || sizes[k] < sizes[k + 1]) continue;
    // The top of the parabola through three points.
    const double bend = sizes[k - 1] - 2.0 * sizes[k] + sizes[k + 1];
    const double shift = bend < 0.0 ? 0.5 * (sizes[k - 1] - sizes[k + 1]) / bend : 0.0;
    const double waves = limits.ripple_waves + kStep * (static_cast<double>(k) + shift);
    found.emplace_back(sizes[k], waves * unit);
  }
  std::sort(found.rbegin(), found.rend());
  found.resize(std::min<size_t>(found.size(), kMostOrders));
  std::vector<double> out;
  for (const auto& [size, order] : found) out.push_back(order);
  return out;
}

}  // namespace

std::vector<std::vector<double>> ripple_orders(const Identification& id, const Thresholds& limits) {
  std::vector<std::vector<double>> out;
  for (int i = 0; i < id.model->joints(); ++i)
    out.push_back(peaks(cloud_of(id, static_cast<size_t>(i)), limits));
  return out;
}

}  // namespace veridyn
