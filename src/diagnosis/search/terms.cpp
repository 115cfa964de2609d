#include "diagnosis/search/terms.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "diagnosis/search/row_constants.hpp"
#include "diagnosis/numerics.hpp"
#include "diagnosis/search/numbers.hpp"
#include "math/median.hpp"
#include "math/parallel.hpp"
#include "math/spectral_lines.hpp"
#include "regressor/effect_along.hpp"
#include "veridyn/effects/channel_effect.hpp"

namespace veridyn::search {
namespace {

struct Range {
  double low = numerics::kHuge, high = -numerics::kHuge, speed = 0.0;
  double travel() const { return high - low; }
};

std::vector<Range> ranges_of(const Rows& rows) {
  std::vector<Range> out(rows.joints());
  for (const Stretch& s : rows.stretches()) {
    for (const Eigen::Index k : s.kept) {
      for (int i = 0; i < rows.joints(); ++i) {
        out[i].low = std::min(out[i].low, s.segment.q(k, i));
        out[i].high = std::max(out[i].high, s.segment.q(k, i));
        out[i].speed = std::max(out[i].speed, std::abs(s.segment.dq(k, i)));
      }
    }
  }
  return out;
}

// Price [nats] of an effect above that of a frequent one.
double price_of_effect(const Effect& effect) {
  const EffectTraits traits = effect.traits();
  if (effect.imitates_others()) return kImitator;
  const std::vector<EffectShape> shapes = effect.shapes();
  const bool waves = std::any_of(shapes.begin(), shapes.end(), [](const EffectShape& s) { return s.scale == ShapeScale::kWaves; });
  const bool seldom = traits.depends_on_time || traits.uses_source || waves || traits.role == EffectRole::kArm || !traits.forward_simulable || effect.parameters().size() > 2;
  return seldom ? kPriceOfSeldom : 0.0;
}

// Builds the dictionary for the rows of an arm.
class Builder {
 public:
  Builder(const Rows& rows, const TermScope& scope) : rows_(rows), scope_(scope), arm_(rows.arm()), range_(ranges_of(rows)) {
    for (const Stretch& s : rows.stretches())
      duration_ = std::max(duration_, s.segment.time[s.kept.back()] - s.segment.start);
  }

  std::vector<Term> all() {
    Scope scope{{}, scope_.changes, {}};
    for (const std::string& one : scope_.wanted) scope.wanted.push_back(split_cause(one).effect);
    for (int i = 0; i < arm_.joints(); ++i) scope.still.push_back(!moves(i) || scope_.silent.count(i) != 0);
    for (const Candidate& c : candidates(arm_, scope)) {
      if (scope_.is_wanted(arm_, c.cause) && (!scope_.poses || acts_at_rest(c))) add(c);
    }
    if (scope_.constants) add_constants();
    add_curves();
    // The prior probabilities of all places sum to one.
    std::map<std::string, double> least;
    for (const Term& t : out_) {
      const auto [at, is_new] = least.emplace(t.place, t.price);
      at->second = std::min(at->second, t.price);
    }
    double sum = 0.0;
    for (const auto& [place, price] : least) sum += std::exp(-price);
    std::map<std::string, double> grid;
    for (const Term& t : out_) grid[t.place] += 1.0;
    for (Term& t : out_) {
      if (t.is_daily) {
        t.price = 0.0;
        continue;
      }
      t.price += std::log(sum) + std::log(grid[t.place]);
      for (const TermShape& s : t.shapes) t.price += s.fixed ? 0.0 : kPolished;
    }
    return std::move(out_);
  }

 private:
  static bool acts_at_rest(const Candidate& c) { return is_load(c) || veridyn::acts_at_rest(find_effect(effect_of(c.cause)).traits(), true); }

  bool moves(int joint) const {
    return range_[joint].travel() > (arm_.coordinates()[joint].prismatic ? kStillLength : kStill);
  }

