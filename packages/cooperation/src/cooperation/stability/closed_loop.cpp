#include "closed_loop.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "cooperation/loop_gains.hpp"
#include "sample_pattern.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr double kSameTime = 1e-9;   // [s] tolerance of equal times, as in ForceSensor
constexpr double kLongestDelay = 1000.0;  // cycles: each is a state of a dense matrix
constexpr int kOneByOne = 24;             // equal cycles in a row, above which a power of their map is used

}  // namespace

ClosedLoop::ClosedLoop(const LinearPoint& point, const Scenario& scenario,
                       const LoopSettings& settings)
    : point_(point), settings_(settings) {
  const ScenarioControl& c = scenario.control;
  period_ = 1.0 / c.rate;
  p_ = std::exp(-2.0 * M_PI * c.velocity_cutoff * period_);
  observer_ = c.observer > 0.0 ? 2.0 * M_PI * c.observer : 0.0;
  motor_ = c.motor_lag > 0.0 ? 1.0 - std::exp(-period_ / c.motor_lag) : 1.0;
  torque_delay_ = c.torque_delay;
  assign_states(point, scenario);
  for (size_t k = 0; k < arm_.size(); ++k) prepare_arm(static_cast<int>(k), scenario);
  for (size_t k = 0; k < element_.size(); ++k) prepare_element(static_cast<int>(k), scenario);
  prepare_plant();
  classify_cycles();
}

void ClosedLoop::assign_states(const LinearPoint& point, const Scenario& scenario) {
  joints_ = 0;
  for (const LinearArm& arm : point.arms) {
    Arm a;
    a.q = joints_;
    a.n = arm.joints();
    joints_ += a.n;
    arm_.push_back(a);
  }
  states_ = 2 * joints_;
  for (Arm& a : arm_) {
    a.observer = states_;
    states_ += 4 * a.n;
    if (motor_ < 1.0) {
      a.motor = states_;
      states_ += a.n;
    }
    if (torque_delay_ > 0) {
      a.queue = states_;
      states_ += torque_delay_ * a.n;
    }
  }
  const double rate = scenario.control.rate;
  const auto sensor_of = [&scenario](size_t k) -> const ForceSensorOptions& {
    const size_t members = scenario.members.size();
    return k < members ? scenario.members[k].sensor : scenario.walls[k - members].sensor;
  };
  std::vector<double> samples;
  for (size_t k = 0; k < point.elements.size(); ++k) samples.push_back(sensor_of(k).rate / rate);
  const SamplePattern pattern = sample_pattern(samples);
  hyperperiod_ = pattern.cycles;
  for (size_t k = 0; k < point.elements.size(); ++k) {
    Element e;
    const ForceSensorOptions& sensor = sensor_of(k);
    e.ratio = pattern.ratios[k];
    const double cycles = std::ceil((sensor.delay - kSameTime) * rate);
    require(cycles <= kLongestDelay, "found a force sensor's delay of ", sensor.delay, " s, ", cycles,
            " cycles of the loop, expected at most ", kLongestDelay, " cycles.");
    e.delay = std::max(0, static_cast<int>(cycles)) + settings_.extra_delay;
    e.line = states_;
    states_ += e.delay;
    if (e.ratio < 1.0) e.held = states_++;
    if (scenario.control.force_cutoff > 0.0) e.filtered = states_++;
    element_.push_back(e);
  }
}

void ClosedLoop::prepare_arm(int k, const Scenario& scenario) {
  Arm& a = arm_[k];
  const ScenarioControl& c = scenario.control;
  a.gives_way = scenario.arms[k].control == ArmControl::kImpedance;
  const ImpedanceGains gains = a.gives_way ? impedance_gains(c) : position_gains(c);
  a.mass_inverse = gains.mass.head<3>().cwiseInverse().asDiagonal();
  a.damping = gains.damping.head<3>().asDiagonal();
  a.stiffness = gains.stiffness.head<3>().asDiagonal();
}

