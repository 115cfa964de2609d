#include "veridyn/control/cooperative_controller.hpp"

#include <algorithm>
#include <cmath>

#include "math/rotation.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

using Eigen::Vector3d;

constexpr double kShortest = 1e-9;  // [m] smallest distance of tips with a defined direction

Vector3d centroid(const std::vector<Vector3d>& points) {
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

// Unit vector; zero for a displacement of at most kShortest.
Vector3d direction(const Vector3d& displacement) {
  const double length = displacement.norm();
  return length > kShortest ? Vector3d(displacement / length) : Vector3d::Zero();
}

void check(const CooperativeOptions& o, std::size_t tips) {
  const auto arms = static_cast<int>(o.R_world_arm.size());
  require(arms >= 1 && o.R_world_arm.size() == tips, "cooperative controller: found ", tips,
          " tips and ", arms, " bases, expected one of each for at least one arm.");
  require(o.leader >= 0 && o.leader < arms, "cooperative controller: found the leader ", o.leader,
          ", expected one of ", arms, " arms from 0.");
  for (const Eigen::Matrix3d& R : o.R_world_arm)
    require(is_rotation(R, 1e-6), "cooperative controller: found a base whose R_world_arm is no rotation.");
  for (const CooperativeMember& m : o.members) {
    require(m.from >= 0 && m.from < arms && m.to >= 0 && m.to < arms && m.from != m.to,
            "cooperative controller: found a member between the arms ", m.from, " and ", m.to,
            ", expected two different ones of ", arms, " from 0.");
    require(m.share > 0.0 && m.share <= 1.0, "cooperative controller: found a share of ", m.share,
            ", expected a number above zero and at most one.");
  }
  require(o.drift_factor >= 1.0, "cooperative controller: found a drift_factor of ", o.drift_factor,
          ", expected one or more.");
  require(o.largest_energy > 0.0, "cooperative controller: found a largest energy of ",
          o.largest_energy, " J, expected one above zero.");
  for (const double value :
       {o.period, o.largest_force, o.largest_force_error, o.largest_age, o.largest_error,
        o.stuck_force, o.jump_force, o.drift_force, o.drift_length, o.drift_way, o.stop_duration, o.relief_force, o.relief_gain, o.relief_speed}) {
    require(std::isfinite(value) && value > 0.0, "cooperative controller: found ", value,
            " for a period or a bound, expected a number above zero.");
  }
}

// The options; throws InvalidInput if they do not fit the number of tips.
CooperativeOptions checked(const CooperativeOptions& options, std::size_t tips) {
  check(options, tips);
  return options;
}

TetherGuard guard_of(const CooperativeOptions& o) {
  std::vector<TetherGuard::Member> members;
  for (const CooperativeMember& m : o.members) members.push_back({m.from, m.to, m.law.stiffness});
  TetherGuardOptions options = o.tether;
  options.period = o.period;
  return {static_cast<int>(o.R_world_arm.size()), std::move(members), options};
}

}  // namespace

const char* describe(CooperativeState state) {
  switch (state) {
    case CooperativeState::kTracking:
      return "tracks";
    case CooperativeState::kForceTooLarge:
      return "holds: a force is too large";
    case CooperativeState::kForceMissed:
      return "holds: a force is too far from the one wanted";
    case CooperativeState::kSensorStale:
      return "holds: a force sensor's samples are too old";
    case CooperativeState::kSensorStuck:
      return "holds: a force sensor repeats one value while its member changes its length";
    case CooperativeState::kSensorJumped:
      return "holds: a force sensor's reading jumps while its member keeps its length";
    case CooperativeState::kSensorDrifted:
      return "holds: a force sensor's reading leaves what its member's length says";
    case CooperativeState::kArmLost:
      return "holds: an arm does not follow any more";
    case CooperativeState::kTargetMissed:
      return "holds: a tip is too far from its target";
    case CooperativeState::kEnergyMade:
      return "holds: a member gets more energy than its bound";
    case CooperativeState::kNotFinite:
      return "holds: found a measurement that is not finite";
  }
  return "";
}