  // Range and speed of the recorded motion along an axis: bounds, if several joints contribute.
  AxisMotion motion_along(const Axis& axis) const {
    AxisMotion m;
    m.type = is_prismatic(arm_, axis) ? JointType::kPrismatic : JointType::kRevolute;
    m.middle = axis.offset;
    m.duration = duration_;
    for (Eigen::Index i = 0; i < axis.coefficients.size(); ++i) {
      const double c = axis.coefficients[i];
      if (c == 0.0) continue;
      m.middle += 0.5 * c * (range_[i].low + range_[i].high);
      m.travel += std::abs(c) * range_[i].travel();
      m.speed += std::abs(c) * range_[i].speed;
    }
    m.waves.emplace();  // the spectrum of the residual suggests them, see ripples()
    return m;
  }

  void add(const Candidate& c) {
    Term t;
    t.candidate = c;
    t.cause = c.cause;
    t.joint = c.joint;
    t.place = to_text(arm_, c.cause) + (c.from ? " from " + std::to_string(c.from->value) : "") + axis_text(arm_, c.axis) +
              (is_changed_constant(c) ? " other" : "");
    if (is_load(c)) {
      t.kind = TermKind::kLoad;
      t.joint.reset();
      out_.push_back(std::move(t));
      return;
    }
    const Effect& effect = find_effect(effect_of(c.cause));
    t.effect.effect = effect.name();
    t.effect.axis = c.axis;
    if (c.from) t.effect.from = Axis{VectorXd::Unit(arm_.joints(), c.from->value), 0.0};
    t.price = price_of_effect(effect);
    t.imitates = effect.imitates_others();
    const std::vector<EffectParameter> parameters = effect.parameters();
    const bool slides = !c.axis.coefficients.isZero(0.0) && is_prismatic(arm_, c.axis);
    t.price += kPolished * std::max(0.0, static_cast<double>(parameters.size()) - 1.0);
    t.largest.resize(parameters.size());
    for (size_t p = 0; p < parameters.size(); ++p)
      t.largest[static_cast<Eigen::Index>(p)] = slides ? parameters[p].largest_prismatic : parameters[p].largest_revolute;
    if (is_channel(c)) {
      t.kind = TermKind::kChannel;
      const auto* channel = channel_effect(effect.name());
      if (channel->whole_arm() || !c.joint || acts_on_several(*channel, c)) t.joint.reset();
      out_.push_back(std::move(t));
      return;
    }
    if (is_changed_effect(c)) {
      t.kind = TermKind::kChange;
      t.is_daily = effect.traits().elementary;
      t.effect = arm_.effects()[c.own->value];
    }
    for (size_t p = 0; p < parameters.size(); ++p) {
      const auto own = t.effect.values.find(parameters[p].name);
      if (parameters[p].sign == ParameterSign::kNonnegative)
        t.nonnegative.push_back({static_cast<Eigen::Index>(p), own == t.effect.values.end() ? 0.0 : std::max(own->second, 0.0)});
    }
    if (is_changed_effect(c)) {
      out_.push_back(std::move(t));
      return;
    }
    // For a MODEL no other parameter represents a spring's rest position.
    const EffectTraits traits = effect.traits();
    t.with_rest = scope_.changes && traits.affine && traits.holds_at_rest && (traits.uses_position || traits.uses_source);
    const AxisMotion motion = motion_along(c.axis);
    if (is_changed_constant(c)) return;
    for (const ShapeChoice& choice : effect.grid(motion)) {
      Term one = t;
      one.effect.values = choice;
      for (const EffectParameter& p : parameters) one.effect.values.erase(p.name);
      one.shapes = searched_shapes(effect, motion, choice);
      out_.push_back(std::move(one));
    }
  }

  bool acts_on_several(const ChannelEffect& channel, const Candidate& c) const {
    int count = 0;
    for (int i = 0; i < arm_.joints(); ++i) count += channel.acts_on(i, c.joint) ? 1 : 0;
    return count > 1;
  }

