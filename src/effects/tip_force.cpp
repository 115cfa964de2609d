#include <cmath>

#include "math/digits.hpp"
#include "registry.hpp"

namespace veridyn {
namespace {

/// The frame that the most joints move; if there are several, the last one.
size_t tip_of(const Model& arm) {
  size_t tip = 0;
  int most = -1;
  std::vector<int> joints;
  for (size_t k = 0; k < arm.frames().size(); ++k) {
    const Frame& frame = arm.frames()[k];
    const int before = frame.parent ? joints[frame.parent->value] : 0;
    joints.push_back(before + (frame.type == JointType::kFixed ? 0 : 1));
    if (joints.back() < most) continue;
    most = joints.back();
    tip = k;
  }
  return tip;
}

/// A force of constant direction and size at the end of the arm, as of a hose or a balancer that hangs from
/// the ceiling,
///
///   tau = -J(q)^T (x, y, z),   in the base's coordinates
///
/// computed as the weight of a point mass of 1 kg under a gravity along each axis. Forward simulation omits
/// it, with a remark.
class TipForce final : public ArmEffect {
 public:
  std::string name() const override { return "tip_force"; }
  std::vector<EffectParameter> parameters() const override {
    return {{"x", "N", "N"}, {"y", "N", "N"}, {"z", "N", "N"}};
  }
  EffectTraits traits(const ShapeValues& shape) const override {
    EffectTraits t = ArmEffect::traits(shape);
    t.forward_simulable = false;
    t.not_simulable_because = "it acts at a frame and along no axis";
    t.holds_at_rest = true;
    return t;
  }
  // Along few paths springs, cables and wrong zeros can have the same torque.
  bool imitates_others() const override { return true; }
  std::vector<MatrixXd> columns(const ChannelMotion& motion, std::optional<JointIndex> /*joint*/) const override {
    ModelDescription d = motion.arm.description();
    d.effects.clear();
    d.arm_effects.clear();
    for (Frame& frame : d.frames) frame.body.reset();
    d.frames[tip_of(motion.arm)].body = Body{};
    const VectorXd point = inertial_parameters(1.0, Eigen::Vector3d::Zero(), Eigen::Matrix<double, 6, 1>::Zero());
    const MatrixXd rest = MatrixXd::Zero(motion.q.rows(), motion.q.cols());
    std::vector<MatrixXd> out(3);
    for (int k = 0; k < 3; ++k) {
      d.gravity = Eigen::Vector3d::Unit(k);
      TorqueRegressor(Model(d)).torques(motion.q, rest, rest, point, out[k]);
    }
    return out;
  }
  void change(ModelDescription& arm, const std::vector<double>& values) const override {
    EffectTerm& own = term_of(arm);
    const std::vector<EffectParameter> all = parameters();
    for (size_t k = 0; k < all.size(); ++k) own.values[all[k].name] += values[k];
  }
  std::vector<InjectedValue> injected(JointType /*type*/) const override {
    return {{"x", 0.0, 0.0, false}, {"y", 0.0, 0.0, false}, {"z", 5.0, 0.0, false}};
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& /*shape*/,
                     JointType /*type*/) const override {
    return "a force at its end of " + digits(std::hypot(values[0], values[1], values[2]), 3) + " N, along (" +
           digits(values[0], 3) + ", " + digits(values[1], 3) + ", " + digits(values[2], 3) + ") of the base";
  }
};

}  // namespace

const Effect& tip_force() {
  static const TipForce kEffect;
  return kEffect;
}

}  // namespace veridyn
