#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <vector>

#include "cooperation/experiment.hpp"
#include "veridyn/emulator/stepped_link.hpp"
#include "veridyn/control/arm_state.hpp"
#include "veridyn/dvrk/run/arm_session.hpp"
#include "dvrk/cooperation/joined_boards.hpp"
#include "veridyn/emulator/board_emulator.hpp"
#include "veridyn/emulator/board_server.hpp"
#include "veridyn/emulator/simulated_arm.hpp"

namespace veridyn::dvrk {

/// Emulated boards of several arms whose tips hold one object: each arm's motors drive its part of a
/// scenario's World, and every emulator has its own UDP port. Either one thread serves all of them in real
/// time (run()), or the caller's loop advances their clock (SteppedClock).
///
/// Before its first power-up an arm is held. Afterwards brakes hold it while no amplifier is on, if its
/// configuration has brakes; other arms fall, down to the ends of their joints.
class JoinedArms final : public JoinedBoards, public SteppedClock {
 public:
  /// @param arms  one for each arm of the scenario.
  /// @throws InvalidInput  as Experiment, SimulatedArm and BoardServer.
  JoinedArms(const Scenario& scenario, const std::vector<CooperatingArm>& arms,
             const BoardCooperationOptions& options);

  std::unique_ptr<DatagramLink> link(int arm) override;
  void run(const std::atomic<bool>& stop) override;

  double now() const override { return now_; }
  void serve() override;
  void pass(double seconds) override;

  double tension(int member) const override { return tension_[member].load(); }
  double rate(int member) const override { return rate_[member].load(); }
  double largest_force() const override { return largest_force_.load(); }
  double true_wall_force(int wall, int channel = 0) const override { return push_[3 * wall + channel].load(); }
  void attach_hand(const Hand& hand, const Eigen::Vector3d& place) override {
    hand_ = hand;
    move_hand_to(place);
    led_.store(true);
  }
  void move_hand_to(const Eigen::Vector3d& place) override {
    for (int i = 0; i < 3; ++i) place_[i].store(place[i]);
  }
  Eigen::Vector3d hand_force() const override {
    return {hand_force_[0].load(), hand_force_[1].load(), hand_force_[2].load()};
  }
  void watch(std::function<void(const EmulatedInstant&)> watcher) override;
  void activate_fault(const EmulatedFault& fault) noexcept override {
    if (fault.arm >= 0) faults_[fault.arm].fetch_or(bit_of(fault.kind));
  }

 private:
  // Engine of a SimulatedArm that exchanges torques and joint positions with the world. Between two
  // steps of the world, at any datagram, joints are interpolated linearly: a jump would be a
  // velocity for encoders that time their edges.
  class Joint final : public Engine {
   public:
    Joint(World& world, int arm)
        : world_(world),
          arm_(arm),
          tau_(VectorXd::Zero(world.q(arm).size())),
          from_(world.q(arm)),
          q_(from_) {}
    int joints() const override { return static_cast<int>(tau_.size()); }
    void set_state(const VectorRef&, const VectorRef&) override { driven_ = false; }
    StepStatus step(const VectorRef& tau, double seconds) noexcept override {
      tau_ = tau;
      driven_ = true;
      elapsed_ += seconds;
      const double share = duration_ > 0.0 ? std::min(1.0, elapsed_ / duration_) : 1.0;
      q_ = from_ + share * (world_.q(arm_) - from_);
      return StepStatus::kOk;
    }
    StepStatus accelerate(const VectorRef&, VectorXd& ddq) noexcept override {
      ddq.setZero();
      return StepStatus::kOk;
    }
    double time() const override { return world_.time(); }
    const VectorXd& q() const override { return q_; }
    const VectorXd& dq() const override { return world_.dq(arm_); }
    std::optional<JointIndex> failed_joint() const override { return std::nullopt; }
    const std::vector<std::string>& left_out() const override { return none_; }
    bool driven() const { return driven_; }  ///< false: the arm is held by its brakes
    /// Called after the world has made a step of `seconds`.
    void moved(double seconds) noexcept {
      if (elapsed_ > 0.0) {
        from_ = q_;
        elapsed_ = duration_ = 0.0;
      }
      duration_ = std::min(duration_ + seconds, kLongestWay);
    }
    const VectorXd& tau() const { return tau_; }

   private:
    static constexpr double kLongestWay = 0.02;  // [s] longest interval of interpolation, after a pause of the machine
    World& world_;
    int arm_;
    VectorXd tau_, from_, q_;
    double elapsed_ = 0.0, duration_ = 0.0;  // [s] since `from_`
    bool driven_ = false;
    std::vector<std::string> none_;
  };

  void advance(double seconds);  ///< one step of the world, with motors, brakes and hand
  void apply_faults();  ///< activates requested faults in the emulators, once each
  void show();  ///< calls watcher_ with the present state
  bool drives_current(std::size_t arm);  ///< true if one of its amplifiers is on
  void move_hand();  ///< adds the torques of the hand at its present place to tau_
  bool has(std::size_t arm, EmulatedFault::Kind kind) const {
    return (faults_[arm].load() & bit_of(kind)) != 0;
  }
  static unsigned bit_of(EmulatedFault::Kind kind) { return 1U << static_cast<unsigned>(kind); }

  bool stepped_;
  Experiment experiment_;
  std::vector<std::unique_ptr<Joint>> joints_;
  std::vector<veridyn::ArmState> states_;
  std::vector<VectorXd> brakes_, tau_;
  std::vector<std::unique_ptr<BoardEmulator>> emulators_;
  std::vector<std::unique_ptr<SimulatedArm>> loads_;
  std::vector<std::unique_ptr<BoardServer>> servers_;
  std::vector<std::atomic<double>> tension_, rate_, push_;
  Hand hand_;
  std::atomic<bool> led_{false};
  std::array<std::atomic<double>, 3> place_{}, hand_force_{};
  std::vector<Eigen::Matrix3d> R_world_base_;
  std::vector<Attachment> tips_;
  std::vector<std::atomic<unsigned>> faults_;
  std::vector<unsigned> applied_;
  std::vector<Socket> sockets_;      // connector of each arm's first joint
  std::vector<std::int64_t> slips_;  // [counts] jump of its encoder with kJump
  std::atomic<double> largest_force_{0.0};
  double now_ = 0.0, reached_ = 0.0;  // [s] stepped clock, and the time to which the world is simulated
  std::function<void(const EmulatedInstant&)> watcher_;
  EmulatedInstant instant_;
};

/// JoinedArms, in the form of BoardCooperationOptions::emulate.
std::unique_ptr<JoinedBoards> emulate_boards(const Scenario& scenario, const std::vector<CooperatingArm>& arms,
                                             const BoardCooperationOptions& options);

}  // namespace veridyn::dvrk