CooperativeController::CooperativeController(const CooperativeOptions& options,
                                             const std::vector<Vector3d>& tips)
    : options_(checked(options, tips.size())),
      tracked_(options.members.size(), 1),
      watches_(options.members.size()),
      monitors_(options.members.size()),
      guard_(guard_of(options)),
      targets_(tips.size()),
      centre_(VectorXd(centroid(tips))),
      angle_(VectorXd::Zero(1)),
      wanted_(VectorXd::Zero(
          std::max<Eigen::Index>(1, static_cast<Eigen::Index>(options.members.size())))),
      relief_(tips.size(), Vector3d::Zero()),
      scratch3_(VectorXd::Zero(3)),
      scratch1_(VectorXd::Zero(1)),
      goal_(wanted_.x()) {
  for (const CooperativeMember& member : options.members) trackers_.emplace_back(member.law);
  for (size_t i = 0; i < tips.size(); ++i) grips_.emplace_back(scratch3_);
  restart(tips);
}

void CooperativeController::restart(const std::vector<Vector3d>& tips) noexcept {
  const Vector3d centre = centroid(tips);
  scratch3_ = centre;
  centre_.reset(scratch3_);
  scratch1_.setZero();
  angle_.reset(scratch1_);
  R_start_.setIdentity();
  for (size_t i = 0; i < grips_.size(); ++i) {
    scratch3_ = tips[i] - centre;
    grips_[i].reset(scratch3_);
  }
  goal_.setZero();
  wanted_.reset(goal_);
  for (ForceTracker& tracker : trackers_) tracker.reset();
  for (Watch& watch : watches_) watch = {};
  for (PassivityMonitor& monitor : monitors_) monitor.reset();
  for (Vector3d& relief : relief_) relief.setZero();
  guard_.reset();
  state_ = CooperativeState::kTracking;
  plan();
}

bool CooperativeController::move(const Vector3d& displacement, double duration) noexcept {
  if (!commands_allowed()) return false;
  scratch3_ =
      centre_.goal() + options_.R_world_arm[options_.leader].lazyProduct(displacement);
  return centre_.move_to(scratch3_, duration);
}

bool CooperativeController::rotate(const Vector3d& euler, double duration) noexcept {
  if (!commands_allowed() || !angle_.arrived() || !euler.allFinite() || !(duration > 0.0))
    return false;
  const Eigen::Matrix3d& R_leader = options_.R_world_arm[options_.leader];
  const Eigen::AngleAxisd whole(Eigen::AngleAxisd(euler.z(), Vector3d::UnitZ()) *
                                Eigen::AngleAxisd(euler.y(), Vector3d::UnitY()) *
                                Eigen::AngleAxisd(euler.x(), Vector3d::UnitX()));
  R_start_ = Eigen::AngleAxisd(angle_.x()[0], axis_).toRotationMatrix() * R_start_;
  axis_ = R_leader * whole.axis();
  scratch1_.setZero();
  angle_.reset(scratch1_);
  scratch1_[0] = whole.angle();
  return angle_.move_to(scratch1_, duration);
}

bool CooperativeController::expand_grasp(double by, double duration) noexcept {
  if (!commands_allowed() || !std::isfinite(by) || !(duration > 0.0)) return false;
  for (size_t i = 0; i < grips_.size(); ++i) {
    if (static_cast<int>(i) == options_.leader) continue;
    const Vector3d out = direction(grips_[i].goal());
    scratch3_ = grips_[i].goal() + by * out;
    if (!grips_[i].move_to(scratch3_, duration)) return false;
  }
  return true;
}

bool CooperativeController::move_arm(int arm, const Vector3d& displacement, double duration) noexcept {
  if (!commands_allowed() || arm < 0 || arm >= arms()) return false;
  const Eigen::Matrix3d R = Eigen::AngleAxisd(angle_.x()[0], axis_).toRotationMatrix() * R_start_;
  QuinticInterpolator& grip = grips_[arm];
  scratch3_ = grip.goal() + R.transpose().lazyProduct(displacement);
  return grip.move_to(scratch3_, duration);
}

bool CooperativeController::set_force(int member, double force, double duration) noexcept {
  if (!commands_allowed() || member < 0 || member >= static_cast<int>(trackers_.size()))
    return false;
  goal_ = wanted_.goal();
  goal_[member] = force;
  return wanted_.move_to(goal_, duration);
}

