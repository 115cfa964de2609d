#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "cooperation/experiment.hpp"
#include "veridyn/control/arm_state.hpp"
#include "dvrk/emulator/board_emulator.hpp"
#include "dvrk/emulator/board_server.hpp"
#include "dvrk/emulator/simulated_arm.hpp"

namespace veridyn::dvrk {

/// Emulated boards of several arms whose tips hold one object: each arm's motors drive its part of
/// a scenario's World, and every emulator stands behind a UDP port of its own. One thread serves
/// all of them, in real time.
///
/// An arm none of whose amplifiers is on is held by its brakes.
class JoinedArms {
 public:
  /// @param robots  one for each arm of the scenario, with its coupling (empty: identity).
  /// @throws InvalidInput  as Experiment, SimulatedArm and BoardServer.
  JoinedArms(const Scenario& scenario, const std::vector<RobotConfig>& robots,
             const std::vector<MatrixXd>& couplings, int firmware);

  std::uint16_t port(int arm) const { return servers_[static_cast<size_t>(arm)]->port(); }

  /// Serves until `stop` is true.
  void run(const std::atomic<bool>& stop);

  /// True force of a member as it last was [N]; may be asked from another thread.
  double tension(int member) const { return tension_[static_cast<size_t>(member)].load(); }
  /// From now on this arm's boards do not answer any more. From another thread.
  void silence(int arm) { silent_[static_cast<size_t>(arm)].store(true); }
  /// From now on an amplifier of this arm has a fault. From another thread.
  void break_amplifier(int arm) { broken_[static_cast<size_t>(arm)].store(true); }
  double largest_force() const { return largest_force_.load(); }

 private:
  // What SimulatedArm takes for its engine: torques go in, the world's joints come out.
  class Joint final : public Engine {
   public:
    Joint(World& world, int arm) : world_(world), arm_(arm), tau_(VectorXd::Zero(world.q(arm).size())) {}
    int joints() const override { return static_cast<int>(tau_.size()); }
    void set_state(const VectorRef&, const VectorRef&) override { driven_ = false; }
    StepStatus step(const VectorRef& tau, double) noexcept override {
      tau_ = tau;
      driven_ = true;
      return StepStatus::kOk;
    }
    StepStatus accelerate(const VectorRef&, VectorXd& ddq) noexcept override {
      ddq.setZero();
      return StepStatus::kOk;
    }
    double time() const override { return world_.time(); }
    const VectorXd& q() const override { return world_.q(arm_); }
    const VectorXd& dq() const override { return world_.dq(arm_); }
    int failed_joint() const override { return -1; }
    const std::vector<std::string>& left_out() const override { return none_; }
    bool driven() const { return driven_; }
    const VectorXd& tau() const { return tau_; }

   private:
    World& world_;
    int arm_;
    VectorXd tau_;
    bool driven_ = false;
    std::vector<std::string> none_;
  };

  void advance(double seconds);

  Experiment experiment_;
  std::vector<std::unique_ptr<Joint>> joints_;
  std::vector<veridyn::ArmState> states_;
  std::vector<VectorXd> brakes_, tau_;
  std::vector<std::unique_ptr<BoardEmulator>> emulators_;
  std::vector<std::unique_ptr<SimulatedArm>> loads_;
  std::vector<std::unique_ptr<BoardServer>> servers_;
  std::vector<std::atomic<double>> tension_;
  std::vector<std::atomic<bool>> silent_, broken_;
  std::atomic<double> largest_force_{0.0};
};

}  // namespace veridyn::dvrk
