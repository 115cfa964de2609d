#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "math/digits.hpp"
#include "registry.hpp"

namespace veridyn {
namespace {

const double kHalfTurn = std::acos(-1.0);
constexpr double kStep = 1e-4;  // [rad] step of the numerical derivative

/// Change of gravity, R' g - g, for R = Ry(pitch) Rx(roll).
Eigen::Vector3d change_of_gravity(const Eigen::Vector3d& gravity, double roll, double pitch) {
  const Eigen::Matrix3d R = (Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
                             Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()))
                                .toRotationMatrix();
  return R.transpose() * gravity - gravity;
}

/// The base is tilted by R = Ry(pitch) Rx(roll), which changes the direction of gravity in it.
///
///   d tau / d angle = the static torque under d(R' g) / d angle
class GravityTilt final : public ArmEffect {
 public:
  std::string name() const override { return "gravity_tilt"; }
  std::vector<EffectParameter> parameters() const override {
    constexpr double kLargest = 0.3;  // [rad] largest plausible tilt
    return {{"roll", "rad", "rad", ParameterSign::kAny, kLargest, kLargest},
            {"pitch", "rad", "rad", ParameterSign::kAny, kLargest, kLargest}};
  }
  std::vector<MatrixXd> columns(const ChannelMotion& motion, std::optional<JointIndex> /*joint*/) const override {
    const MatrixXd rest = MatrixXd::Zero(motion.q.rows(), motion.q.cols());
    std::vector<MatrixXd> out(2);
    for (size_t k = 0; k < out.size(); ++k) {
      ModelDescription d = motion.arm.description();
      const double roll = k == 0 ? kStep : 0.0;
      d.gravity = change_of_gravity(d.gravity, roll, kStep - roll) / kStep;
      TorqueRegressor(Model(std::move(d))).torques(motion.q, rest, rest, motion.phi, out[k]);
    }
    return out;
  }
  bool has_rigid_columns() const override { return true; }
  // Rotations about any two directions perpendicular to gravity span the tilts.
  std::vector<RigidColumn> rigid_columns(const Model& arm, std::optional<JointIndex> /*joint*/) const override {
    const Eigen::Vector3d& g = arm.gravity();
    if (g.isZero(0.0)) return {};
    const Eigen::Vector3d across = g.unitOrthogonal();
    const Eigen::Vector3d other = g.normalized().cross(across);
    const VectorXd joints = VectorXd::Ones(arm.joints());
    return {{across.cross(g), true, joints}, {other.cross(g), true, joints}};
  }
  void change(ModelDescription& arm, const std::vector<double>& values) const override {
    arm.gravity += change_of_gravity(arm.gravity, values[0], values[1]);
  }
  std::vector<std::vector<double>> further_start_values() const override {
    return {{kHalfTurn, 0.0}, {0.5 * kHalfTurn, 0.0}, {-0.5 * kHalfTurn, 0.0}, {0.0, 0.5 * kHalfTurn}, {0.0, -0.5 * kHalfTurn}};
  }
  // Solves R' g = Rx(-roll) Ry(-pitch) g: the first component of both sides gives two pitches, the others the
  // roll of each. The smaller pitch is used.
  std::vector<double> values_between(const ModelDescription& without, const ModelDescription& with,
                                     std::vector<double> sum) const override {
    const Eigen::Vector3d& from = without.gravity;
    const Eigen::Vector3d& to = with.gravity;
    const double across = std::hypot(from.x(), from.z());
    if (across == 0.0) return sum;
    const double half = std::acos(std::clamp(to.x() / across, -1.0, 1.0));
    std::vector<double> best;
    for (const double side : {half, -half}) {
      const double pitch = std::remainder(side - std::atan2(from.z(), from.x()), 2.0 * kHalfTurn);
      const double z = std::sin(pitch) * from.x() + std::cos(pitch) * from.z();
      const double roll = std::remainder(std::atan2(z, from.y()) - std::atan2(to.z(), to.y()), 2.0 * kHalfTurn);
      if (best.empty() || std::abs(pitch) < std::abs(best[1])) best = {roll, pitch};
    }
    return best;
  }
  std::vector<InjectedValue> injected(JointType /*type*/) const override {
    return {{"roll", 0.03, 0.0, false}, {"pitch", 0.02, 0.0, false}};
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& /*shape*/,
                     JointType /*type*/) const override {
    if (std::cos(values[0]) * std::cos(values[1]) < 0.0)  // a rotation by more than a right angle is no tilt
      return "a base that is turned by " + digits(180.0 / kHalfTurn * values[0], 3) + " deg about x and " +
             digits(180.0 / kHalfTurn * values[1], 3) + " deg about y: gravity in the file points elsewhere";
    return "a base that leans by " + digits(1e3 * values[0], 3) + " mrad about x and " +
           digits(1e3 * values[1], 3) + " mrad about y";
  }
};

}  // namespace

const Effect& gravity_tilt() {
  static const GravityTilt kEffect;
  return kEffect;
}

}  // namespace veridyn