bool CooperativeController::track(int member, bool on) noexcept {
  if (!commands_allowed() || member < 0 || member >= static_cast<int>(trackers_.size()))
    return false;
  const auto k = static_cast<size_t>(member);
  if (on == (tracked_[k] != 0)) return true;
  if (on) trackers_[k].reset();
  tracked_[k] = on ? 1 : 0;
  watches_[k] = {};
  monitors_[k].reset();
  guard_.reset_member(member);
  return true;
}

void CooperativeController::stop() noexcept {
  centre_.stop(options_.stop_duration);
  angle_.stop(options_.stop_duration);
  for (QuinticInterpolator& grip : grips_) grip.stop(options_.stop_duration);
  wanted_.stop(options_.stop_duration);
}

// Computes x_d of every tip and its derivatives from the object's motion.
void CooperativeController::plan() noexcept {
  const Eigen::Matrix3d R = Eigen::AngleAxisd(angle_.x()[0], axis_).toRotationMatrix() * R_start_;
  const Vector3d omega = angle_.dx()[0] * axis_;
  const Vector3d alpha = angle_.ddx()[0] * axis_;
  const Vector3d p = centre_.x();
  const Vector3d dp = centre_.dx();
  const Vector3d ddp = centre_.ddx();
  for (size_t i = 0; i < targets_.size(); ++i) {
    const Vector3d r = R * Vector3d(grips_[i].x());
    const Vector3d dr = R * Vector3d(grips_[i].dx());
    const Vector3d ddr = R * Vector3d(grips_[i].ddx());
    TipTarget& target = targets_[i];
    target.motion = p + r;
    target.velocity = dp + omega.cross(r) + dr;
    target.acceleration =
        ddp + alpha.cross(r) + omega.cross(omega.cross(r)) + 2.0 * omega.cross(dr) + ddr;
    target.position = target.motion;
    target.force.setZero();
    target.relief = {};
  }
}

// Applies (7.10) to (7.12) to every member.
void CooperativeController::correct(const CooperativeInput& input) noexcept {
  const bool active = commands_allowed();
  for (size_t k = 0; k < trackers_.size(); ++k) {
    if (tracked_[k] == 0) continue;
    const CooperativeMember& m = options_.members[k];
    const auto from = static_cast<size_t>(m.from);
    const auto to = static_cast<size_t>(m.to);
    const Vector3d line = input.position[to] - input.position[from];
    const Vector3d u = direction(line.allFinite() ? line : targets_[to].motion - targets_[from].motion);
    const double wanted = wanted_.x()[static_cast<Eigen::Index>(k)];
    const double planned = u.dot(targets_[to].velocity - targets_[from].velocity);
    const double rate = u.dot(input.velocity[to] - input.velocity[from]) - planned;
    const double x_f = active ? trackers_[k].update(wanted, input.force[k], rate, options_.period)
                              : trackers_[k].update_without_sensor(wanted, rate);
    const bool from_gives = m.from != options_.leader;
    const bool to_gives = m.to != options_.leader;
    const double share = from_gives && to_gives ? m.share : 1.0;
    if (from_gives) targets_[from].position -= share * x_f * u;
    if (to_gives) targets_[to].position += share * x_f * u;
    targets_[from].force -= wanted * u;
    targets_[to].force += wanted * u;
  }
}

bool CooperativeController::is_stuck(size_t member, const ForceReading& reading,
                                     double length) noexcept {
  Watch& watch = watches_[member];
  const double force = std::isfinite(reading.raw) ? reading.raw : reading.force;
  if (!watch.number || force != watch.force) {
    watch.force = force;
    watch.length = length;
    watch.number = reading.number;
    return false;
  }
  const double stiffness = options_.members[member].law.stiffness;
  // Repeated zeros of a slack member are no sign of a stuck sensor.
  return reading.number != watch.number && stiffness > 0.0 && force != 0.0 &&
         std::abs(length - watch.length) * stiffness > options_.stuck_force;
}

