#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "dvrk/planar_arm.hpp"
#include "dvrk/rig.hpp"
#include "veridyn/control/cooperative_controller.hpp"
#include "veridyn/control/friction_compensation.hpp"
#include "veridyn/control/impedance.hpp"
#include "veridyn/control/model_error_observer.hpp"
#include "support/malloc_count.hpp"

// Two arms on boards of their own hold a spring between them: CooperativeController on two
// sessions, with a clock that the test moves.

namespace veridyn::dvrk {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPeriod = 1.0 / 1500.0;
constexpr double kSpring = 2450.0;  // [N/m]

// Tip of data/robots/planar-2r.yaml in closed form: rods of 0.5 m and 0.4 m.
Vector2d tip_of(const VectorXd& q) {
  const double both = q[0] + q[1];
  return {0.5 * std::cos(q[0]) + 0.4 * std::cos(both), 0.5 * std::sin(q[0]) + 0.4 * std::sin(both)};
}
Eigen::Matrix2d jacobian_of(const VectorXd& q) {
  const double both = q[0] + q[1];
  Eigen::Matrix2d J;
  J << -0.5 * std::sin(q[0]) - 0.4 * std::sin(both), -0.4 * std::sin(both),
      0.5 * std::cos(q[0]) + 0.4 * std::cos(both), 0.4 * std::cos(both);
  return J;
}

// A plant whose tip hangs on a spring; its base stands at `base` in the world.
class SprungArm final : public Engine {
 public:
  SprungArm(const Model& model, const Vector2d& base) : plant_(model), base_(base) {}

  Vector2d tip() const { return base_ + tip_of(plant_.q()); }
  void hang(const SprungArm& other, double length) {
    other_ = &other;
    length_ = length;
  }
  // [N] pulling positive.
  double tension() const { return kSpring * ((other_->tip() - tip()).norm() - length_); }
  // Force of the spring on the tip.
  Vector2d pull() const { return tension() * (other_->tip() - tip()).normalized(); }

  int joints() const override { return 2; }
  void set_state(const VectorRef& q, const VectorRef& dq) override { plant_.set_state(q, dq); }
  StepStatus step(const VectorRef& tau, double dt) noexcept override {
    all_ = tau;
    if (other_ != nullptr) all_ += jacobian_of(plant_.q()).transpose() * pull();
    return plant_.step(all_, dt);
  }
  StepStatus accelerate(const VectorRef& tau, VectorXd& ddq) noexcept override {
    return plant_.accelerate(tau, ddq);
  }
  double time() const override { return plant_.time(); }
  const VectorXd& q() const override { return plant_.q(); }
  const VectorXd& dq() const override { return plant_.dq(); }
  std::optional<JointIndex> failed_joint() const override { return plant_.failed_joint(); }
  const std::vector<std::string>& left_out() const override { return plant_.left_out(); }

 private:
  Plant plant_;
  Vector2d base_;
  const SprungArm* other_ = nullptr;
  double length_ = 0.0;
  VectorXd all_{VectorXd::Zero(2)};
};

ImpedanceGains tip_gains() {
  ImpedanceGains gains;
  gains.mass.setConstant(2.0);
  gains.damping.setConstant(126.0);
  gains.stiffness.setConstant(2000.0);
  return gains;
}

// One arm: boards, session, and the impedance of its tip.
struct Side {
  Side(const Model& model, const Vector2d& where, const Vector2d& start)
      : base(where.x(), where.y(), 0.0),
        real(model, where),
        emulator({PlanarArm::setup()}),
        link(emulator),
        load(real, planar_config(), MatrixXd(), {6}, start),
        session(link, planar_config()),
        state(model, {"fore"}),
        control(model, {"fore"}, tip_gains()),
        friction(model),
        error(2, {10.0, VectorXd::Constant(2, 3.0)}) {
    emulator.attach(&load);
    session.start();
  }

  bool read() noexcept {
    if (!session.update()) return false;
    state.update(session.state().q, session.state().dq);
    return true;
  }
  Vector3d tip() const { return base + state.tip().position(); }

  void command(const TipTarget& target, const Vector3d& exerted) noexcept {
    wanted.x.head<3>() = target.position - base;
    wanted.dx.head<3>() = target.velocity;
    wanted.ddx.head<3>() = target.acceleration;
    wrench.head<3>() = exerted;
    tau = control.update(state, wanted, wrench);
    tau += friction.update(state, control.joint_velocity(), control.joint_error(), kPeriod);
    tau += error.update(state, control.acceleration(), kPeriod);
    session.set_torques(tau);
  }

  bool currents_flow() {
    return emulator.board(0).drive(0).bits != 0.0 || emulator.board(0).drive(1).bits != 0.0;
  }

