#include <algorithm>
#include <cmath>
#include <utility>

#include "math/digits.hpp"
#include "math/zero_phase_filter.hpp"
#include "registry.hpp"

namespace veridyn {
namespace {

constexpr double kSmallTurn = 1e-4;       // [rad] step of the numerical derivative
// [s] damping divided by stiffness, which prevents oscillation of the base.
constexpr double kRelaxation = 0.005;
constexpr const char* kTurns[] = {"base about x", "base about y"};

/// The arm on a base that turns about x and then about y: two coordinates follow those of the arm, with
/// frames below all others.
ModelDescription on_free_base(ModelDescription arm) {
  const auto n = static_cast<Eigen::Index>(arm.coordinates.size());
  const auto widen = [n](VectorXd& c) {
    c.conservativeResize(n + 2);
    c.tail(2).setZero();
  };
  std::vector<Frame> frames;
  for (int k = 0; k < 2; ++k) {
    Coordinate turn;
    turn.name = kTurns[k];
    turn.limits = {-1.0, 1.0, 1e3, 1e6, 1e9};
    arm.coordinates.push_back(turn);
    Frame frame;
    frame.name = kTurns[k];
    if (k > 0) frame.parent = FrameIndex{k - 1};
    frame.type = JointType::kRevolute;
    frame.variable.coefficients = VectorXd::Unit(n + 2, n + k);
    // Joints turn about z; these rotations align z with x and with y.
    frame.A.R = k == 0 ? rotation_y(M_PI_2) : rotation_x(-M_PI_2);
    frame.B.R = transpose(frame.A.R);
    frames.push_back(frame);
  }
  for (Frame& frame : arm.frames) {
    frame.parent = FrameIndex{frame.parent ? frame.parent->value + 2 : 1};
    widen(frame.variable.coefficients);
    frames.push_back(std::move(frame));
  }
  arm.frames = std::move(frames);
  for (EffectTerm& term : arm.effects) {
    widen(term.axis.coefficients);
    if (term.from) widen(term.from->coefficients);
  }
  arm.arm_effects.clear();
  arm.identified.reset();
  return arm;
}

// The arm's n columns, followed by the two of the base.
MatrixXd stacked_turns(const MatrixXd& of_joints, const MatrixXd& of_base) {
  MatrixXd out(of_joints.rows(), of_joints.cols() + 2);
  out << of_joints, of_base;
  return out;
}

/// A compliant base rotates under the moment that the arm exerts on it,
///
///   x = -compliance * tau_base(q, dq, ddq),       about x, about y [rad]
///
/// and the arm's gravity is rotated by x, while the base's acceleration acts on its links. This holds to first
/// order and without the base's own inertia, that is, below the resonance of arm and base. A simulation moves
/// the base as two joints with springs.
class BaseCompliance final : public ArmEffect {
 public:
  std::string name() const override { return "base_compliance"; }
  std::vector<EffectParameter> parameters() const override {
    constexpr double kLargest = 0.01;  // [rad/(N m)] more compliant than any table
    return {{"about_x", "rad/(N m)", "rad/(N m)", ParameterSign::kNonnegative, kLargest, kLargest},
            {"about_y", "rad/(N m)", "rad/(N m)", ParameterSign::kNonnegative, kLargest, kLargest}};
  }

  // In five real recordings of a PSM a diagnosis found this effect in all, and it increased the held-out error
  // of three.
  bool imitates_others() const override { return true; }

  std::vector<MatrixXd> columns(const ChannelMotion& motion, std::optional<JointIndex> /*joint*/) const override {
    const TorqueRegressor bodies(Model(on_free_base(motion.arm.description())));
    const Eigen::Index rows = motion.q.rows(), n = motion.q.cols();
    const MatrixXd none = MatrixXd::Zero(rows, 2);
    MatrixXd tau;
    bodies.torques(stacked_turns(motion.q, none), stacked_turns(motion.dq, none),
                   stacked_turns(motion.ddq, none), motion.phi, tau);
    std::vector<MatrixXd> out;
    for (int k = 0; k < 2; ++k) {
      MatrixXd x = none;  // column per unit of compliance
      x.col(k) = -tau.col(n + k);
      const MatrixXd dx = differentiate(x, motion.dt), ddx = differentiate(dx, motion.dt);
      const double step = kSmallTurn / std::max(1e-9, x.cwiseAbs().maxCoeff());
      MatrixXd above, below;
      bodies.torques(stacked_turns(motion.q, step * x), stacked_turns(motion.dq, step * dx),
                     stacked_turns(motion.ddq, step * ddx), motion.phi, above);
      bodies.torques(stacked_turns(motion.q, -step * x), stacked_turns(motion.dq, -step * dx),
                     stacked_turns(motion.ddq, -step * ddx), motion.phi, below);
      out.push_back((above - below).leftCols(n) / (2.0 * step));
    }
    return out;
  }

  void change(ModelDescription& arm, const std::vector<double>& values) const override {
    EffectTerm& own = term_of(arm);
    const std::vector<EffectParameter> all = parameters();
    for (size_t k = 0; k < all.size(); ++k)  // a compliance is not below zero
      own.values[all[k].name] = std::max(0.0, own.values[all[k].name] + values[k]);
  }

  ModelDescription with_states(const ModelDescription& arm,
                               const std::vector<double>& values) const override {
    ModelDescription out = on_free_base(arm);
    const auto n = static_cast<Eigen::Index>(arm.coordinates.size());
    for (int k = 0; k < 2; ++k) {
      const double stiffness = 1.0 / std::max(values[k], kRigid);
      EffectTerm spring, damper;
      spring.effect = joint_spring().name();
      damper.effect = viscous_friction().name();
      spring.axis.coefficients = damper.axis.coefficients = VectorXd::Unit(n + 2, n + k);
      spring.values[joint_spring().parameters().front().name] = stiffness;
      damper.values[viscous_friction().parameters().front().name] = kRelaxation * stiffness;
      for (const EffectShape& s : joint_spring().shapes()) spring.values[s.name] = 0.0;
      out.effects.push_back(spring);
      out.effects.push_back(damper);
    }
    return out;
  }

  std::vector<InjectedValue> injected(JointType /*type*/) const override {
    return {{"about_x", 1e-3, 0.0, true}, {"about_y", 1e-3, 0.0, true}};
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& /*shape*/,
                     JointType /*type*/) const override {
    return "a base that gives way by " + digits(1e3 * values[0], 3) + " mrad per N m about x and " +
           digits(1e3 * values[1], 3) + " about y";
  }

 private:
  static constexpr double kRigid = 1e-9;  // [rad/(N m)] lower bound in a simulation
};

}  // namespace

const Effect& base_compliance() {
  static const BaseCompliance kEffect;
  return kEffect;
}

}  // namespace veridyn