// True if the force changes between two samples by more than the length explains. The length of the member is
// known in every cycle, its force at the rate of the sensor. A slack member has no force at any length.
bool CooperativeController::jumps(size_t member, const ForceReading& reading,
                                  double length) noexcept {
  Watch& watch = watches_[member];
  const double force = std::isfinite(reading.raw) ? reading.raw : reading.force;
  if (reading.number == watch.last_number) return false;
  const bool first = !watch.last_number;
  const double change = std::abs(force - watch.last_force);
  const double way = std::abs(length - watch.last_length);
  watch.last_number = reading.number;
  watch.last_force = force;
  watch.last_length = length;
  const double stiffness = options_.members[member].law.stiffness;
  return !first && stiffness > 0.0 && change > options_.jump_force + 2.0 * stiffness * way;
}

// True if a reading disagrees with the member's length over the whole time since the wanted force last arrived:
// a law that follows a drifting sensor changes the length until they disagree. A slack string has no force,
// although its length would imply a negative one.
bool CooperativeController::drifts(size_t member, const ForceReading& reading,
                                   const CooperativeInput& input) noexcept {
  Watch& watch = watches_[member];
  const CooperativeMember& m = options_.members[member];
  const Vector3d& from = input.position[m.from];
  const Vector3d& to = input.position[m.to];
  const double length = (to - from).norm();
  if (!watch.compared || (wanted_.arrived() && !arrived_)) {
    watch.compared = true;
    watch.sound_force = reading.force;
    watch.sound_length = length;
    watch.from = from;
    watch.to = to;
    return false;
  }
  const double k = m.law.stiffness;
  const double change = k * (length - watch.sound_length);
  const double less = watch.sound_force + std::min(change / options_.drift_factor, change * options_.drift_factor);
  const double more = watch.sound_force + std::max(change / options_.drift_factor, change * options_.drift_factor);
  const double way = (from - watch.from).norm() + (to - watch.to).norm();
  const double margin = options_.drift_force + k * (options_.drift_length + options_.drift_way * way);
  return k > 0.0 && (reading.force < less - margin || reading.force > std::max(more, 0.0) + margin);
}

// Checks the generated energy while the wanted force is constant, since it is defined only then.
bool CooperativeController::generates_energy(size_t member, const ForceReading& reading,
                                         const CooperativeInput& input) noexcept {
  PassivityMonitor& monitor = monitors_[member];
  if (!wanted_.arrived() || !reading.number) {
    monitor.reset();
    return false;
  }
  const CooperativeMember& m = options_.members[member];
  const auto from = static_cast<size_t>(m.from);
  const auto to = static_cast<size_t>(m.to);
  const Vector3d u = direction(input.position[to] - input.position[from]);
  const double planned = u.dot(targets_[to].velocity - targets_[from].velocity);
  const double rate = u.dot(input.velocity[to] - input.velocity[from]) - planned;
  const double wanted = wanted_.x()[static_cast<Eigen::Index>(member)];
  monitor.update(reading.force - wanted, rate, options_.period);
  return monitor.generated() > options_.largest_energy;
}

CooperativeState CooperativeController::check_input(const CooperativeInput& input) noexcept {
  // The stretch of a member under its force displaces its ends from the path of the motion.
  double stretch = 0.0;
  for (size_t k = 0; k < trackers_.size(); ++k) {
    const double stiffness = options_.members[k].law.stiffness;
    const double force = std::abs(wanted_.x()[static_cast<Eigen::Index>(k)]);
    if (tracked_[k] != 0 && stiffness > 0.0) stretch += force / stiffness;
  }
  for (size_t i = 0; i < targets_.size(); ++i) {
    if (!input.position[i].allFinite() || !input.velocity[i].allFinite())
      return CooperativeState::kNotFinite;
    if (input.healthy[i] == 0) return CooperativeState::kArmLost;
    if ((input.position[i] - targets_[i].motion).norm() > options_.largest_error + stretch)
      return CooperativeState::kTargetMissed;
  }
  for (size_t k = 0; k < trackers_.size(); ++k) {
    if (tracked_[k] == 0) continue;
    const ForceReading& reading = input.force[k];
    if (!std::isfinite(reading.force)) return CooperativeState::kNotFinite;
    Watch& watch = watches_[k];
    watch.silent = !reading.number ? watch.silent + options_.period : 0.0;
    if (!(std::max(reading.age, watch.silent) <= options_.largest_age))
      return CooperativeState::kSensorStale;
    const double wanted = wanted_.x()[static_cast<Eigen::Index>(k)];
    if (reading.number && std::abs(reading.force) > options_.largest_force)
      return CooperativeState::kForceTooLarge;
    if (reading.number && std::abs(reading.force - wanted) > options_.largest_force_error)
      return CooperativeState::kForceMissed;
    const CooperativeMember& m = options_.members[k];
    if (generates_energy(k, reading, input)) return CooperativeState::kEnergyMade;
    const double length =
        (input.position[m.to] - input.position[m.from])
            .norm();
    if (reading.number && is_stuck(k, reading, length)) return CooperativeState::kSensorStuck;
    if (reading.number && jumps(k, reading, length)) return CooperativeState::kSensorJumped;
    if (reading.number && drifts(k, reading, input)) return CooperativeState::kSensorDrifted;
  }
  return CooperativeState::kTracking;
}

