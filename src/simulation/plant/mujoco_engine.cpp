#include "simulation/plant/mujoco_engine.hpp"

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <iomanip>

#include "math/eigen_pose.hpp"
#include "dynamics/principal_body.hpp"
#include "simulation/plant/plant_forces.hpp"
#include "simulation/plant/small_cholesky.hpp"
#include "veridyn/kinematics/tree.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/math/text_stream.hpp"
#include "veridyn/simulation/plant.hpp"

namespace veridyn {
namespace {

constexpr double kLongestStep = 1e-3;   // [s] longest step
constexpr double kFrictionStep = 2e-5;  // [s] step near rest, where the sign of friction is steep
constexpr double kClear = 2.0;          // ratio to the rest speed above which friction is smooth
constexpr double kStableShare = 2.0;    // largest decay rate times step; Runge-Kutta is stable up to 2.78
constexpr double kNoMass = 1e-10;       // [kg], [kg m^2] smallest that MuJoCo accepts for a moving body

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Text of a pose: "pos='x y z' quat='w x y z'".
std::string pose_text(const Eigen::Vector3d& p, const Eigen::Matrix3d& R) {
  const Eigen::Quaterniond q(R);
  TextStream out;
  out << std::setprecision(17) << " pos='" << p.x() << ' ' << p.y() << ' ' << p.z() << "' quat='"
      << q.w() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z() << '\'';
  return out.str();
}

// Text of mass, centre and principal inertia in the joint's frame, since MuJoCo's body frame moves with the
// joint and does not include B.
std::string inertial_text(const double* phi, const Posed& B) {
  TextStream out;
  out << std::setprecision(17) << "<inertial";
  if (phi == nullptr || phi[0] <= kNoMass) {
    out << " pos='0 0 0' mass='" << kNoMass << "' diaginertia='" << kNoMass << ' ' << kNoMass << ' '
        << kNoMass << "'/>\n";
    return out.str();
  }
  const PrincipalBody body = principal_body(phi, B);
  out << pose_text(body.com, body.axes) << " mass='" << phi[0] << "' diaginertia='" << body.moments.x()
      << ' ' << body.moments.y() << ' ' << body.moments.z() << "'/>\n";
  return out.str();
}

std::string joint_name(int link) {
  return "joint" + std::to_string(link);
}

// Writes the child links of `parent`; `before` is the parent's B, which MuJoCo's body does not include.
void write_children(const Tree& tree, const VectorXd& phi, int parent, const Posed& before,
                    std::ostream& out) {
  for (int k = 0; k < static_cast<int>(tree.links.size()); ++k) {
    const Link& link = tree.links[k];
    if (link.parent != parent) continue;
    const bool turns = link.type == JointType::kRevolute;
    Posed at_zero = identity_pose();
    if (turns) at_zero.R = rotation_z(link.offset);
    if (link.type == JointType::kPrismatic) at_zero.p.z = link.offset;
    const Posed T = before * link.A * at_zero;
    out << "<body" << pose_text(eigen(T.p), eigen(T.R)) << ">\n";
    if (link.type != JointType::kFixed) {
      out << "<joint name='" << joint_name(k) << "' type='" << (turns ? "hinge" : "slide")
          << "' axis='0 0 1'/>\n";
    }
    out << inertial_text(link.body >= 0 ? phi.data() + kBodyParameters * link.body : nullptr,
                         link.B);
    write_children(tree, phi, k, link.B, out);
    out << "</body>\n";
  }
}

std::string mjcf_of(const Tree& tree, const VectorXd& phi) {
  TextStream out;
  out << std::setprecision(17)
      << "<mujoco><compiler angle='radian' inertiafromgeom='false'/>\n<option gravity='"
      << tree.gravity.x << ' ' << tree.gravity.y << ' ' << tree.gravity.z
      << "'><flag constraint='disable' contact='disable'/></option>\n<worldbody>\n";
  write_children(tree, phi, -1, identity_pose(), out);
  out << "</worldbody></mujoco>\n";
  return out.str();
}

class MujocoEngine final : public Engine {
 public:
  explicit MujocoEngine(const Model& arm)
      : n_(arm.joints()),
        forces_(arm),
        left_out_(forces_.left_out()),
        q_(VectorXd::Zero(n_)),
        dq_(q_),
        ddq_(q_),
        M_(MatrixXd::Zero(n_, n_)) {
    const std::string trouble = infeasibility(arm);
    require(trouble.empty(), "mujoco: ", trouble);
    load(arm);
    for (VectorXd* v : {&k2_, &k3_, &k4_, &q_trial_, &dq_trial_, &rate_, &bias_, &sum_, &diagonal_}) *v = q_;
    if (forces_.loads() > 0) left_out_.emplace_back("friction that depends on the load");
    if (forces_.dry() > 0)
      left_out_.emplace_back("true rest: dry friction is regularised below 0.1 mrad/s or mm/s");
  }

