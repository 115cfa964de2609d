#include "diagnosis/causes/snags.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "math/median.hpp"
#include "diagnosis/evidence/clustered_fit.hpp"
#include "diagnosis/evidence/numerics.hpp"

namespace veridyn {
namespace {

constexpr double kMargin = 0.5;  // bins on either side

struct TravelStatistics {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  double speed = 0.0;
  double torque2 = 0.0;
  double samples = 0.0;

  int bin(double q) const {
    const double share = (q - low) / std::max(high - low, numerics::kNoise);
    return std::clamp(static_cast<int>(share * numerics::kTravelBins), 0, numerics::kTravelBins - 1);
  }
  double edge(double bin) const { return low + bin * (high - low) / numerics::kTravelBins; }
};

TravelStatistics travel_statistics(const std::vector<const RecordingError*>& all, size_t joint) {
  TravelStatistics travel;
  for (const RecordingError* r : all) {
    for (size_t k = 0; k < r->series.time.size(); ++k) {
      travel.low = std::min(travel.low, r->series.q[joint][k]);
      travel.high = std::max(travel.high, r->series.q[joint][k]);
      travel.speed = std::max(travel.speed, std::abs(r->series.dq[joint][k]));
      travel.torque2 += std::pow(r->series.measured[joint][k], 2);
      travel.samples += 1.0;
    }
  }
  return travel;
}

// Half the difference of the mean residuals to and fro, per bin; NaN where one is missing.
std::vector<double> friction_by_place(const PredictionSeries& x, size_t joint, const TravelStatistics& travel,
                                      double moving_share) {
  std::vector<double> sum[2] = {std::vector<double>(numerics::kTravelBins), std::vector<double>(numerics::kTravelBins)};
  std::vector<int> count[2] = {std::vector<int>(numerics::kTravelBins), std::vector<int>(numerics::kTravelBins)};
  for (size_t k = 0; k < x.time.size(); ++k) {
    const double v = x.dq[joint][k];
    if (std::abs(v) < moving_share * travel.speed) continue;
    const int side = v > 0.0 ? 1 : 0;
    const auto bin = static_cast<size_t>(travel.bin(x.q[joint][k]));
    sum[side][bin] += x.measured[joint][k] - x.modelled[joint][k];
    ++count[side][bin];
  }
  std::vector<double> out(numerics::kTravelBins, std::numeric_limits<double>::quiet_NaN());
  for (size_t b = 0; b < out.size(); ++b) {
    if (count[0][b] < numerics::kFewestInBin || count[1][b] < numerics::kFewestInBin) continue;
    out[b] = 0.5 * (sum[1][b] / count[1][b] - sum[0][b] / count[0][b]);
  }
  return out;
}

// Friction above the median of the recordings, place by place.
std::vector<std::vector<double>> excess(std::vector<std::vector<double>> friction) {
  for (size_t b = 0; b < numerics::kTravelBins; ++b) {
    std::vector<double> here;
    for (const auto& f : friction) {
      if (std::isfinite(f[b])) here.push_back(f[b]);
    }
    const double usual = median(here);
    for (auto& f : friction)
      f[b] = here.size() >= 3 ? f[b] - usual : std::numeric_limits<double>::quiet_NaN();
  }
  return friction;
}

void snags_of(const std::vector<const RecordingError*>& all, size_t joint,
              const Thresholds& limits, std::vector<Snag>& out) {
  const TravelStatistics travel = travel_statistics(all, joint);
  if (!(travel.high > travel.low) || travel.torque2 == 0.0) return;
  std::vector<std::vector<double>> friction;
  for (const RecordingError* r : all) friction.push_back(friction_by_place(r->series, joint, travel, limits.moving_share));
  friction = excess(std::move(friction));
  std::vector<double> sizes;
  for (const auto& f : friction) {
    for (const double e : f) {
      if (std::isfinite(e)) sizes.push_back(std::abs(e));
    }
  }
  const double limit = std::max(limits.snag_prominence * kMadToDeviation * median(sizes),
                                limits.snag_torque_share * std::sqrt(travel.torque2 / travel.samples));
  for (size_t r = 0; r < all.size(); ++r) {
    for (int b = 0; b < numerics::kTravelBins; ++b) {
      if (!(friction[r][b] > limit)) continue;
      int end = b + 1;
      double sum = friction[r][b];
      // The snag extends while the excess stays above half of the limit.
      while (end < numerics::kTravelBins && friction[r][end] > 0.5 * limit)
        sum += friction[r][end++];
      int begin = b;
      while (begin > 0 && friction[r][begin - 1] > 0.5 * limit)
        sum += friction[r][--begin];
      b = end;
      if (end - begin > limits.snag_widest * numerics::kTravelBins) continue;
      out.push_back({all[r]->source, static_cast<int>(joint), travel.edge(begin - kMargin),
                     travel.edge(end + kMargin), sum / (end - begin)});
    }
  }
}

std::vector<const RecordingError*> all_of(const Identification& id) {
  std::vector<const RecordingError*> out;
  for (const RecordingError& r : id.train) out.push_back(&r);
  for (const RecordingError& r : id.test) {
    const bool known = std::any_of(out.begin(), out.end(), [&](const RecordingError* other) {
      return other->source == r.source;
    });
    if (!known) out.push_back(&r);
  }
  return out;
}

}  // namespace

std::vector<Snag> find_snags(const Identification& id, const Thresholds& limits) {
  std::vector<Snag> out;
  const std::vector<const RecordingError*> all = all_of(id);
  if (all.size() < 3) return out;
  for (int i = 0; i < id.model->joints(); ++i) snags_of(all, static_cast<size_t>(i), limits, out);
  return out;
}

std::string snag_text(const Snag& snag, const Coordinate& joint) {
  return fmt::format(
      "a local sticking spot: joint {} ({}) has {:.2g} {} more friction between {:.0f} and {:.0f} {} "
      "than in the other recordings; these rows are left out of the fit for this joint",
      snag.joint + 1, joint.name, snag.friction, effort_unit(joint), numerics::kThousand * snag.from,
      numerics::kThousand * snag.to, joint.prismatic ? "mm" : "mrad");
}

std::vector<ExcludedInterval> excluded_intervals(const std::vector<Snag>& snags, const Identification& id) {
  std::vector<ExcludedInterval> out;
  for (const RecordingError* r : all_of(id)) {
    const PredictionSeries& x = r->series;
    for (const Snag& snag : snags) {
      if (snag.source != r->source) continue;
      const std::vector<double>& q = x.q[snag.joint];
      for (size_t k = 0; k < q.size(); ++k) {
        if (q[k] < snag.from || q[k] > snag.to) continue;
        const double begin = x.time[k];
        while (k + 1 < q.size() && q[k + 1] >= snag.from && q[k + 1] <= snag.to) ++k;
        out.push_back({snag.source, snag.joint, begin, x.time[k], "snag"});
      }
    }
  }
  return out;
}

}  // namespace veridyn
