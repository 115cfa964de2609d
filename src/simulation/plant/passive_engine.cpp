#include "simulation/plant/passive_engine.hpp"

#include <utility>

#include "math/decompositions.hpp"
#include "veridyn/simulation/joint_torques.hpp"

namespace veridyn {
namespace {

constexpr int kIterations = 6;     // of Newton's method for the equilibrium
constexpr double kNudge = 1e-6;    // [rad], [m] step of its derivatives

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
    look();
  }
  StepStatus step(const VectorRef& tau, double dt) noexcept override {
    tau_.head(q_.size()) = tau;
    const StepStatus status = engine_->step(tau_, dt);
    look();
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
  std::optional<int> failed_joint() const override {
    const std::optional<int> joint = engine_->failed_joint();
    return joint && *joint < joints() ? joint : std::nullopt;
  }
  const std::vector<std::string>& left_out() const override { return engine_->left_out(); }

 private:
  void look() noexcept {
    q_ = engine_->q().head(q_.size());
    dq_ = engine_->dq().head(q_.size());
  }

  // The equilibrium, at which the passive coordinates need no effort.
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

std::unique_ptr<Engine> make_passive_engine(std::unique_ptr<Engine> engine, const Model& whole,
                                            int joints) {
  return std::make_unique<PassiveEngine>(std::move(engine), whole, joints);
}

}  // namespace veridyn