  int joints() const override { return n_; }
  double time() const override { return time_; }
  const VectorXd& q() const override { return q_; }
  const VectorXd& dq() const override { return dq_; }
  std::optional<JointIndex> failed_joint() const override { return failed_; }
  const std::vector<std::string>& left_out() const override { return left_out_; }

  void set_state(const VectorRef& q, const VectorRef& dq) override {
    require(q.size() == n_ && dq.size() == n_ && q.allFinite() && dq.allFinite(),
            "mujoco: found a state that is not ", n_, " finite numbers each.");
    q_ = q;
    dq_ = dq;
    time_ = 0.0;
    failed_.reset();
    forces_.reset(q_.data(), dq_.data());
  }

  StepStatus accelerate(const VectorRef& tau, VectorXd& ddq) noexcept override {
    return acceleration(tau, q_, dq_, time_, ddq);
  }

  StepStatus step(const VectorRef& tau, double dt) noexcept override {
    double left = dt;
    while (left > 1e-9 * dt) {
      const StepStatus first = acceleration(tau, q_, dq_, time_, ddq_);
      if (first != StepStatus::kOk) return first;
      const double longest = std::min(kLongestStep, stable_step());
      const int count = std::max(1, static_cast<int>(std::ceil(left / longest - 1e-9)));
      const double h = left / count;
      const StepStatus status = sliding_clearly(h) ? runge_kutta_step(tau, h) : fine_steps(tau, h);
      if (status != StepStatus::kOk) return status;
      left -= h;
    }
    return StepStatus::kOk;
  }

 private:
  struct Free {
    void operator()(mjModel* m) const { mj_deleteModel(m); }
    void operator()(mjData* d) const { mj_deleteData(d); }
  };

  // Makes model_ and data_ in MuJoCo, and S_; throws InvalidInput if MuJoCo refuses the model.
  void load(const Model& arm) {
    const Tree tree(arm);
    const std::string xml = mjcf_of(tree, *arm.inertial_values());
    const auto files = std::make_unique<mjVFS>();
    mj_defaultVFS(files.get());
    mj_makeEmptyFileVFS(files.get(), "arm.xml", static_cast<int>(xml.size()));
    std::memcpy(files->filedata[0], xml.data(), xml.size());
    char error[1000] = "";
    model_.reset(mj_loadXML("arm.xml", files.get(), error, sizeof(error)));
    mj_deleteVFS(files.get());
    std::string words = error;
    std::replace(words.begin(), words.end(), '\n', ' ');
    require(model_ != nullptr, "mujoco: it refuses the model: ", words);
    data_.reset(mj_makeData(model_.get()));
    S_ = MatrixXd::Zero(model_->nv, n_);
    for (int k = 0; k < static_cast<int>(tree.links.size()); ++k) {
      const Link& link = tree.links[k];
      if (link.type == JointType::kFixed) continue;
      const int joint = mj_name2id(model_.get(), mjOBJ_JOINT, joint_name(k).c_str());
      for (int e = link.first_coefficient; e < link.end_coefficient; ++e) {
        const JointCoefficient& share = tree.coefficients[e];
        S_(model_->jnt_dofadr[joint], share.coordinate) += share.coefficient;
      }
    }
    full_.resize(model_->nv, model_->nv);
    reduced_.resize(model_->nv, n_);
  }