  // The constants of the effect that the search adjusts, each with its bounds and a first step: half the distance
  // (for logarithmic constants the root of the ratio) from its value in `choice` to a neighbour in the grid.
  static std::vector<TermShape> searched_shapes(const Effect& effect, const AxisMotion& motion, const ShapeChoice& choice) {
    std::vector<TermShape> out;
    std::map<std::string, std::vector<double>> values;
    for (const ShapeChoice& other : effect.grid(motion)) {
      for (const auto& [name, value] : other) values[name].push_back(value);
    }
    for (const EffectShape& shape : effect.shapes()) {
      const auto value = choice.find(shape.name);
      if (value == choice.end() || !shape.searched) continue;
      std::vector<double>& all = values[shape.name];
      std::sort(all.begin(), all.end());
      all.erase(std::unique(all.begin(), all.end()), all.end());
      TermShape one{shape.name, shape.lower, shape.upper, shape.logarithmic, shape.logarithmic ? 2.0 : kQuarterOfRange * (shape.upper - shape.lower), false};
      const auto at = std::lower_bound(all.begin(), all.end(), value->second);
      const double next = at + 1 < all.end() ? *(at + 1) : at > all.begin() ? *(at - 1) : value->second;
      if (next != value->second && next != 0.0 && value->second != 0.0) {
        one.step = shape.logarithmic ? std::sqrt(std::max(next / value->second, value->second / next)) : 0.5 * std::abs(next - value->second);
      }
      out.push_back(one);
    }
    return out;
  }

  void add_constants() {
    if (!scope_.wanted.empty() && !scope_.is_wanted(arm_, KinematicError{JointZero{JointIndex{0}}})) return;
    for (const FrameConstant& c : row_constants(arm_)) {
      Term t;
      t.kind = TermKind::kConstant;
      t.cause = KinematicError{c};
      if (!scope_.is_wanted(arm_, t.cause)) continue;
      t.constant = c;
      t.place = to_text(arm_, t.cause);
      t.price = kConstantPrice;
      out_.push_back(std::move(t));
    }
  }

  Signal make_signal(SignalKind kind, int joint) const {
    static const char* const kNames[] = {"q", "dq", "tau", "history", "t"};
    const bool slides = arm_.coordinates()[joint].prismatic;
    const std::string length = slides ? "m" : "rad";
    Signal s{kind, joint, kNames[static_cast<int>(kind)], "", numerics::kHuge, -numerics::kHuge};
    s.unit = kind == SignalKind::kTime ? "s" : kind == SignalKind::kTorque ? (slides ? "N" : "N m") : kind == SignalKind::kVelocity ? length + "/s" : length;
    if (kind != SignalKind::kTime) s.name += std::to_string(joint + 1);
    for (const Stretch& stretch : rows_.stretches()) {
      const VectorXd x = signal_along(s, stretch, kRestShare * range_[joint].speed);
      for (const Eigen::Index k : stretch.kept) {
        s.low = std::min(s.low, x[k]);
        s.high = std::max(s.high, x[k]);
      }
    }
    return s;
  }

  SmoothBasis make_basis(const Signal& s, BasisKind kind, int intervals) const {
    const double size = std::max(std::abs(s.low), std::abs(s.high));
    return {kind, s.low, s.high, intervals, std::max(kRestShare * size, numerics::kNoise)};
  }

  void add_curve(int joint, std::vector<Signal> signals, std::vector<SmoothBasis> bases, double price) {
    Term t;
    t.kind = TermKind::kCurve;
    t.joint = JointIndex{joint};
    t.cause = NewEffect{"unnamed", JointIndex{joint}};
    t.place = "unnamed:" + std::to_string(joint);
    for (const Signal& s : signals) {
      if (!(s.high > s.low)) return;
      t.place += " " + s.name;
    }
    t.signals = std::move(signals);
    t.bases = std::move(bases);
    t.price = price;
    out_.push_back(std::move(t));
  }

