#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "cooperation/arm_loop.hpp"
#include "veridyn/control/object_impedance.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/math/eigen_pose.hpp"
#include "veridyn/simulation/plant.hpp"
#include "veridyn/simulation/plausible_model.hpp"
#include "veridyn/simulation/world.hpp"

// Three arms carry a body of half a kilogram by multiple impedance control.

namespace veridyn {
namespace {

using Eigen::Vector3d;

constexpr double kPeriod = 1e-3;

struct Carried {
  double largest_error = 0.0;  // [m] of the body from its path, after it was lifted
  double sag = 0.0;            // [m] at the end
  double way = 0.0;            // [m] that the body went
  bool sound = true;
};

class Carrying {
 public:
  explicit Carrying(double known_mass) : known_mass_(known_mass) {
    place({0, 0, 0}, 0.0);
    place({1.2228, 0, 0}, M_PI);
    place({0.6114, 0.6558, 0}, -M_PI / 2);
    HeldBody body;
    body.mass = 0.5;
    body.inertia = {8e-4, 8e-4, 1.2e-3};
    for (ArmLoop& loop : loops_) body.position += loop.position() / 3.0;
    for (size_t k = 0; k < 3; ++k) {
      HeldBody::Grasp grasp;
      grasp.held_by = tips_[k];
      grasp.point_body = loops_[k].position() - body.position;
      grasp.stiffness = 5000.0;
      grasp.damping = 5.0;
      body.grasps.push_back(grasp);
    }
    centre_ = body.position;
    object_ = std::make_unique<ObjectImpedance>(options(body));
    world_ = std::make_unique<World>(std::move(arms_), WorldObjects{{}, {}, {body}});
    for (int k = 0; k < 3; ++k) world_->set_state(k, start_, VectorXd::Zero(3));
    ObjectMotion here;
    here.position = centre_;
    object_->reset(here);
  }

  // Two seconds to take up the weight, two to move by 3 cm, one to rest.
  Carried run() {
    Carried out;
    const Vector3d way(0.02, 0.02, 0.01);
    std::vector<Vector3d> p(3), v(3);
    std::vector<VectorXd> tau(3, VectorXd::Zero(3));
    for (int step = 0; step < 5000; ++step) {
      const double u = std::min(1.0, std::max(0.0, (kPeriod * step - 2.0) / 2.0));
      ObjectMotion wanted;
      wanted.position = centre_ + way * (u * u * u * (10.0 - 15.0 * u + 6.0 * u * u));
      wanted.velocity = way * (30.0 * u * u * (1.0 - u) * (1.0 - u) / 2.0);
      wanted.acceleration = way * (60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / 4.0);
      for (size_t k = 0; k < 3; ++k) {
        loops_[k].measure(world_->q(static_cast<int>(k)));
        p[k] = loops_[k].position();
        v[k] = loops_[k].velocity();
      }
      std::vector<TipTarget> targets =
          object_->update(object_->estimate(p, v), wanted, Vector3d::Zero(), Vector3d::Zero());
      for (size_t k = 0; k < 3; ++k) {
        targets[k].position += targets[k].force / ScenarioControl().stiffness.x();
        tau[k] = loops_[k].torque(targets[k], -world_->grasp_force(0, static_cast<int>(k)));
      }
      if (world_->step(tau, kPeriod) != StepStatus::kOk) {
        out.sound = false;
        return out;
      }
      const Vector3d off = world_->body(0).position - wanted.position;
      if (step > 2000) out.largest_error = std::max(out.largest_error, off.norm());
      out.sag = -off.z();
    }
    out.way = (world_->body(0).position - centre_).norm();
    return out;
  }

 private:
  void place(const Vector3d& position, double turn) {
    const Model arm = plausible_model(read_model("psm-3dof"), 1).arm;
    start_ = Vector3d(0, -0.5, 0.15);
    ArmLoopSetup setup{arm};
    setup.tip = {"tool"};
    setup.R_world_base = Eigen::AngleAxisd(turn, Vector3d::UnitZ()).toRotationMatrix();
    setup.p_world_base = position;
    setup.encoder_step = Vector3d(7.72e-6, 7.72e-6, 1.29e-6);
    setup.start = start_;
    loops_.emplace_back(setup);
    tips_.push_back({static_cast<int>(tips_.size()), *arm.find_frame("tool"), Vector3d::Zero()});
    arms_.push_back({arm,
                     std::make_unique<Plant>(arm),
                     Eigen::Translation3d(position) * Eigen::Isometry3d(eigen(rotation_z(turn)))});
  }

  ObjectImpedanceOptions options(const HeldBody& body) const {
    ObjectImpedanceOptions o;
    o.mass = known_mass_;
    o.inertia = body.inertia * (known_mass_ / body.mass);
    for (const HeldBody::Grasp& g : body.grasps) o.grasps.push_back(g.point_body);
    o.wanted_mass = 0.5;
    o.damping = 30.0;
    o.stiffness = 400.0;
    o.wanted_inertia = 2e-3;
    o.angular_damping = 0.05;
    o.angular_stiffness = 0.5;
    return o;
  }

  double known_mass_;
  VectorXd start_;
  std::vector<ArmLoop> loops_;
  std::vector<Attachment> tips_;
  std::vector<WorldArm> arms_;
  Vector3d centre_{Vector3d::Zero()};
  std::unique_ptr<ObjectImpedance> object_;
  std::unique_ptr<World> world_;
};

TEST(HeldBody, AHeldObjectOfKnownInertiaDeviatesLessThanOneMillimetre) {
  const Carried known = Carrying(0.5).run();
  const Carried unknown = Carrying(0.0).run();
  ASSERT_TRUE(known.sound && unknown.sound);
  EXPECT_NEAR(known.way, 0.03, 1e-3);
  EXPECT_LT(known.largest_error, 1e-3);
  // Without it the weight hangs in the hands' springs alone: m g / (3 K), 5.4 mm.
  EXPECT_NEAR(unknown.sag, 0.5 * 9.81 / (3.0 * 300.0), 1e-3);
  EXPECT_GT(unknown.largest_error, 4.0 * known.largest_error);
}

// A mass that is known to within a tenth leaves a tenth of the sag.
TEST(HeldBody, AMassErrorOfATenthCausesADeviationBelowTwoMillimetres) {
  const Carried off = Carrying(0.45).run();
  ASSERT_TRUE(off.sound);
  EXPECT_LT(off.largest_error, 1.5e-3);
}

}  // namespace
}  // namespace veridyn