  // Computes M_ (with the rotors) and bias_ of the rigid bodies with MuJoCo.
  void rigid_bodies(const VectorXd& q, const VectorXd& dq) noexcept {
    Eigen::Map<VectorXd>(data_->qpos, model_->nq).noalias() = S_ * q;
    Eigen::Map<VectorXd>(data_->qvel, model_->nv).noalias() = S_ * dq;
    mj_fwdPosition(model_.get(), data_.get());
    mj_fwdVelocity(model_.get(), data_.get());
    mj_fullM(model_.get(), full_.data(), data_->qM);
    reduced_.noalias() = full_ * S_;
    M_.noalias() = S_.transpose() * reduced_;
    M_ += forces_.inertia();
    bias_.noalias() = S_.transpose() * Eigen::Map<const VectorXd>(data_->qfrc_bias, model_->nv);
  }

  // Adds all effects except inertias; dry friction has its regularised sign.
  void add_effects(double time, const VectorXd& q, const VectorXd& dq, VectorXd& sum) noexcept {
    forces_.add_smooth(time, q.data(), dq.data(), sum.data());
    for (int k = 0; k < forces_.dry(); ++k) {
      const double v = forces_.velocity(k, dq.data());
      const double share = std::min(1.0, std::abs(v) / kRestSpeed);
      const double force = share * forces_.sliding(k, time, q.data(), v, v < 0.0 ? -1 : 1);
      add_scaled(force, forces_.axis(k), n_, sum.data());
    }
  }

  // Sets failed_ to the first joint with a number that is not finite.
  bool is_finite(const VectorRef& tau, const VectorXd& q, const VectorXd& dq) noexcept {
    for (int i = 0; i < n_; ++i) {
      if (std::isfinite(tau[i]) && std::isfinite(q[i]) && std::isfinite(dq[i])) continue;
      failed_ = {i};
      return false;
    }
    return true;
  }

  // Computes ddq at a state; M_ is then its Cholesky factor, and diagonal_ the diagonal of M.
  StepStatus acceleration(const VectorRef& tau, const VectorXd& q, const VectorXd& dq, double time,
                          VectorXd& ddq) noexcept {
    if (!is_finite(tau, q, dq)) return StepStatus::kNotFinite;
    rigid_bodies(q, dq);
    diagonal_ = M_.diagonal();
    sum_ = bias_;
    add_effects(time, q, dq, sum_);
    ddq = tau - sum_;
    if (!cholesky_in_place(M_.data(), n_)) return StepStatus::kNotPositive;
    solve_lower(M_.data(), n_, ddq.data());
    solve_lower_transposed(M_.data(), n_, ddq.data());
    return StepStatus::kOk;
  }

  // Limits the step by viscous friction of light joints, which decays faster than the arm moves.
  double stable_step() const noexcept {
    double rate = 0.0;
    for (int i = 0; i < n_; ++i)
      rate = std::max(rate, forces_.damping()(i, i) / std::max(diagonal_[i], 1e-300));
    return rate > 0.0 ? kStableShare / rate : kLongestStep;
  }

  // True if no axis with dry friction comes near rest within h, and no effect has memory.
  bool sliding_clearly(double h) const noexcept {
    if (forces_.dry() == 0) return true;
    if (forces_.memories() > 0) return false;
    for (int k = 0; k < forces_.dry(); ++k) {
      const double v = std::abs(forces_.velocity(k, dq_.data()));
      const double a = std::abs(forces_.velocity(k, ddq_.data()));
      if (v < kClear * kRestSpeed + 2.0 * h * a) return false;
    }
    return true;
  }

