// Two arms hold a spring between their tips, carry it by 5 cm and keep 5 N in it. The controllers
// have the MODEL of the first arm; the second one carries a load that it does not know.
//
//   example_03_cooperate psm_identified.yaml      what 01_identify writes

#include <iostream>

#include "simulated_robot.hpp"
#include "veridyn/control.hpp"
#include "veridyn/control/cooperative_controller.hpp"
#include "veridyn/simulation/world.hpp"

int main(int argc, char** argv) {
  using namespace veridyn;
  using Eigen::Vector3d;
  const Model model = read_model(argc > 1 ? argv[1] : "psm_identified.yaml");
  const Model first = plausible_model(read_model("psm-3dof"), 1).arm;
  const Model second = inject_effects(first, {parse_hidden_effect("payload:tool:mass=0.1")}).arm;
  const VectorXd start = Vector3d(0.0, 0.05, 0.12);
  const Vector3d base[] = {{0.0, 0.0, 0.0}, {0.12, 0.0, 0.0}};  // [m] in the world

  std::vector<WorldArm> arms;
  arms.push_back({first, make_engine("veridyn", first), identity_pose()});
  arms.push_back({second, make_engine("veridyn", second), identity_pose()});
  arms[1].T_world_base.p = {base[1].x(), base[1].y(), base[1].z()};
  const int tool = first.find_frame("tool");
  Member spring{"spring", {0, tool}, {1, tool}};
  spring.stiffness = 2450.0;  // [N/m]
  spring.damping = 2.0;       // [N s/m]
  spring.rest_length = 0.12;  // [m]
  World world(std::move(arms), {{spring}, {}, {}});
  for (int a = 0; a < 2; ++a) world.set_state(a, start, VectorXd::Zero(3));

  ImpedanceGains stiff;  // a position loop of the tips
  stiff.stiffness.setConstant(400.0);
  stiff.damping.setConstant(40.0);
  std::vector<ArmState> state;
  std::vector<Impedance> loop;
  std::vector<FrictionCompensation> friction;
  std::vector<ModelErrorObserver> error;
  for (int a = 0; a < 2; ++a) {
    state.emplace_back(model, Tip{"tool"});
    loop.emplace_back(model, Tip{"tool"}, stiff);
    friction.emplace_back(model);
    error.emplace_back(3, ModelErrorOptions{10.0, VectorXd::Constant(3, 2.0)});
  }

  CooperativeInput input(2, 1);
  const auto look = [&] {
    for (int a = 0; a < 2; ++a) {
      state[a].update(world.q(a), world.dq(a));
      input.position[a] = base[a] + state[a].tip().position();
      input.velocity[a] = state[a].tip().twist().head<3>();
    }
  };
  look();
  CooperativeOptions options;
  options.R_world_arm.assign(2, Eigen::Matrix3d::Identity());
  ForceLaw law;
  law.gain = 0.004;  // [m/(N s)]: a crossover of 10 rad/s on this spring
  law.stiffness = spring.stiffness;
  options.members = {{0, 1, law, 1.0}};
  CooperativeController control(options, input.position);
  control.set_force(0, 5.0, 1.0);             // newtons, within a second
  control.move(Vector3d(0.0, 0.05, 0.0), 3.0);  // metres

  std::vector<VectorXd> tau(2, VectorXd::Zero(3));
  for (int k = 0; k < 5000; ++k) {
    look();
    const double force = world.member(0).tension;
    input.force[0] = {force, 0.0, k, force};
    const auto& targets = control.update(input);
    for (int a = 0; a < 2; ++a) {
      TaskReference wanted;
      wanted.x.head<3>() = targets[a].position - base[a];
      wanted.dx.head<3>() = targets[a].velocity;
      wanted.ddx.head<3>() = targets[a].acceleration;
      tau[a] = loop[a].update(state[a], wanted, Vector6d::Zero());
      tau[a] += friction[a].update(state[a], loop[a].joint_velocity(), loop[a].joint_error(), 0.001);
      tau[a] += error[a].update(state[a], loop[a].acceleration(), 0.001);
    }
    if (world.step(tau, 0.001) != StepStatus::kOk) return 1;
  }
  const double force = world.member(0).tension;
  std::cout << "force " << force << " N, leader at y = " << input.position[0].y() << " m\n"
            << "the controller " << describe(control.state()) << "\n";
  return std::abs(force - 5.0) < 0.25 ? 0 : 1;
}
