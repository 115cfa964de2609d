#include "diagnosis/search/shape_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/numerics.hpp"

// Descriptions of a curve, by shares of the curve's own range.

namespace veridyn {
namespace {

using numerics::kShapeFlat;
using numerics::kShapeMost;

struct Curve {
  std::vector<double> x, y;
  double low = 0.0, high = 0.0;

  double range() const { return high - low; }
};

// The curve over the first signal through `count` points, beginning with point `first`.
Curve curve_of(const UnnamedShape& shape, size_t first, size_t count) {
  Curve c;
  for (size_t k = first; k < first + count; ++k) {
    c.x.push_back(shape.curve[k].at.front());
    c.y.push_back(shape.curve[k].value);
  }
  const auto [low, high] = std::minmax_element(c.y.begin(), c.y.end());
  c.low = *low;
  c.high = *high;
  return c;
}

// Largest deviation of the curve from a straight line, as a share of its range.
double deviation_from_line(const Curve& c) {
  double sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  const auto n = static_cast<double>(c.x.size());
  for (size_t k = 0; k < c.x.size(); ++k) {
    sx += c.x[k];
    sy += c.y[k];
    sxx += c.x[k] * c.x[k];
    sxy += c.x[k] * c.y[k];
  }
  const double slope = (n * sxy - sx * sy) / std::max(n * sxx - sx * sx, numerics::kTiny);
  const double level = (sy - slope * sx) / n;
  double most = 0.0;
  for (size_t k = 0; k < c.x.size(); ++k)
    most = std::max(most, std::abs(c.y[k] - level - slope * c.x[k]));
  return most / std::max(c.range(), numerics::kTiny);
}

// Number of turns between rising and falling by more than a share of the range.
int turn_count(const Curve& c) {
  int count = 0;
  double extreme = c.y.front();
  int direction = 0;
  for (const double y : c.y) {
    const double step = y - extreme;
    if (direction >= 0 && step > 0.0) extreme = y;
    if (direction <= 0 && step < 0.0) extreme = y;
    if (direction == 0 && std::abs(y - c.y.front()) > kShapeFlat * c.range()) {
      direction = y > c.y.front() ? 1 : -1;
      extreme = y;
    } else if (direction != 0 && direction * (y - extreme) < -kShapeFlat * c.range()) {
      direction = -direction;
      extreme = y;
      ++count;
    }
  }
  return count;
}

// Number of points, from one end, over which the curve stays within a share of its range.
size_t flat_point_count(const Curve& c, bool from_left) {
  const size_t n = c.y.size();
  const double start = from_left ? c.y.front() : c.y.back();
  double low = start;
  double high = start;
  for (size_t k = 0; k < n; ++k) {
    const double y = c.y[from_left ? k : n - 1 - k];
    low = std::min(low, y);
    high = std::max(high, y);
    if (high - low > kShapeFlat * c.range()) return k;
  }
  return n;
}

// Shares of a curve's mean square about its mean that are odd and even about zero.
std::pair<double, double> odd_and_even(const Curve& c) {
  double odd = 0.0;
  double even = 0.0;
  double mean = 0.0;
  for (const double y : c.y) mean += y / static_cast<double>(c.y.size());
  for (size_t k = 0; k < c.x.size(); ++k) {
    const double to = -c.x[k];
    if (to < c.x.front() || to > c.x.back()) continue;
    const auto above = std::upper_bound(c.x.begin(), c.x.end(), to) - c.x.begin();
    const auto hi = std::clamp<size_t>(static_cast<size_t>(above), 1, c.x.size() - 1);
    const double w = (to - c.x[hi - 1]) / std::max(c.x[hi] - c.x[hi - 1], numerics::kTiny);
    const double mirrored = c.y[hi - 1] + w * (c.y[hi] - c.y[hi - 1]);
    odd += std::pow(0.5 * (c.y[k] - mirrored), 2);
    even += std::pow(0.5 * (c.y[k] + mirrored) - mean, 2);
  }
  return {odd, even};
}

std::string position_text(double x, const std::string& unit) {
  return fmt::format("{:.3g} {}", x, unit);
}

// Describes a function of one signal.
std::string words_of_curve(const Curve& c, const MotionSignal& s, const std::string& effort) {
  const std::string size = fmt::format(", {:.3g} {} from its lowest to its highest value", c.range(), effort);
  if (c.range() <= 0.0) return "none";
  const double travel = c.x.back() - c.x.front();
  const bool about_zero = c.x.front() < -kShapeFlat * travel && c.x.back() > kShapeFlat * travel;
  const auto [odd, even] = odd_and_even(c);
  const std::string sides = !about_zero || s.kind == SignalKind::kPosition ? ""
                            : odd > kShapeMost * (odd + even)               ? "odd, "
                            : even > kShapeMost * (odd + even)              ? "even, "
                                                                            : "";
  if (s.kind == SignalKind::kHistory) return sides + "with a memory: it changes with the way since a reversal" + size;
  if (deviation_from_line(c) < 0.5 * kShapeFlat) return sides + "a straight line" + size;
  if (turn_count(c) >= 3) return "periodic: it turns " + std::to_string(turn_count(c)) + " times" + size;
  const size_t n = c.y.size();
  const size_t left = flat_point_count(c, true);
  const size_t right = flat_point_count(c, false);
  if (2 * left >= n && turn_count(c) == 0)
    return "one-sided: nothing below " + position_text(c.x[std::min(left, n - 1)], s.unit) + size;
  if (2 * right >= n && turn_count(c) == 0)
    return "one-sided: nothing above " + position_text(c.x[n - 1 - std::min(right, n - 1)], s.unit) + size;
  // A straight line stays within the share of_line of its range over the same share of its length.
  const double of_line = kShapeFlat * static_cast<double>(n);
  if (turn_count(c) == 0 && static_cast<double>(std::min(left, right)) > of_line)
    return sides + "saturating: flat towards both ends" + size;
  if (turn_count(c) == 0) {
    const double first = std::abs(c.y[n / 4] - c.y.front());
    const double last = std::abs(c.y.back() - c.y[n - 1 - n / 4]);
    const double middle = std::abs(c.y[n - 1 - n / 4] - c.y[n / 4]);
    if (2.0 * middle < first + last && std::min(first, last) > kShapeFlat * c.range())
      return sides + "a dead zone: flat in the middle" + size;
    return sides + (c.y.back() > c.y.front() ? "rising" : "falling") + size;
  }
  return sides + (turn_count(c) == 1 ? "one hump" : "two humps") + size;
}

}  // namespace

std::string shape_words(const UnnamedShape& shape, const std::vector<MotionSignal>& of) {
  if (shape.curve.empty()) return {};
  if (of.size() == 1) return words_of_curve(curve_of(shape, 0, shape.curve.size()), of[0], shape.effort);
  if (shape.on_sides) {
    const size_t half = shape.curve.size() / 2;
    const Curve back = curve_of(shape, 0, half);
    const Curve forth = curve_of(shape, half, half);
    double opposite = 0.0;
    double alike = 0.0;
    for (size_t k = 0; k < half; ++k) {
      opposite += std::pow(0.5 * (forth.y[k] - back.y[k]), 2);
      alike += std::pow(0.5 * (forth.y[k] + back.y[k]), 2);
    }
    const std::string which = opposite > kShapeMost * (opposite + alike)
                                  ? "with the sign of the direction: "
                              : alike > kShapeMost * (opposite + alike) ? "the same in both directions: "
                                                                        : "another one in each direction: ";
    return which + words_of_curve(forth.range() > back.range() ? forth : back, of[0], shape.effort);
  }
  double low = shape.curve.front().value;
  double high = low;
  for (const CurvePoint& p : shape.curve) {
    low = std::min(low, p.value);
    high = std::max(high, p.value);
  }
  return fmt::format("a function of both, {:.3g} {} from its lowest to its highest value",
                     high - low, shape.effort);
}

}  // namespace veridyn