  void add_curves() {
    const int n = arm_.joints();
    std::vector<int> moving;
    for (int i = 0; i < n; ++i) {
      if (moves(i) && scope_.silent.count(i) == 0) moving.push_back(i);
    }
    std::vector<Signal> q, torque;
    for (const int i : moving) {
      q.push_back(make_signal(SignalKind::kPosition, i));
      torque.push_back(make_signal(SignalKind::kTorque, i));
    }
    const Signal t = make_signal(SignalKind::kTime, 0);
    for (size_t a = 0; a < moving.size(); ++a) {
      const int j = moving[a];
      const Signal dq = make_signal(SignalKind::kVelocity, j), history = make_signal(SignalKind::kHistory, j);
      const auto smooth = [&](const Signal& s, int intervals) { return make_basis(s, BasisKind::kSmooth, intervals); };
      add_curve(j, {dq}, {make_basis(dq, BasisKind::kSided, kCurveIntervals)}, kCurveOfOne);
      add_curve(j, {history}, {make_basis(history, BasisKind::kSided, kCurveIntervals)}, kCurveOfOne);
      const SmoothBasis sides = make_basis(dq, BasisKind::kSides, 1);
      if (!scope_.poses) {
        add_curve(j, {t}, {smooth(t, kCurveIntervals)}, kCurveOfOne);
        add_curve(j, {t, dq}, {smooth(t, kSideIntervals), sides}, kCurveOfTwo);
      }
      add_curve(j, {torque[a], dq}, {smooth(torque[a], kSideIntervals), sides}, kCurveOfTwo);
      for (size_t b = 0; b < moving.size(); ++b) {
        add_curve(j, {q[b]}, {smooth(q[b], kCurveIntervals)}, kCurveOfOne);
        add_curve(j, {torque[b]}, {smooth(torque[b], kCurveIntervals)}, kCurveOfOne);
        add_curve(j, {q[b], dq}, {smooth(q[b], kSideIntervals), sides}, kCurveOfTwo);
        if (b == a) continue;
        add_curve(j, {q[a], q[b]}, {smooth(q[a], kProductIntervals), smooth(q[b], kProductIntervals)}, kCurveOfTwo);
      }
    }
  }

