#include "diagnosis/search/tables.hpp"

#include <algorithm>

#include "diagnosis/numerics.hpp"
#include "effects/tabulated_force.hpp"

namespace veridyn {
namespace {

TableSignal table_signal_of(const MotionSignal& s, JointIndex joint) {
  const bool own = s.joint == joint.value;
  switch (s.kind) {
    case SignalKind::kPosition: return own ? TableSignal::kPosition : TableSignal::kFromPosition;
    case SignalKind::kVelocity: return own ? TableSignal::kVelocity : TableSignal::kFromVelocity;
    case SignalKind::kTorque: return own ? TableSignal::kLoad : TableSignal::kNone;
    case SignalKind::kHistory:
    case SignalKind::kTime: break;
  }
  return TableSignal::kNone;
}

double table_code(TableSignal signal) {
  return static_cast<double>(signal);
}

// Value at x of the b-th of several curves over the first signal, by linear interpolation.
double value_at(const UnnamedShape& shape, size_t first, size_t count, double x) {
  const auto at = [&](size_t k) { return shape.curve[first + k].at.front(); };
  size_t k = 1;
  while (k + 1 < count && at(k) < x) ++k;
  const double w = std::clamp((x - at(k - 1)) / std::max(at(k) - at(k - 1), numerics::kTiny), 0.0, 1.0);
  return (1.0 - w) * shape.curve[first + k - 1].value + w * shape.curve[first + k].value;
}

}  // namespace

std::vector<EffectTerm> tables_of(const Model& arm, JointIndex joint, const UnnamedShape& shape,
                                  const std::vector<MotionSignal>& of) {
  std::vector<TableSignal> signals;
  for (const MotionSignal& s : of) signals.push_back(table_signal_of(s, joint));
  if (signals.empty() || signals.front() == TableSignal::kNone) return {};
  if (signals.size() > 1 && signals[1] == TableSignal::kNone) return {};
  const auto add = [&](size_t first, size_t count, std::vector<EffectTerm>& out) {
    EffectTerm term;
    term.effect = kTabulatedForce;
    term.axis = Axis{VectorXd::Unit(arm.joints(), joint.value), 0.0};
    for (const MotionSignal& s : of) {
      if (s.joint && s.joint != joint.value && !term.from)
        term.from = Axis{VectorXd::Unit(arm.joints(), *s.joint), 0.0};
    }
    term.values = {{"signal", table_code(signals.front())}, {"low", of.front().low}, {"high", of.front().high}};
    const double middle =
        value_at(shape, first, count, table_node(of.front().low, of.front().high, kTableNodes / 2));
    for (int k = 0; k < kTableNodes; ++k) {
      if (k == kTableNodes / 2) continue;
      const double x = table_node(of.front().low, of.front().high, k);
      term.values["value_" + std::to_string(k + 1)] = value_at(shape, first, count, x) - middle;
    }
    out.push_back(std::move(term));
  };
  std::vector<EffectTerm> out;
  if (of.size() == 1) {
    add(0, shape.curve.size(), out);
    return out;
  }
  // A table has one `from` axis: signals of two different other joints cannot be stored.
  if (of[0].joint != joint.value && of[1].joint != joint.value && of[0].joint != of[1].joint) return {};
  size_t row = 1;
  while (row < shape.curve.size() && shape.curve[row].at[1] == shape.curve.front().at[1]) ++row;
  const size_t rows = shape.curve.size() / row;
  const size_t windows = shape.on_sides ? 2 : static_cast<size_t>(numerics::kWindows);
  for (size_t w = 0; w < windows; ++w) {
    const size_t at = w * (rows - 1) / (windows - 1);
    add(at * row, row, out);
    std::map<std::string, double>& values = out.back().values;
    if (shape.on_sides) {
      values["second"] = table_code(TableSignal::kDirection);
      values["at"] = w == 0 ? -1.0 : 1.0;
    } else {
      values["second"] = table_code(signals[1]);
      values["at"] = shape.curve[at * row].at[1];
      values["width"] = (shape.curve.back().at[1] - shape.curve.front().at[1]) / static_cast<double>(windows - 1);
    }
  }
  if (!shape.on_sides) {  // the table of every window, minus its mean over the first signal: a function of the second
    UnnamedShape across;
    for (size_t r = 0; r < rows; ++r) {
      CurvePoint p = shape.curve[r * row + row / 2];
      p.at = {p.at[1]};
      across.curve.push_back(std::move(p));
    }
    const std::vector<EffectTerm> alone = tables_of(arm, joint, across, {of[1]});
    out.insert(out.end(), alone.begin(), alone.end());
  }
  return out;
}

}  // namespace veridyn
