#include "veridyn/simulation/engine.hpp"

#ifdef VERIDYN_WITH_MUJOCO
#include "simulation/plant/mujoco_engine.hpp"
#endif
#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/math/require.hpp"
#include "model/suggestion.hpp"
#include "veridyn/simulation/joint_torques.hpp"
#include "veridyn/simulation/plant.hpp"

namespace veridyn {
namespace {

constexpr int kIterations = 6;     // largest number of Newton steps for the equilibrium
constexpr double kNudge = 1e-6;    // [rad], [m] step of the numerical derivatives

// Presents the first `joints` coordinates of an engine's arm; the others move without motors: they
// are states of effects on the whole arm. set_state() puts these into equilibrium. `whole` is the
// engine's model, with values.
class PassiveEngine final : public Engine {
 public:
  PassiveEngine(std::unique_ptr<Engine> engine, const Model& whole, int joints)
      : engine_(std::move(engine)),
        whole_(whole),
        tau_(VectorXd::Zero(whole.joints())),
        ddq_(tau_),
        q_(VectorXd::Zero(joints)),
        dq_(q_) {}

  int joints() const override { return static_cast<int>(q_.size()); }
  void set_state(const VectorRef& q, const VectorRef& dq) override {
    VectorXd rates = VectorXd::Zero(tau_.size());
    rates.head(joints()) = dq;
    engine_->set_state(in_balance(q), rates);
    update_view();
  }
  StepStatus step(const VectorRef& tau, double dt) noexcept override {
    tau_.head(q_.size()) = tau;
    const StepStatus status = engine_->step(tau_, dt);
    update_view();
    return status;
  }
  StepStatus accelerate(const VectorRef& tau, VectorXd& ddq) noexcept override {
    tau_.head(q_.size()) = tau;
    const StepStatus status = engine_->accelerate(tau_, ddq_);
    ddq = ddq_.head(q_.size());
    return status;
  }
  double time() const override { return engine_->time(); }
  const VectorXd& q() const override { return q_; }
  const VectorXd& dq() const override { return dq_; }
  std::optional<JointIndex> failed_joint() const override {
    const std::optional<JointIndex> joint = engine_->failed_joint();
    return joint && joint->value < joints() ? joint : std::nullopt;
  }
  const std::vector<std::string>& left_out() const override { return engine_->left_out(); }

 private:
  void update_view() noexcept {
    q_ = engine_->q().head(q_.size());
    dq_ = engine_->dq().head(q_.size());
  }

  // The equilibrium at which the passive coordinates need no effort.
  VectorXd in_balance(const VectorRef& q) const {
    const Eigen::Index n = q_.size(), m = tau_.size() - n;
    const VectorXd rest = VectorXd::Zero(tau_.size());
    VectorXd all = rest;
    all.head(n) = q;
    const auto needed = [&] { return VectorXd(joint_torques(whole_, all, rest, rest).tail(m)); };
    for (int k = 0; k < kIterations; ++k) {
      const VectorXd effort = needed();
      MatrixXd slope(m, m);
      for (Eigen::Index j = 0; j < m; ++j) {
        all[n + j] += kNudge;
        slope.col(j) = (needed() - effort) / kNudge;
        all[n + j] -= kNudge;
      }
      all.tail(m) -= slope.partialPivLu().solve(effort);
    }
    return all;
  }

  std::unique_ptr<Engine> engine_;
  Model whole_;
  VectorXd tau_, ddq_, q_, dq_;
};

}  // namespace

const char* describe(StepStatus status) {
  static constexpr const char* kNames[] = {
      "moves", "has a torque, position or velocity that is not finite", "stands where the mass matrix has no inverse",
      "moves faster than the smallest substep can follow", "is more than ten times its range off its set point"};
  return kNames[static_cast<int>(status)];
}

std::vector<std::string> engine_names() {
#ifdef VERIDYN_WITH_MUJOCO
  return {"veridyn", "mujoco"};
#else
  return {"veridyn"};
#endif
}

std::unique_ptr<Engine> make_engine(const std::string& name, const Model& arm) {
  if (!arm.arm_effects().empty()) {
    const Model whole = with_arm_states(arm);
    if (whole.joints() != arm.joints())
      return std::make_unique<PassiveEngine>(make_engine(name, whole), whole, arm.joints());
  }
  if (name == "veridyn") return std::make_unique<Plant>(arm);
#ifdef VERIDYN_WITH_MUJOCO
  if (name == "mujoco") return make_mujoco_engine(arm);
#endif
  require(name != "mujoco", "engine mujoco: this veridyn was built without it (libmujoco-dev).");
  throw InvalidInput(text("found the engine '", name, "'", did_you_mean(name, engine_names()),
                          ", expected one of: ", listed(engine_names()), "."));
}

}  // namespace veridyn