void ClosedLoop::prepare_element(int k, const Scenario& scenario) {
  Element& e = element_[k];
  const LinearElement& at = point_.elements[k];
  const ScenarioControl& c = scenario.control;
  const auto members = static_cast<int>(scenario.members.size());
  if (c.force_cutoff > 0.0)
    e.smoothing = 1.0 - std::exp(-2.0 * M_PI * c.force_cutoff * period_);
  if (k >= members) {
    const ScenarioWall& wall = scenario.walls[k - members];
    e.stiffness = wall.stiffness;
    e.damping = wall.damping;
    return;
  }
  const ScenarioMember& m = scenario.members[k];
  e.stiffness = m.stiffness;
  e.damping = m.damping;
  e.law = m.law;
  const bool from_gives = m.from != scenario.master;
  const bool to_gives = m.to != scenario.master;
  const double share = from_gives && to_gives ? member_share(scenario, m) : 1.0;
  e.share_from = from_gives ? share : 0.0;
  e.share_to = to_gives ? share : 0.0;
  const int giving = to_gives ? m.to : m.from;
  const Arm& arm = arm_[giving];
  const Eigen::Vector3d u =
      point_.arms[giving].R_world_base.transpose() * at.u;
  e.value = arm.gives_way ? at.force / (share * u.dot(arm.stiffness * u)) : at.force / m.stiffness;
  e.x_f = states_++;
}

MatrixXd ClosedLoop::line_map(int k) const {
  const LinearElement& at = point_.elements[k];
  MatrixXd L = MatrixXd::Zero(3, joints_);
  const auto add = [&](std::optional<int> arm, double sign) {
    if (!arm) return;
    const Arm& a = arm_[*arm];
    L.middleCols(a.q, a.n) += sign * point_.arms[*arm].J;
  };
  add(at.from, -1.0);
  add(at.to, 1.0);
  return L;
}

void ClosedLoop::prepare_plant() {
  MatrixXd M = MatrixXd::Zero(joints_, joints_), D = M, K = M;
  for (size_t k = 0; k < arm_.size(); ++k) {
    const Arm& a = arm_[k];
    const LinearArm& arm = point_.arms[k];
    M.block(a.q, a.q, a.n, a.n) = arm.M;
    D.block(a.q, a.q, a.n, a.n) = arm.D;
    K.block(a.q, a.q, a.n, a.n) = arm.G;
  }
  for (size_t k = 0; k < element_.size(); ++k) {
    const LinearElement& at = point_.elements[k];
    if (!at.attached) continue;
    const MatrixXd L = line_map(static_cast<int>(k));
    const Eigen::Matrix3d along = at.u * at.u.transpose();
    const Eigen::Matrix3d across = (Eigen::Matrix3d::Identity() - along) * (at.force / at.length);
    K += L.transpose() * (element_[k].stiffness * along + across) * L;
    D += L.transpose() * (element_[k].damping * along) * L;
  }
  const MatrixXd inverse = M.llt().solve(MatrixXd::Identity(joints_, joints_));
  MatrixXd A = MatrixXd::Zero(2 * joints_, 2 * joints_);
  A.topRightCorner(joints_, joints_).setIdentity();
  A.bottomLeftCorner(joints_, joints_) = -inverse * K;
  A.bottomRightCorner(joints_, joints_) = -inverse * D;
  MatrixXd B = MatrixXd::Zero(2 * joints_, joints_);
  B.bottomRows(joints_) = inverse;
  discretise(A, B, period_, transition_, input_);
}

VectorXd ClosedLoop::tension_row(int element) const {
  const auto k = static_cast<size_t>(element);
  VectorXd row = VectorXd::Zero(states_);
  const VectorXd along = line_map(element).transpose() * point_.elements[k].u;
  row.head(joints_) = element_[k].stiffness * along;
  row.segment(joints_, joints_) = element_[k].damping * along;
  return row;
}

bool ClosedLoop::has_new_sample(int element, long k) const {
  const Element& e = element_[element];
  return takes_sample(e, k - e.delay);
}

VectorXd ClosedLoop::reading_row(int element, long k) const {
  const Element& e = element_[element];
  if (e.delay == 0 && has_new_sample(element, k)) return tension_row(element);
  VectorXd row = VectorXd::Zero(states_);
  row[e.delay > 0 && has_new_sample(element, k) ? e.line + e.delay - 1 : e.held] = 1.0;
  return row;
}

// True if the element's sensor takes a sample in cycle k.
bool ClosedLoop::takes_sample(const Element& e, long k) const {
  const auto count = [&](long cycle) {
    return std::floor((static_cast<double>(cycle) + 1e-6) * e.ratio);
  };
  return e.ratio >= 1.0 || count(k) > count(k - 1);
}

// Number of cycles between the sample that arrives in cycle k and the previous one.
long ClosedLoop::cycles_since_sample(const Element& e, long k) const {
  long cycles = 1;
  while (cycles < hyperperiod_ && !takes_sample(e, k - e.delay - cycles)) ++cycles;
  return cycles;
}