// While targets are held: ends that still follow, the leader's included, yield along members whose force
// exceeds the bound. Readings of failed sensors are ignored.
void CooperativeController::relieve(const CooperativeInput& input) noexcept {
  if (sensor_failed()) return;
  for (size_t k = 0; k < trackers_.size(); ++k) {
    const ForceReading& reading = input.force[k];
    const double beyond = std::abs(reading.force) - options_.relief_force;
    if (tracked_[k] == 0 || !(reading.age <= options_.largest_age) || !(beyond > 0.0) ||
        !std::isfinite(beyond))
      continue;
    const auto from = static_cast<size_t>(options_.members[k].from);
    const auto to = static_cast<size_t>(options_.members[k].to);
    const double speed = std::min(options_.relief_speed, options_.relief_gain * beyond);
    const Vector3d step = std::copysign(speed * options_.period, reading.force) *
                          direction(input.position[to] - input.position[from]);
    if (input.healthy[from] != 0) relief_[from] += step;
    if (input.healthy[to] != 0) relief_[to] -= step;
  }
  for (size_t i = 0; i < targets_.size(); ++i) targets_[i].relief.position += relief_[i];
}

void CooperativeController::update_lengths(const CooperativeInput& input) noexcept {
  for (size_t k = 0; k < trackers_.size(); ++k) {
    if (tracked_[k] == 0 || !input.force[k].number) continue;
    const CooperativeMember& m = options_.members[k];
    const Vector3d line =
        input.position[m.to] - input.position[m.from];
    guard_.update_length(static_cast<int>(k), line.norm(), input.force[k].force);
  }
}

// While targets are held: follows a falling arm first, then yields to forces.
void CooperativeController::give_way(const CooperativeInput& input) noexcept {
  if (options_.guard) {
    for (size_t k = 0; k < trackers_.size(); ++k) {
      const CooperativeMember& m = options_.members[k];
      // The length of a member needs both positions; without them only forces count.
      if (input.located[m.from] == 0 ||
          input.located[m.to] == 0)
        guard_.reset_member(static_cast<int>(k));
      if (tracked_[k] != 0 && !sensor_failed()) guard_.detect_compression(static_cast<int>(k), input.force[k].force);
    }
    guard_.update(input.position, input.healthy, options_.relief_force);
    for (size_t i = 0; i < targets_.size(); ++i)
      targets_[i].relief = guard_.motion(static_cast<int>(i));
  }
  relieve(input);
  for (TipTarget& target : targets_) {
    target.position += target.relief.position;
    target.velocity += target.relief.velocity;
    target.acceleration += target.relief.acceleration;
  }
}

const std::vector<TipTarget>& CooperativeController::update(
    const CooperativeInput& input) noexcept {
  if (state_ == CooperativeState::kTracking) {
    state_ = check_input(input);
    if (state_ != CooperativeState::kTracking) stop();
    arrived_ = wanted_.arrived();
  }
  centre_.advance(options_.period);
  angle_.advance(options_.period);
  if (commands_allowed()) wanted_.advance(options_.period);
  for (QuinticInterpolator& grip : grips_) grip.advance(options_.period);
  plan();
  if (state_ != CooperativeState::kNotFinite) {
    correct(input);
    if (state_ == CooperativeState::kTracking) {
      update_lengths(input);
    } else {
      give_way(input);
    }
  }
  return targets_;
}

}  // namespace veridyn