  // Runge-Kutta of order four; ddq_ is the acceleration at the present state.
  template <typename Acceleration>
  StepStatus runge_kutta(const Acceleration& acceleration_of, double h) noexcept {
    const auto stage = [&](double share, const VectorXd& rate, const VectorXd& k, VectorXd& out) {
      q_trial_ = q_ + share * h * rate;
      dq_trial_ = dq_ + share * h * k;
      return acceleration_of(q_trial_, dq_trial_, time_ + share * h, out);
    };
    StepStatus status = stage(0.5, dq_, ddq_, k2_);
    rate_ = dq_ + 0.5 * h * ddq_;
    if (status == StepStatus::kOk) status = stage(0.5, rate_, k2_, k3_);
    rate_ = dq_ + 0.5 * h * k2_;
    if (status == StepStatus::kOk) status = stage(1.0, rate_, k3_, k4_);
    if (status != StepStatus::kOk) return status;
    q_ += h * dq_ + (h * h / 6.0) * (ddq_ + k2_ + k3_);
    dq_ += (h / 6.0) * (ddq_ + 2.0 * (k2_ + k3_) + k4_);
    time_ += h;
    forces_.commit(time_, q_.data(), dq_.data());
    return StepStatus::kOk;
  }

  StepStatus runge_kutta_step(const VectorRef& tau, double h) noexcept {
    return runge_kutta(
        [&](const VectorXd& q, const VectorXd& dq, double time, VectorXd& ddq) {
          return acceleration(tau, q, dq, time, ddq);
        },
        h);
  }

  // Friction near rest is stiff, while the rigid bodies are not: their terms are kept constant at the middle
  // of the step, and the effects are integrated in small steps.
  StepStatus fine_steps(const VectorRef& tau, double h) noexcept {
    q_trial_ = q_ + 0.5 * h * dq_;
    dq_trial_ = dq_ + 0.5 * h * ddq_;
    for (int i = 0; i < n_; ++i)  // friction stops a joint and does not reverse it
      if (dq_[i] * dq_trial_[i] < 0.0) dq_trial_[i] = 0.0;
    if (!is_finite(tau, q_trial_, dq_trial_)) return StepStatus::kNotFinite;
    rigid_bodies(q_trial_, dq_trial_);
    if (!cholesky_in_place(M_.data(), n_)) return StepStatus::kNotPositive;
    const auto of_effects = [&](const VectorXd& q, const VectorXd& dq, double time, VectorXd& ddq) {
      if (!is_finite(tau, q, dq)) return StepStatus::kNotFinite;
      sum_ = bias_;
      add_effects(time, q, dq, sum_);
      ddq = tau - sum_;
      solve_lower(M_.data(), n_, ddq.data());
      solve_lower_transposed(M_.data(), n_, ddq.data());
      return StepStatus::kOk;
    };
    const int count = std::max(1, static_cast<int>(std::ceil(h / kFrictionStep - 1e-9)));
    for (int k = 0; k < count; ++k) {
      StepStatus status = of_effects(q_, dq_, time_, ddq_);
      if (status == StepStatus::kOk) status = runge_kutta(of_effects, h / count);
      if (status != StepStatus::kOk) return status;
    }
    return StepStatus::kOk;
  }

  int n_;
  PlantForces forces_;
  std::vector<std::string> left_out_;
  std::unique_ptr<mjModel, Free> model_;
  std::unique_ptr<mjData, Free> data_;
  MatrixXd S_, reduced_;  // derivative of MuJoCo's joints by the coordinates
  RowMatrix full_;
  VectorXd q_, dq_, ddq_, k2_, k3_, k4_, q_trial_, dq_trial_, rate_, bias_, sum_, diagonal_;
  MatrixXd M_;
  double time_ = 0.0;
  std::optional<JointIndex> failed_ = {};
};

}  // namespace

std::unique_ptr<Engine> make_mujoco_engine(const Model& arm) {
  return std::make_unique<MujocoEngine>(arm);
}

}  // namespace veridyn