// Classifies the cycles by the sensors whose samples arrive, and by the age of the previous samples.
void ClosedLoop::classify_cycles() {
  std::map<std::vector<long>, int> known;
  for (int k = 0; k < hyperperiod_; ++k) {
    std::vector<long> arrived;
    for (const Element& e : element_) {
      const long cycle = first_cycle() + k;
      arrived.push_back(takes_sample(e, cycle - e.delay) ? cycles_since_sample(e, cycle) : 0);
    }
    kinds_.push_back(known.emplace(std::move(arrived), static_cast<int>(known.size())).first->second);
  }
}

std::vector<CycleRow> ClosedLoop::rows() const {
  std::vector<CycleRow> out;
  for (int k = 0; k < hyperperiod_;) {
    int end = k + 1;
    while (end < hyperperiod_ && kinds_[end] == kinds_[k]) ++end;
    const int step = end - k > kOneByOne ? end - k : 1;
    out.push_back({first_cycle() + k, kinds_[k], step});
    k += step;
  }
  return out;
}

// Sets `fresh` if a sample arrives in cycle k; it then replaces the held reading of a slow sensor.
void ClosedLoop::update_reading(long k, const Element& e, const MatrixXd& tension, MatrixXd& X,
                      bool& fresh) const {
  fresh = takes_sample(e, k - e.delay);
  if (e.ratio < 1.0 && fresh)
    X.row(e.held) =
        e.delay == 0 ? Eigen::RowVectorXd(tension) : Eigen::RowVectorXd(X.row(e.line + e.delay - 1));
}

// Updates the force law's states in X; returns the rows of its correction x_f [m].
MatrixXd ClosedLoop::law(long k, const Element& e, const MatrixXd& reading, const MatrixXd& rate,
                         bool fresh, MatrixXd& X) const {
  const double wanted = settings_.wanted;
  MatrixXd value = -e.law.damping * rate;
  value.array() += e.law.feed_forward * wanted;
  const bool proportional = e.law.kind == ForceLaw::Kind::kProportional;
  if (fresh) {
    const double since = static_cast<double>(cycles_since_sample(e, k)) * period_;
    if (proportional) {
      X.row(*e.x_f).array() -=
          settings_.integral * e.law.gain * since * (reading.array() - wanted);
    } else {
      X.row(*e.x_f).array() -= settings_.increment_gain * since * (reading.array() - wanted);
    }
  }
  value += X.row(*e.x_f);
  if (proportional) value.array() -= e.law.proportional * (reading.array() - wanted);
  return value;
}

