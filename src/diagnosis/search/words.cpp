#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/search/row_constants.hpp"
#include "diagnosis/search/channel_words.hpp"
#include "diagnosis/numerics.hpp"
#include "diagnosis/search/explain.hpp"
#include "diagnosis/search/numbers.hpp"
#include "diagnosis/search/shape_words.hpp"
#include "math/student_t.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/effects/effect_facts.hpp"

// Words and numbers for the terms of the final set.

namespace veridyn::search {
namespace {

using numerics::kPercent;

FoundParameter parameter(std::string name, std::string unit, double value, double half) {
  return {std::move(name), std::move(unit), value, value - half, value + half};
}

// Standard deviation of a quotient a/b with this covariance.
double quotient_deviation(double a, double b, double aa, double bb, double ab) {
  return std::sqrt(std::max(0.0, aa / (b * b) - 2.0 * a * ab / (b * b * b) + a * a * bb / (b * b * b * b)));
}

// The describe functions write values, intervals and phrase of a term into its finding.
// @param t  half width of an interval in standard deviations. @param before  the arm without the terms.
void describe_load(const Chosen& c, double t, Finding& f) {
  const VectorXd& z = c.values;
  const MatrixXd& C = c.covariance;
  const FoundParameter mass = parameter("mass", "kg", z[0], t * c.deviations[0]);
  const bool is_heavy = mass.low > 0.0 || mass.high < 0.0;
  if (is_heavy) f.parameters.push_back(mass);
  // A load's first moments that the torques determine; the sign of their effect shows whether the load was
  // added or removed.
  double half = 0.0, moment = 0.0;
  for (int k = 0; k < 3; ++k) {
    if (c.deviations[1 + k] < kDeterminedShare * kMassOfArm * kReach) {
      half = std::hypot(half, t * c.deviations[1 + k]);
      moment = std::hypot(moment, z[1 + k]);
    }
    if (is_heavy)
      f.parameters.push_back(parameter(std::string(1, "xyz"[k]), "m", z[1 + k] / z[0], t * quotient_deviation(z[1 + k], z[0], C(1 + k, 1 + k), C(0, 0), C(0, 1 + k))));
  }
  double known = 0.0;  // the moment of inertia that is known best, in its deviations
  const Eigen::Matrix<double, 10, 10> parameters = load_parameters(c.term.centre);
  for (const int k : {4, 6, 9}) {
    const double ratio = parameters.row(k).dot(z) / std::sqrt(std::max(numerics::kTiny, parameters.row(k).dot(C * parameters.row(k).transpose())));
    if (std::abs(ratio) > std::abs(known)) known = ratio;
  }
  const bool taken_off = !is_heavy && known < -t;
  f.parameters.push_back({"moment", "kg m", moment, std::max(0.0, moment - half), moment + half});
  const auto range = [&](double low, double high) { return fmt::format("(95 %: {:.3g} to {:.3g})", low, high); };
  if (mass.low > 0.0) {
    f.phrase = fmt::format("a load of {:.3g} kg {}", mass.value, range(mass.low, mass.high));
  } else if (mass.high < 0.0) {
    f.phrase = fmt::format("a load of {:.3g} kg {} was taken off", -mass.value, range(-mass.high, -mass.low));
  } else {
    f.phrase = fmt::format("a load with a moment of {:.3g} kg m {}, whose mass these torques do not tell,{}", moment,
                           range(std::max(0.0, moment - half), moment + half), taken_off ? " was taken off" : "");
  }
}

void describe_effect(const Chosen& c, double t, const Model& before, Finding& f) {
  const Effect& effect = find_effect(c.term.effect.effect);
  const bool slides = is_prismatic(before, c.term.effect.axis);
  const EffectFacts facts(before, c.term.effect);
  std::vector<double> values;
  for (int p = 0; p < facts.parameter_count(); ++p) {
    values.push_back(c.values[p]);
    f.parameters.push_back(parameter(facts.parameters()[p].name, facts.unit(p), c.values[p], t * c.deviations[p]));
  }
  if (c.term.kind == TermKind::kChange) {
    std::string words = effect.name();
    std::replace(words.begin(), words.end(), '_', ' ');
    f.phrase = words + " changed";
    for (size_t p = 0; p < values.size(); ++p) {
      const auto own = c.term.effect.values.find(f.parameters[p].name);
      const double from = own == c.term.effect.values.end() ? 0.0 : own->second;
      f.phrase += fmt::format("{} from {:.3g} to {:.3g} {}", p == 0 ? "" : ",", from, from + values[p], f.parameters[p].unit);
    }
    return;
  }
  size_t at = 0;
  for (const TermShape& shape : c.term.shapes) {
    const double value = c.term.effect.values.at(shape.name);
    const double deviation = at < c.shape_deviations.size() ? c.shape_deviations[at] : 0.0;
    ++at;
    const auto shapes = effect.shapes();
    const auto own = std::find_if(shapes.begin(), shapes.end(), [&](const EffectShape& s) { return s.name == shape.name; });
    FoundParameter p = parameter(shape.name, slides ? own->unit_prismatic : own->unit_revolute, value, std::isfinite(deviation) ? t * deviation : 0.0);
    if (!std::isfinite(deviation)) {  // the score has no curvature within the range of the search
      p.low = shape.lower;
      p.high = shape.upper;
    } else if (shape.logarithmic && deviation < value) {
      p.low = value * std::exp(-t * deviation / value);
      p.high = value * std::exp(t * deviation / value);
    }
    f.parameters.push_back(p);
  }
  f.phrase = facts.phrase(values);
  if (!c.term.with_rest || c.term.effect.from) return;
  const int p = facts.parameter_count();
  const double rest = -c.values[p] / c.values[0];
  f.parameters.push_back(parameter("rest", slides ? "m" : "rad", rest, t * quotient_deviation(c.values[p], c.values[0], c.covariance(p, p), c.covariance(0, 0), c.covariance(0, p))));
  f.phrase += fmt::format(", without load at {:.3g} {}", rest, slides ? "m" : "rad");
}

void describe_channel(const Chosen& c, double t, const Model& before, Finding& f) {
  const ChannelEffect& channel = *channel_effect(c.term.effect.effect);
  std::vector<double> values(c.values.data(), c.values.data() + c.values.size());
  if (c.gravity) {
    const auto& arm_effect = dynamic_cast<const ArmEffect&>(static_cast<const Effect&>(channel));
    ModelDescription with = before.description();
    with.gravity = *c.gravity;
    values = arm_effect.values_between(before.description(), with, std::vector<double>(values.size(), 0.0));
  }
  const bool slides = !c.term.effect.axis.coefficients.isZero(0.0) && is_prismatic(before, c.term.effect.axis);
  const std::vector<EffectParameter> parameters = channel.parameters();
  // A vertical gravity that is turned by half a turn has no defined roll and pitch.
  const bool turned = c.gravity && std::all_of(values.begin(), values.end(), [](double v) { return v == 0.0; }) &&
                      (*c.gravity - before.gravity()).norm() > 0.5 * before.gravity().norm();
  const bool is_none = c.gravity && c.gravity->norm() < 0.5 * before.gravity().norm();
  for (size_t p = 0; p < values.size() && !is_none && !turned; ++p) {
    f.parameters.push_back(parameter(parameters[p].name, slides ? parameters[p].unit_prismatic : parameters[p].unit_revolute, values[p],
                                     t * c.deviations[static_cast<Eigen::Index>(p)]));
  }
  if (c.gravity) {
    const double turn = c.deviations.size() > 0 ? c.deviations.maxCoeff() : 0.0;
    const double half = is_none ? 0.0 : std::min(t * turn, 1.0) * c.gravity->norm();
    for (int k = 0; k < 3; ++k) f.parameters.push_back(parameter(std::string("gravity_") + "xyz"[k], "m/s^2", (*c.gravity)[k], half));
  }
  if (is_none) f.phrase = "torques without gravity, as the command of a controller that compensates it";
  else if (turned) f.phrase = fmt::format("gravity along ({:.3g}, {:.3g}, {:.3g}) m/s^2, which its file has elsewhere", (*c.gravity)[0] + 0.0, (*c.gravity)[1] + 0.0, (*c.gravity)[2] + 0.0);
  else f.phrase = channel_phrase(before, c.term.effect, values);
  const bool large = !is_none && !turned && std::any_of(values.begin(), values.end(), [&, p = 0](double v) mutable { return std::abs(v) > c.term.largest[p++]; });
  if (large) f.remark = "That is unusually large for an error of this kind.";
}

void describe_constant(const Chosen& c, double t, const Model& before, Finding& f) {
  const FrameConstant& constant = *c.term.constant;
  const double stated = value_in(before, constant);
  const std::string unit = unit_of(constant);
  const double value = stated + c.values[0];
  f.parameters.push_back(parameter("value", unit, value, t * c.deviations[0]));
  f.parameters.push_back(parameter("correction", unit, c.values[0], t * c.deviations[0]));
  const auto shown = [&](double v) { return unit == "rad" ? fmt::format("{:.4g} deg", numerics::kDegrees * v) : fmt::format("{:.5g} {}", v, unit); };
  f.phrase = fmt::format("{} is {} there; the recordings ask for {}", words_for(before, constant), shown(stated), shown(value));
}

MotionSignal motion_signal(const Signal& s) {
  static const veridyn::SignalKind kKinds[] = {veridyn::SignalKind::kPosition, veridyn::SignalKind::kVelocity, veridyn::SignalKind::kTorque,
                                               veridyn::SignalKind::kHistory, veridyn::SignalKind::kTime};
  MotionSignal out;
  out.kind = kKinds[static_cast<int>(s.kind)];
  if (s.kind != SignalKind::kTime) out.joint = s.joint;
  out.name = s.name;
  out.unit = s.unit;
  out.low = s.low;
  out.high = s.high;
  return out;
}

// Values of a curve at points of its signals, relative to its mean over the rows, with a band.
void describe_curve(const Chosen& c, double t, const Model& before, Finding& f) {
  UnnamedShape shape;
  shape.effort = effort_unit(before.coordinates()[c.term.joint->value]);
  std::vector<std::vector<double>> grid;
  std::vector<MotionSignal> of;
  for (size_t k = 0; k < c.term.signals.size(); ++k) {
    const Signal& s = c.term.signals[k];
    const bool sides = c.term.bases[k].kind() == BasisKind::kSides;
    const bool surface = c.term.signals.size() > 1 && c.term.bases[1].kind() == BasisKind::kSmooth;
    const int points = sides ? 2 : surface ? numerics::kCurvePointsOfTwo : numerics::kCurvePoints;
    grid.emplace_back();
    for (int i = 0; i < points; ++i) grid.back().push_back(s.low + (s.high - s.low) * i / (points - 1));
    shape.signals.push_back(s.name);
    shape.units.push_back(s.unit);
    shape.on_sides = shape.on_sides || sides;
    of.push_back(motion_signal(s));
  }
  const auto first = static_cast<Eigen::Index>(grid[0].size());
  const auto second = static_cast<Eigen::Index>(grid.size() > 1 ? grid[1].size() : 1);
  MatrixXd at(first * second, static_cast<Eigen::Index>(grid.size()));
  for (Eigen::Index r = 0; r < at.rows(); ++r) {
    at(r, 0) = grid[0][r % first];
    if (grid.size() > 1) at(r, 1) = grid[1][r / first];
  }
  const MatrixXd columns = curve_columns(c.term, at).rowwise() - Eigen::RowVectorXd(c.columns.of[0].colwise().mean());
  const VectorXd value = columns * c.values;
  const VectorXd variance = (columns * c.covariance).cwiseProduct(columns).rowwise().sum();
  for (Eigen::Index r = 0; r < at.rows(); ++r) {
    const double half = t * std::sqrt(std::max(0.0, variance[r]));
    CurvePoint p{{}, value[r], value[r] - half, value[r] + half};
    for (Eigen::Index k = 0; k < at.cols(); ++k) p.at.push_back(at(r, k));
    shape.curve.push_back(std::move(p));
  }
  shape.words = shape_words(shape, of);
  f.unit = shape.effort;
  std::string signals;
  for (const std::string& name : shape.signals) signals += (signals.empty() ? "" : " and ") + name;
  const int j = c.term.joint->value;
  const double share = 1.0 - std::pow(c.folds_after[j] / std::max(c.folds_before[j], numerics::kTiny), 2);
  shape.share = std::max(0.0, share);
  f.phrase = fmt::format("{:.0f} % of what the model leaves over can be predicted from {}: {}; nothing on the list has that shape", kPercent * shape.share, signals, shape.words);
  f.shape = std::move(shape);
}

}  // namespace

Finding finding_of(const Chosen& c, const SearchResult& found, const Model& before) {
  Finding f;
  f.cause = c.term.cause;
  f.joint = c.term.kind == TermKind::kCurve ? c.term.joint : acting_joint(before, c.term.cause);
  f.from = c.term.candidate.from;
  f.gain = c.gain;
  f.p_value = std::max(numerics::kTiny, 0.5 * std::erfc(c.gain / std::max(c.error, numerics::kNoise) / std::sqrt(2.0)));
  f.folds_before = c.folds_before;
  f.folds_after = c.folds_after;
  const double t = student_t_quantile(numerics::kOutside, static_cast<double>(found.degrees_of_freedom));
  switch (c.term.kind) {
    case TermKind::kLoad: describe_load(c, t, f); break;
    case TermKind::kChannel: describe_channel(c, t, before, f); break;
    case TermKind::kConstant: describe_constant(c, t, before, f); break;
    case TermKind::kCurve: describe_curve(c, t, before, f); break;
    default: describe_effect(c, t, before, f);
  }
  if (f.unit.empty() && !f.parameters.empty()) f.unit = f.parameters.front().unit;
  for (const Chosen::RivalTerm& r : c.rivals) {
    if (std::any_of(f.rivals.begin(), f.rivals.end(), [&](const Rival& other) { return same_cause(other.cause, r.term.cause); })) continue;
    const double share = std::clamp(r.gain / std::max(c.gain, numerics::kNoise), 0.0, 1.0);
    f.rivals.push_back({r.term.cause, fmt::format("gains {:.0f} % as much on held-out data in its place", kPercent * share), share});
  }
  const bool constant = (c.term.kind == TermKind::kChannel) && find_effect(c.term.effect.effect).traits().same_as_wrong_constant;
  if (constant && joint_of(c.term.cause))
    f.rivals.push_back({KinematicError{JointZero{*joint_of(c.term.cause)}}, "a wrong zero of this joint in the robot file does exactly the same"});
  return f;
}

}  // namespace veridyn::search