  Vector3d base;
  SprungArm real;
  BoardEmulator emulator;
  EmulatedLink link;
  SimulatedArm load;
  ArmSession session;
  veridyn::ArmState state;
  Impedance control;
  FrictionCompensation friction;
  ModelErrorObserver error;
  TaskReference wanted;
  Vector6d wrench{Vector6d::Zero()};
  VectorXd tau{VectorXd::Zero(2)};
};

class TwoArms : public testing::Test {
 protected:
  TwoArms()
      : model_(read_model("planar-2r")),
        left_(model_, {0.0, 0.0}, {1.2, -1.4}),
        right_(model_, {1.3, 0.0}, {M_PI - 1.2, 1.4}),
        input_(2, 1) {
    const double length = (right_.real.tip() - left_.real.tip()).norm();
    left_.real.hang(right_.real, length);
    right_.real.hang(left_.real, length);
    sides_ = {&left_, &right_};
  }

  template <typename Each>
  void cycles(double seconds, Each&& each) {
    for (int k = 0; k < static_cast<int>(seconds / kPeriod); ++k) {
      bool valid = true;
      for (Side* side : sides_) {
        side->link.wait(kPeriod);
        valid = side->read() && valid;
      }
      if (valid) each();
      for (Side* side : sides_) side->session.commit();
    }
  }

  bool power_up() {
    cycles(0.1, [] {});
    for (Side* side : sides_) {
      if (side->session.power_on() != nullptr) return false;
    }
    cycles(0.5, [&] {
      for (Side* side : sides_) side->session.set_torques(side->state.bias());
    });
    return left_.session.ready() && right_.session.ready();
  }

  // The sensor in the spring is exact; `control` gives targets, in the world.
  void control(CooperativeController& both) noexcept {
    for (size_t i = 0; i < 2; ++i) {
      input_.position[i] = sides_[i]->tip();
      input_.velocity[i] = sides_[i]->state.tip().twist().head<3>();
      input_.healthy[i] = sides_[i]->session.ready() ? 1 : 0;
    }
    input_.force[0] = {left_.real.tension(), 0.0, ++sample_};
    const std::vector<TipTarget>& targets = both.update(input_);
    for (size_t i = 0; i < 2; ++i) {
      const Vector2d pull = sides_[i]->real.pull();
      sides_[i]->command(targets[i], {-pull.x(), -pull.y(), 0.0});
    }
  }

  CooperativeController controller() {
    CooperativeOptions options;
    options.R_world_arm.assign(2, Eigen::Matrix3d::Identity());
    options.period = kPeriod;
    ForceLaw law;
    law.gain = 0.004;
    law.stiffness = kSpring;
    options.members = {{0, 1, law, 1.0}};
    return CooperativeController(options, {left_.tip(), right_.tip()});
  }

  Model model_;
  Side left_, right_;
  std::array<Side*, 2> sides_;
  CooperativeInput input_;
  long sample_ = 0;
};

TEST_F(TwoArms, KeepTheForceWhileMovingASpring) {
  ASSERT_TRUE(power_up());
  CooperativeController both = controller();
  const Vector3d start = left_.tip();
  ASSERT_TRUE(both.set_force(0, 5.0, 1.0));
  cycles(3.0, [&] { control(both); });
  EXPECT_NEAR(left_.real.tension(), 5.0, 0.25);
  ASSERT_TRUE(both.move({0.03, 0.04, 0.0}, 3.0));
  double worst = 0.0;
  long taken = malloc_count();
  cycles(4.0, [&] {
    control(both);
    worst = std::max(worst, std::abs(left_.real.tension() - 5.0));
  });
  taken = malloc_count() - taken;
  EXPECT_STREQ(describe(both.state()), describe(CooperativeState::kTracking));
  EXPECT_LT(worst, 1.0);
  EXPECT_NEAR(left_.real.tension(), 5.0, 0.25);
  EXPECT_LT((left_.tip() - start - Vector3d(0.03, 0.04, 0.0)).norm(), 0.005);
  EXPECT_EQ(taken, 0);  // both counts are 0 if allocations are not counted
}

// After one arm's emergency stop that arm gets no current, and the controller holds the other.
TEST_F(TwoArms, AnEmergencyStopOfOneArmEndsTheTaskOfBoth) {
  ASSERT_TRUE(power_up());
  CooperativeController both = controller();
  ASSERT_TRUE(both.set_force(0, 5.0, 1.0));
  cycles(2.0, [&] { control(both); });
  EXPECT_TRUE(right_.currents_flow());
  right_.emulator.chain.emergency_stop = true;
  cycles(0.2, [&] { control(both); });
  EXPECT_EQ(both.state(), CooperativeState::kArmLost);
  EXPECT_FALSE(right_.currents_flow());
  EXPECT_TRUE(left_.session.ready());
  left_.session.power_off();
  cycles(0.1, [] {});
  EXPECT_FALSE(left_.currents_flow());
}

}  // namespace
}  // namespace veridyn::dvrk