  const Rows& rows_;
  const TermScope& scope_;
  const Model& arm_;
  std::vector<Range> range_;
  double duration_ = 0.0;
  std::vector<Term> out_;
};

// The arm with an added body on the frame of a load; the body is the last one.
Model with_load(const Model& arm, FrameIndex frame) {
  ModelDescription d = arm.description();
  Frame load;
  load.name = std::string(AddedLoad::kName) + "@" + arm.frames()[frame.value].name;
  load.parent = frame;
  load.variable.coefficients = VectorXd::Zero(arm.joints());
  load.body = Body{};
  load.body->phi = InertialParameters::Zero();
  d.frames.push_back(std::move(load));
  return Model(std::move(d));
}

Columns load_columns(const Term& term, const Rows& rows) {
  const Model arm = with_load(rows.arm(), *frame_of(term.cause));
  const TorqueRegressor batch(arm);
  const int body = static_cast<int>(arm.bodies().size()) - 1;
  const Eigen::Matrix<double, 10, 10> tangent = load_parameters(term.centre);
  Columns out;
  for (int i = 0; i < arm.joints(); ++i) {
    if (!arm.moves(arm.bodies()[body], {i})) continue;
    out.joints.push_back(i);
    out.of.emplace_back(rows.rows(), kBodyParameters);
  }
  std::vector<MatrixXd> Y;
  for (const Stretch& s : rows.stretches()) {
    Y.assign(arm.joints(), {});
    batch.evaluate(s.segment.q, s.segment.body_velocities(), s.segment.ddq, Y);
    for (size_t at = 0; at < out.joints.size(); ++at) {
      const int i = out.joints[at];
      rows.put(s, Y[i].rightCols<10>() * tangent * rows.arm().coordinates()[i].recorded.torque_gain, out.of[at]);
    }
  }
  return out;
}

Columns effect_columns(const Term& term, const Rows& rows) {
  const EffectFacts effect(rows.arm(), term.effect);
  Columns out;
  const VectorXd& c = term.effect.axis.coefficients;
  MatrixXd all(rows.rows(), effect.parameter_count() + (term.with_rest ? 1 : 0));
  for (const Stretch& s : rows.stretches()) {
    const Segment& m = s.segment;
    MatrixXd own = columns_along(effect.bound(), MotionView(m.time, m.q, m.dq, m.ddq), s.load, m.start);
    if (term.with_rest) {
      own.conservativeResize(Eigen::NoChange, own.cols() + 1);
      own.rightCols(1).setOnes();
    }
    rows.put(s, std::move(own), all);
  }
  for (int i = 0; i < rows.joints(); ++i) {
    if (c[i] == 0.0) continue;
    out.joints.push_back(i);
    out.of.emplace_back(c[i] * rows.arm().coordinates()[i].recorded.torque_gain * all);
  }
  return out;
}

// Columns on all joints, from the unfiltered ones (samples x n) that `along` computes for each parameter and
// stretch.
template <typename Along>
Columns whole_columns(const Rows& rows, const std::vector<int>& joints, size_t parameters, const Along& along) {
  Columns out;
  out.joints = joints;
  for (size_t k = 0; k < joints.size(); ++k) out.of.emplace_back(rows.rows(), static_cast<Eigen::Index>(parameters));
  for (const Stretch& s : rows.stretches()) {
    const std::vector<MatrixXd> all = along(s);
    for (size_t p = 0; p < parameters; ++p) {
      MatrixXd some(all[p].rows(), static_cast<Eigen::Index>(joints.size()));
      for (size_t k = 0; k < joints.size(); ++k)
        some.col(static_cast<Eigen::Index>(k)) = rows.arm().coordinates()[joints[k]].recorded.torque_gain * all[p].col(joints[k]);
      MatrixXd kept(rows.rows(), some.cols());
      rows.put(s, std::move(some), kept);
      const auto count = static_cast<Eigen::Index>(s.kept.size());
      for (size_t k = 0; k < joints.size(); ++k)
        out.of[k].col(static_cast<Eigen::Index>(p)).segment(s.first, count) = kept.col(static_cast<Eigen::Index>(k)).segment(s.first, count);
    }
  }
  return out;
}

Columns channel_columns(const Term& term, const Rows& rows) {
  const ChannelEffect& channel = *channel_effect(term.effect.effect);
  const std::optional<JointIndex> joint = joint_of(term.cause);
  std::vector<int> joints;
  for (int i = 0; i < rows.joints(); ++i) {
    if (channel.acts_on(i, joint)) joints.push_back(i);
  }
  return whole_columns(rows, joints, channel.parameters().size(), [&](const Stretch& s) {
    const Segment& m = s.segment;
    ChannelMotion motion{rows.arm(), rows.bodies(), rows.phi(), m.q, m.dq, m.ddq, s.torque, m.dt};
    motion.from = term.candidate.from;
    return channel.columns(motion, joint);
  });
}

Columns constant_columns(const Term& term, const Rows& rows) {
  const double value = value_in(rows.arm(), *term.constant);
  const Model more = with_constant(rows.arm(), *term.constant, value + kDifference);
  const Model less = with_constant(rows.arm(), *term.constant, value - kDifference);
  const TorqueRegressor above(more), below(less);
  std::vector<int> joints(rows.joints());
  std::iota(joints.begin(), joints.end(), 0);
  return whole_columns(rows, joints, 1, [&](const Stretch& s) {
    MatrixXd up, down;
    above.torques(s.segment.q, s.segment.dq, s.segment.ddq, rows.phi(), up);
    below.torques(s.segment.q, s.segment.dq, s.segment.ddq, rows.phi(), down);
    return std::vector<MatrixXd>{(up - down) / (2.0 * kDifference)};
  });
}

Columns curve_columns_at(const Term& term, const Rows& rows) {
  Columns out;
  out.joints = {term.joint->value};
  for (const Stretch& s : rows.stretches()) {
    MatrixXd x(s.segment.q.rows(), static_cast<Eigen::Index>(term.signals.size()));
    for (size_t k = 0; k < term.signals.size(); ++k) {
      const Signal& signal = term.signals[k];
      const double fastest = s.segment.dq.col(signal.joint).cwiseAbs().maxCoeff();
      x.col(static_cast<Eigen::Index>(k)) = signal_along(signal, s, kRestShare * fastest);
    }
    MatrixXd columns = curve_columns(term, x);
    if (out.of.empty()) out.of.emplace_back(rows.rows(), columns.cols());
    rows.put(s, std::move(columns), out.of[0]);
  }
  return out;
}

constexpr auto kWaves = static_cast<size_t>((kLastWave - kFirstWave) / kWaveGrid);  // wave numbers of a spectrum

// The most prominent wave numbers in a joint's residual over its position, the largest first.
// @param unit  wave number of one wave per travel.
std::vector<double> prominent_wave_numbers(const Rows& rows, const MatrixXd& residual, int joint, double unit) {
  std::vector<double> s, r;
  for (const Stretch& stretch : rows.stretches()) {
    for (size_t k = 0; k < stretch.kept.size(); ++k) {
      const Eigen::Index row = stretch.first + static_cast<Eigen::Index>(k);
      s.push_back(stretch.segment.q(stretch.kept[k], joint));
      r.push_back(residual(row, joint) * rows.used(row, joint));
    }
  }
  const std::vector<double> sizes = line_amplitudes(s, r, kFirstWave * unit, kWaveGrid * unit, kWaves);
  const double floor = kProminence * median(sizes);
  std::vector<std::pair<double, double>> lines;
  for (size_t k = 1; k + 1 < sizes.size(); ++k) {
    if (sizes[k] >= floor && sizes[k] >= sizes[k - 1] && sizes[k] >= sizes[k + 1])
      lines.emplace_back(sizes[k], (kFirstWave + kWaveGrid * static_cast<double>(k)) * unit);
  }
  std::sort(lines.rbegin(), lines.rend());
  std::vector<double> out;
  for (size_t k = 0; k < std::min(lines.size(), kMostLines); ++k) out.push_back(lines[k].second);
  return out;
}

}  // namespace

bool TermScope::is_wanted(const Model& arm, const Cause& cause) const {
  return wanted.empty() || std::any_of(wanted.begin(), wanted.end(), [&](const std::string& one) { return one == effect_of(cause) || one == to_text(arm, cause); });
}

double largest_change_of(const FrameConstant& constant) {
  return unit_of(constant) == "m" ? kLengthReach : kAngleReach;
}

bool same_place(const Term& a, const Term& b) {
  return a.place == b.place;
}

// dL / d(m, h) of a point mass at c: L is homogeneous of degree one in mass and moments.
Eigen::Matrix<double, 10, 10> load_parameters(const Eigen::Vector3d& c) {
  Eigen::Matrix<double, 10, 10> out = Eigen::Matrix<double, 10, 10>::Identity();
  static const int kRow[6] = {0, 0, 1, 0, 1, 2}, kColumn[6] = {0, 1, 1, 2, 2, 2};
  for (int e = 0; e < 6; ++e) {
    const int i = kRow[e], j = kColumn[e];
    const double same = i == j ? 1.0 : 0.0;
    out(4 + e, 0) = -(c.squaredNorm() * same - c[i] * c[j]);
    for (int k = 0; k < 3; ++k)
      out(4 + e, 1 + k) = 2.0 * c[k] * same - (i == k ? c[j] : 0.0) - (j == k ? c[i] : 0.0);
  }
  return out;
}

std::vector<Term> dictionary(const Rows& rows, const TermScope& scope) {
  return Builder(rows, scope).all();
}

std::vector<Term> ripples(const Rows& rows, const MatrixXd& residual, const std::vector<Term>& all, int threads) {
  std::vector<Term> out;
  const std::vector<Range> range = ranges_of(rows);
  double price = 0.0;
  for (const Term& t : all) price = std::max(price, t.kind == TermKind::kEffect ? t.price : 0.0);
  std::vector<std::vector<double>> lines(rows.joints());
  parallel_for(rows.joints(), threads, [&](int i) {
    if (range[i].travel() > (rows.arm().coordinates()[i].prismatic ? kStillLength : kStill))
      lines[i] = prominent_wave_numbers(rows, residual, i, 2.0 * M_PI / range[i].travel());
  });
  for (int i = 0; i < rows.joints(); ++i) {
    for (const AxisEffect* effect : axis_effects()) {
      for (const EffectShape& shape : effect->shapes()) {
        if (shape.scale != ShapeScale::kWaves) continue;
        for (const double order : lines[i]) {
          Term t;
          t.cause = NewEffect{effect->name(), JointIndex{i}};
          t.candidate = {t.cause, JointIndex{i}, Axis{VectorXd::Unit(rows.joints(), i), 0.0}, std::nullopt};
          t.joint = JointIndex{i};
          t.place = to_text(rows.arm(), t.cause) + axis_text(rows.arm(), t.candidate.axis);
          t.effect.effect = effect->name();
          t.effect.axis = t.candidate.axis;
          t.effect.values[shape.name] = std::clamp(order, shape.lower, shape.upper);
          t.shapes = {{shape.name, shape.lower, shape.upper, false, kWaveGrid * 2.0 * M_PI / range[i].travel(), false}};
          t.price = std::log(static_cast<double>(kWaves)) + price;
          out.push_back(std::move(t));
        }
      }
    }
  }
  return out;
}

Columns columns_of(const Term& term, const Rows& rows) {
  switch (term.kind) {
    case TermKind::kLoad: return load_columns(term, rows);
    case TermKind::kChannel: return channel_columns(term, rows);
    case TermKind::kConstant: return constant_columns(term, rows);
    case TermKind::kCurve: return curve_columns_at(term, rows);
    default: return effect_columns(term, rows);
  }
}

Model with_step(const Model& arm, const Term& term, const std::vector<double>& step) {
  if (term.kind == TermKind::kConstant)
    return with_constant(arm, *term.constant, value_in(arm, *term.constant) + step[0]);
  return with_channel_error(arm, term.effect, step);
}

VectorXd signal_along(const Signal& signal, const Stretch& s, double rest_speed) {
  const Segment& m = s.segment;
  switch (signal.kind) {
    case SignalKind::kPosition: return m.q.col(signal.joint);
    case SignalKind::kVelocity: return m.dq.col(signal.joint);
    case SignalKind::kTorque: return s.torque.col(signal.joint);
    case SignalKind::kTime: return m.time.array() - m.start;
    case SignalKind::kHistory: break;
  }
  // Signed travel since the last reversal.
  VectorXd out(m.q.rows());
  double from = m.q.rows() > 0 ? m.q(0, signal.joint) : 0.0;
  double direction = 0.0;
  for (Eigen::Index k = 0; k < out.size(); ++k) {
    const double v = m.dq(k, signal.joint);
    const double now = std::abs(v) > rest_speed ? (v > 0.0 ? 1.0 : -1.0) : direction;
    if (now != direction) {
      direction = now;
      from = m.q(std::max<Eigen::Index>(k - 1, 0), signal.joint);
    }
    out[k] = direction * std::abs(m.q(k, signal.joint) - from);
  }
  return out;
}

MatrixXd curve_columns(const Term& term, const MatrixXd& signals) {
  Eigen::Index count = 1;
  for (const SmoothBasis& b : term.bases) count *= b.size();
  MatrixXd out(signals.rows(), count);
  std::vector<double> first(static_cast<size_t>(term.bases[0].size()));
  for (Eigen::Index r = 0; r < signals.rows(); ++r) {
    term.bases[0].values(signals(r, 0), first.data());
    if (term.bases.size() == 1) {
      for (Eigen::Index c = 0; c < count; ++c) out(r, c) = first[c];
      continue;
    }
    std::vector<double> second(static_cast<size_t>(term.bases[1].size()));
    term.bases[1].values(signals(r, 1), second.data());
    Eigen::Index c = 0;
    for (const double b : second) {
      for (const double a : first) out(r, c++) = a * b;
    }
  }
  return out;
}

}  // namespace veridyn::search
