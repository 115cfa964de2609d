#include "diagnosis/causes/geometry.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "diagnosis/causes/geometry_profiler.hpp"
#include "diagnosis/evidence/numerics.hpp"
#include "math/clustered_statistics.hpp"
#include "math/parallel.hpp"
#include "math/student_t.hpp"

namespace veridyn {
namespace {

// First step and reach of a profile, for angles, lengths and ratios.
struct SearchRange {
  double step;
  double reach;
};
constexpr SearchRange kAngles = {numerics::kAngleStep, numerics::kAngleReach};     // [rad]
constexpr SearchRange kLengths = {numerics::kLengthStep, numerics::kLengthReach};  // [m]
constexpr SearchRange kRatios = {numerics::kAngleStep, numerics::kAngleReach};     // of the ratio

SearchRange search_range(const FrameConstant& constant, double stated) {
  const std::string unit = unit_of(constant);
  if (unit == "1") return {kRatios.step * std::abs(stated), kRatios.reach * std::abs(stated)};
  return unit == "rad" ? kAngles : kLengths;
}

// Golden section on [low, high]; f is smooth with one minimum there.
template <typename F>
double minimum(double low, double high, const F& f) {
  double a = low + numerics::kGolden * (high - low);
  double b = high - numerics::kGolden * (high - low);
  double fa = f(a);
  double fb = f(b);
  for (int i = 0; i < numerics::kRefinements; ++i) {
    if (fa < fb) {
      high = b;
      b = a;
      fb = fa;
      a = low + numerics::kGolden * (high - low);
      fa = f(a);
    } else {
      low = a;
      a = b;
      fa = fb;
      b = high - numerics::kGolden * (high - low);
      fb = f(b);
    }
  }
  return fa < fb ? a : b;
}

// Scatter of an optimum: the minimum of a parabola through three values of the constant, leaving
// out one part of the recordings each; the larger of that and of whole recordings.
void measure_scatter(const Model& arm, const GeometryProfiler& profiler, const std::vector<int>& columns,
                     double step, GeometryFinding& out) {
  const std::array<Model, 3> variants = {with_constant(arm, out.constant, out.found - step),
                                         with_constant(arm, out.constant, out.found),
                                         with_constant(arm, out.constant, out.found + step)};
  const MatrixXd y = profiler.without_parts(variants, columns);
  MatrixXd least(1, y.rows());
  for (Eigen::Index k = 0; k < y.rows(); ++k) {
    const double bend = y(k, 0) - 2.0 * y(k, 1) + y(k, 2);
    const double shift = bend > 0.0 ? 0.5 * (y(k, 0) - y(k, 2)) / bend : 0.0;
    least(0, k) = out.found + step * std::clamp(shift, -1.0, 1.0);
  }
  out.deviation = jackknife_deviations(least)[0];
  out.degrees_of_freedom = static_cast<double>(y.rows() - 1);
  const int recordings = profiler.recordings();
  if (recordings < 3) return;
  // Parts of one recording share what is systematic to it. Leaving a whole one out moves the
  // optimum by the sum of its parts' shares, to first order.
  const Eigen::Index parts = y.rows() / recordings;
  MatrixXd whole(1, recordings);
  for (int r = 0; r < recordings; ++r) {
    whole(0, r) = out.found;
    for (Eigen::Index k = 0; k < parts; ++k)
      whole(0, r) += least(0, r * parts + k) - out.found;
  }
  const double of_recordings = jackknife_deviations(whole)[0];
  const double wider = student_t_quantile(numerics::kOutside, recordings - 1.0) /
                       student_t_quantile(numerics::kOutside, out.degrees_of_freedom);
  out.deviation = std::max(out.deviation, wider * of_recordings);
}

// The profile of one constant; gain 0 if there is nothing in it.
GeometryFinding profile(const Model& arm, const FrameConstant& constant,
                        const GeometryProfiler& profiler, int base, const Thresholds& limits) {
  GeometryFinding out;
  out.constant = constant;
  out.stated = value_in(arm, constant);
  out.base_before = base;
  const double v0 = out.stated;
  const SearchRange range = search_range(constant, v0);
  const auto columns =
      GeometryProfiler::independent(with_constant(arm, constant, v0 + numerics::kOffCentre * range.step));
  const auto at = [&](double v) {
    return profiler.criterion(with_constant(arm, constant, v), columns);
  };
  // Columns that are independent near the file's value may vanish at it, while others do not: there
  // the unmodified arm is the reference.
  const double centre = std::min(at(v0), profiler.start());
  const double up = at(v0 + range.step);
  const double down = at(v0 - range.step);
  if (std::min(up, down) > centre - 0.5 * limits.smallest_gain || (up < centre && down < centre))
    return out;
  const double sign = up < down ? 1.0 : -1.0;
  double inner = 0.0;
  double middle = range.step;
  double best = std::min(up, down);
  double outer = 2.0 * range.step;
  for (double next = at(v0 + sign * outer); next < best && outer < range.reach;
       next = at(v0 + sign * outer)) {
    inner = middle;
    middle = outer;
    best = next;
    outer *= numerics::kBracketGrowth;
  }
  if (outer >= range.reach) return out;  // still falling at the end of the range: no optimum inside
  out.found =
      v0 + sign * minimum(inner, outer, [&](double u) { return at(v0 + sign * u); });
  out.base_after =
      static_cast<int>(GeometryProfiler::independent(with_constant(arm, constant, out.found)).size());
  const double found = at(out.found);
  // An optimum with more base parameters than the unmodified arm is mere flexibility if the other
  // side of the file's value fits nearly as well.
  if (static_cast<int>(columns.size()) > base &&
      at(2.0 * v0 - out.found) - found < limits.constant_sharpness * (profiler.start() - found))
    return out;
  out.gain = profiler.start() - found;
  measure_scatter(arm, profiler, columns, 0.5 * range.step, out);
  return out;
}

// Frames between the world and the frame with the most joints above it.
std::vector<char> longest_chain(const Model& arm) {
  std::vector<int> depth(arm.frames().size(), 0);
  size_t last = 0;
  for (size_t k = 0; k < depth.size(); ++k) {
    const Frame& frame = arm.frames()[k];
    depth[k] = (frame.parent ? depth[frame.parent->value] : 0) +
               static_cast<int>(frame.type != JointType::kFixed);
    if (depth[k] > depth[last]) last = k;
  }
  std::vector<char> out(depth.size(), 0);
  for (std::optional<FrameIndex> k = FrameIndex{static_cast<int>(last)}; k; k = arm.frames()[k->value].parent)
    out[k->value] = 1;
  return out;
}

}  // namespace

std::vector<GeometryFinding> profile_geometry(const Model& arm,
                                              const std::vector<std::string>& train,
                                              const IdentificationOptions& options,
                                              const Thresholds& limits) {
  const GeometryProfiler profiler(arm, train, options);
  const std::vector<FrameConstant> constants = row_constants(arm);
  const auto base = static_cast<int>(GeometryProfiler::independent(arm).size());
  std::vector<GeometryFinding> all(constants.size());
  parallel_for(static_cast<int>(constants.size()), options.threads, [&](int k) {
    all[k] =
        profile(arm, constants[k], profiler, base, limits);
  });
  all.erase(std::remove_if(all.begin(), all.end(),
                           [&limits](const GeometryFinding& f) { return f.gain < 0.5 * limits.smallest_gain; }),
            all.end());
  std::sort(all.begin(), all.end(),
            [](const GeometryFinding& a, const GeometryFinding& b) { return a.gain > b.gain; });
  all.resize(std::min(all.size(), static_cast<size_t>(limits.kept_constants)));
  if (all.empty()) return all;
  // An angle between two branches may be wrong in either. An error in the longest chain would be
  // noticed at the tool, so the other branch is preferred.
  const std::vector<char> main_chain = longest_chain(arm);
  const double tie = limits.rival_share * all.front().gain;
  std::stable_sort(all.begin(), all.end(), [&](const GeometryFinding& a, const GeometryFinding& b) {
    const bool tied = a.gain > tie && b.gain > tie;
    if (!tied) return a.gain > b.gain;
    const auto in_main_chain = [&](const GeometryFinding& f) {
      return main_chain[f.constant.frame.value];
    };
    return in_main_chain(a) < in_main_chain(b);
  });
  return all;
}

}  // namespace veridyn