void ClosedLoop::advance(long k, MatrixXd& X) const {
  const Eigen::Index columns = X.cols();
  const double dt = period_;
  // Encoders and velocity observer.
  std::vector<MatrixXd> velocity_before, tip, tip_rate, target, exerted;
  for (size_t i = 0; i < arm_.size(); ++i) {
    const Arm& a = arm_[i];
    auto q = X.middleRows(a.q, a.n);
    auto qh = X.middleRows(a.observer, a.n);
    auto vh = X.middleRows(a.observer + a.n, a.n);
    const auto y = X.middleRows(a.observer + 2 * a.n, a.n);
    velocity_before.emplace_back(vh);
    qh += dt * vh + 0.5 * dt * dt * y;
    vh += dt * y;
    const MatrixXd error = q - qh;
    qh += (1.0 - p_ * p_) * error;
    vh += (1.0 - p_) * (1.0 - p_) / dt * error;
    tip.emplace_back(point_.arms[i].J_known * q);
    tip_rate.emplace_back(point_.arms[i].J_known * vh);
    target.emplace_back(MatrixXd::Zero(3, columns));
    exerted.emplace_back(MatrixXd::Zero(3, columns));
  }
  // Sensors and force laws.
  for (size_t i = 0; i < element_.size(); ++i) {
    const Element& e = element_[i];
    const LinearElement& at = point_.elements[i];
    if (!at.attached) continue;
    const Eigen::RowVector3d u = at.u.transpose();
    const MatrixXd L = line_map(static_cast<int>(i));
    const Eigen::RowVectorXd Lu = u * L;
    const MatrixXd tension = e.stiffness * (Lu * X.topRows(joints_)) +
                             e.damping * (Lu * X.middleRows(joints_, joints_));
    MatrixXd line = MatrixXd::Zero(3, columns), line_rate = line;
    const auto add = [&](std::optional<int> arm, double sign) {
      if (!arm) return;
      line += sign * tip[*arm];
      line_rate += sign * tip_rate[*arm];
    };
    add(at.from, -1.0);
    add(at.to, 1.0);
    bool fresh = false;
    update_reading(k, e, tension, X, fresh);
    MatrixXd reading = e.ratio < 1.0 ? MatrixXd(X.row(e.held))
                       : e.delay == 0 ? tension
                                      : MatrixXd(X.row(e.line + e.delay - 1));
    for (int s = e.delay - 1; s > 0; --s) X.row(e.line + s) = X.row(e.line + s - 1);
    if (e.delay > 0) X.row(e.line) = tension;
    reading *= settings_.reading_gain;
    if (e.filtered) {
      X.row(*e.filtered) += e.smoothing * (reading - X.row(*e.filtered));
      reading = X.row(*e.filtered);
    }
    const MatrixXd turned = (line - at.u * (u * line)) / at.length;  // change of the unit vector along the line
    const MatrixXd force = at.u * reading + at.force * turned;
    if (at.from) exerted[*at.from] -= force;
    if (at.to) exerted[*at.to] += force;
    if (!e.x_f) continue;
    const MatrixXd value = law(k, e, reading, u * line_rate, fresh, X);
    const MatrixXd way = at.u * value + e.value * turned;
    if (at.from) target[*at.from] -= e.share_from * way;
    if (at.to) target[*at.to] += e.share_to * way;
  }
  // Torques of the arms.
  MatrixXd applied(joints_, columns);
  for (size_t i = 0; i < arm_.size(); ++i) {
    const Arm& a = arm_[i];
    const LinearArm& arm = point_.arms[i];
    const auto q = X.middleRows(a.q, a.n);
    const auto vh = X.middleRows(a.observer + a.n, a.n);
    auto y = X.middleRows(a.observer + 2 * a.n, a.n);
    auto d = X.middleRows(a.observer + 3 * a.n, a.n);
    const MatrixXd lacking = dt * y - (vh - velocity_before[i]);
    const auto to_base = arm.R_world_base.transpose();
    const MatrixXd error = to_base * (target[i] - tip[i]);
    MatrixXd effort = a.stiffness * error - a.damping * (to_base * tip_rate[i]);
    if (a.gives_way) effort -= to_base * exerted[i];
    y = arm.damped_inverse * (a.mass_inverse * effort) -
        arm.null_space * (kPostureDamping * vh + kPostureStiffness * q);
    MatrixXd tau = arm.G_known * q + arm.M_known * y;
    if (a.gives_way) tau += arm.J_base.transpose() * (to_base * exerted[i]);
    d += observer_ * (arm.M_known * lacking);
    tau += d;
    if (a.queue) {
      const MatrixXd late = X.middleRows(*a.queue + (torque_delay_ - 1) * a.n, a.n);
      for (int s = torque_delay_ - 1; s > 0; --s)
        X.middleRows(*a.queue + s * a.n, a.n) = X.middleRows(*a.queue + (s - 1) * a.n, a.n).eval();
      X.middleRows(*a.queue, a.n) = tau;
      tau = late;
    }
    if (a.motor) {
      X.middleRows(*a.motor, a.n) += motor_ * (tau - X.middleRows(*a.motor, a.n));
      tau = X.middleRows(*a.motor, a.n);
    }
    applied.middleRows(a.q, a.n) = tau;
  }
  X.topRows(2 * joints_) = transition_ * X.topRows(2 * joints_) + input_ * applied;
}

MatrixXd ClosedLoop::map() const {
  MatrixXd X = MatrixXd::Identity(states_, states_);
  for (const CycleRow& row : rows()) {
    if (row.count == 1) {
      advance(row.first, X);
      continue;
    }
    MatrixXd one = MatrixXd::Identity(states_, states_);
    advance(row.first, one);
    X = (power(std::move(one), row.count) * X).eval();
  }
  // States without dynamics would have an eigenvalue of one: a correction without an integral part,
  // an observer that is switched off.
  for (const Element& e : element_) {
    const double gain = e.law.kind == ForceLaw::Kind::kProportional
                            ? settings_.integral * e.law.gain
                            : settings_.increment_gain;
    const bool attached = point_.elements[&e - element_.data()].attached;
    if (e.x_f && (gain <= 0.0 || !attached)) X.row(*e.x_f).setZero();
    if (attached) continue;
    X.middleRows(e.line, e.delay).setZero();
    if (e.ratio < 1.0) X.row(e.held).setZero();
    if (e.filtered) X.row(*e.filtered).setZero();
  }
  for (const Arm& a : arm_) {
    if (observer_ <= 0.0) X.middleRows(a.observer + 3 * a.n, a.n).setZero();
  }
  return X;
}

}  // namespace veridyn
