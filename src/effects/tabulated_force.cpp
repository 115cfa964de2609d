#include <algorithm>
#include <cmath>
#include <string>

#include "effects/tabulated_force.hpp"
#include "effects/written_in_c.hpp"
#include "phrase.hpp"
#include "registry.hpp"
#include "sliding_direction.hpp"

namespace veridyn {
namespace {

constexpr int kNodes = kTableNodes;
// Index of the node where the table is zero, since a constant is torque_offset.
constexpr int kMiddle = kNodes / 2;

using Signal = TableSignal;

enum Shape { kSignal, kLow, kHigh, kSecond, kAt, kWidth };

// The signal of a number in a robot file, rounded and limited to 0 .. 6.
Signal signal_of(double code) {
  return static_cast<Signal>(std::clamp(static_cast<int>(std::lround(code)), 0, 6));
}

double value_of(Signal signal, const AxisSample& x) noexcept {
  switch (signal) {
    case Signal::kPosition: return x.s;
    case Signal::kVelocity: return x.ds;
    case Signal::kLoad: return x.load;
    case Signal::kDirection: return sliding_direction(x.ds);
    case Signal::kFromPosition: return x.from_s;
    case Signal::kFromVelocity: return x.from_ds;
    case Signal::kNone: break;
  }
  return 0.0;
}

const char* words_of(Signal signal) {
  switch (signal) {
    case Signal::kPosition: return "position";
    case Signal::kVelocity: return "velocity";
    case Signal::kLoad: return "the torque that the bodies ask for";
    case Signal::kDirection: return "direction";
    case Signal::kFromPosition: return "another joint's position";
    case Signal::kFromVelocity: return "another joint's velocity";
    case Signal::kNone: break;
  }
  return "nothing";
}

// The signal as a C expression, see WrittenInC.
std::string c_signal(Signal signal) {
  switch (signal) {
    case Signal::kPosition: return "s";
    case Signal::kVelocity: return "ds";
    case Signal::kLoad: return "load";
    case Signal::kDirection: return "@direction(ds)";
    case Signal::kFromPosition: return "from_s";
    case Signal::kFromVelocity: return "from_ds";
    case Signal::kNone: break;
  }
  return "0.0";
}

// Weight of a row: 1 without a second signal; 0 or 1 for a direction; else a triangle.
double window(const AxisSample& x, const ShapeValues& shape) noexcept {
  const Signal second = signal_of(shape[kSecond]);
  if (second == Signal::kNone) return 1.0;
  if (second == Signal::kDirection) return 0.5 * (1.0 + shape[kAt] * sliding_direction(x.ds));
  return std::max(0.0, 1.0 - std::abs(value_of(second, x) - shape[kAt]) / shape[kWidth]);
}

/// A measured force without a known cause: a table over one signal, optionally restricted to a
/// window of a second signal,
///
///   tau = w(second) sum_k value_k h(12 (x - low) / (high - low) - k + 1),   k = 1 ... 13 but 7
///
/// with triangles h, that is linear interpolation between the values, which are zero in the middle
/// (node 7), and constant outside of low ... high. `signal` and `second` select x and the signal of
/// the window: 1 position, 2 velocity, 3 load, 4 direction, 5 and 6 position and velocity of
/// `from`; second = 0 means no window. The window of a direction is (1 + at sign(ds)) / 2 with at =
/// -1 or 1; other windows are triangles about `at` of half width `width`.
class TabulatedForce final : public AxisEffect, public WrittenInC {
 public:
  std::string name() const override { return kTabulatedForce; }
  std::vector<EffectParameter> parameters() const override {
    std::vector<EffectParameter> out;
    for (int k = 0; k < kNodes; ++k) {
      if (k != kMiddle) out.push_back({"value_" + std::to_string(k + 1), "N m", "N", ParameterSign::kAny});
    }
    return out;
  }
  std::vector<EffectShape> shapes() const override {
    const auto constant = [](const char* name, double initial) {
      return EffectShape{name, "1", "1", initial, -1e6, 1e6, false, false};
    };
    return {constant("signal", 1.0), constant("low", -1.0), constant("high", 1.0),
            constant("second", 0.0),     constant("at", 0.0),   constant("width", 1.0)};
  }
  /// A table has no initial values; they come from a residual.
  std::vector<ShapeChoice> grid(const AxisMotion& /*motion*/) const override { return {}; }
  EffectTraits traits(const ShapeValues& shape) const override {
    EffectTraits t;
    const auto uses = [&shape](Signal signal) {
      return signal_of(shape[kSignal]) == signal || signal_of(shape[kSecond]) == signal;
    };
    t.uses_position = uses(Signal::kPosition);
    t.uses_velocity = uses(Signal::kVelocity) || uses(Signal::kDirection);
    t.uses_load = uses(Signal::kLoad);
    t.uses_source = uses(Signal::kFromPosition) || uses(Signal::kFromVelocity);
    t.depends_on_position = t.uses_position || uses(Signal::kFromPosition);
    t.holds_at_rest = t.depends_on_position || t.uses_load;
    t.mixed_axes = true;
    t.tabulated = true;
    return t;
  }
  std::vector<ActiveRange> active_ranges(const ShapeValues& shape) const override {
    std::vector<ActiveRange> out;
    const auto add = [&out](Signal signal, double low, double high) {
      const bool source = signal == Signal::kFromPosition || signal == Signal::kFromVelocity;
      const bool position = signal == Signal::kPosition || signal == Signal::kFromPosition;
      const bool velocity = signal == Signal::kVelocity || signal == Signal::kFromVelocity;
      if (position || velocity) out.push_back({source, velocity, low, high});
    };
    add(signal_of(shape[kSignal]), shape[kLow], shape[kHigh]);
    add(signal_of(shape[kSecond]), shape[kAt] - shape[kWidth], shape[kAt] + shape[kWidth]);
    return out;
  }
  void columns(const AxisSample& x, const ShapeValues& shape, EffectState& /*state*/,
               EffectColumns& row) const noexcept override {
    const double span = shape[kHigh] - shape[kLow];
    const double share = (value_of(signal_of(shape[kSignal]), x) - shape[kLow]) / span;
    const double u = std::clamp(share, 0.0, 1.0) * (kNodes - 1);
    const double w = window(x, shape);
    for (int k = 0; k < kNodes; ++k) {
      if (k != kMiddle)
        row[k - (k > kMiddle ? 1 : 0)] = w * std::max(0.0, 1.0 - std::abs(u - k));
    }
  }
  std::vector<std::string> c_columns(const ShapeValues& shape) const override {
    const double half = 0.5 * (shape[kHigh] - shape[kLow]);
    const std::string u = "(1.0 + @clamp((" + c_signal(signal_of(shape[kSignal])) + " - " +
                          c_number(shape[kLow] + half) + ") / " + c_number(half) + ")) * " +
                          c_number(kMiddle);
    const Signal second = signal_of(shape[kSecond]);
    std::string w;
    if (second == Signal::kDirection) w = "0.5 * (1.0 + " + c_number(shape[kAt]) + " * @direction(ds)) * ";
    else if (second != Signal::kNone)
      w = "fmax(0.0, 1.0 - fabs(" + c_signal(second) + " - " + c_number(shape[kAt]) + ") / " +
          c_number(shape[kWidth]) + ") * ";
    std::vector<std::string> out;
    for (int k = 0; k < kNodes; ++k) {
      if (k != kMiddle) out.push_back(w + "fmax(0.0, 1.0 - fabs(" + u + " - " + c_number(k) + "))");
    }
    return out;
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& shape,
                     JointType type) const override {
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    std::string out = "a " + effort_word(type) + " without a name that depends on " +
                      words_of(signal_of(shape[kSignal]));
    const Signal second = signal_of(shape[kSecond]);
    if (second != Signal::kNone) out += std::string(" and on ") + words_of(second);
    return out + ", between " + effort_text(std::min(*low, 0.0), type) + " and " +
           effort_text(std::max(*high, 0.0), type);
  }
};

}  // namespace

const Effect& tabulated_force() {
  static const TabulatedForce kEffect;
  return kEffect;
}

}  // namespace veridyn
