#include "veridyn/control/torque_uncertainty.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <string>

#include "control/static_forces.hpp"
#include "kinematics/standard_motion.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

// Symbols in the names of base parameters: "hx_yaw" has symbol and frame.
constexpr std::array<const char*, 10> kSymbols = {"m",   "hx",  "hy",  "hz",  "Lxx",
                                                  "Lxy", "Lyy", "Lxz", "Lyz", "Lzz"};

// Index of a parameter among 10 of every body, from its name; -1: none.
int inertial_parameter_index(const Model& arm, const std::string& name) {
  for (size_t b = 0; b < arm.bodies().size(); ++b) {
    const std::string& frame = arm.frames()[arm.bodies()[b].value].name;
    for (size_t k = 0; k < kSymbols.size(); ++k) {
      if (name == std::string(kSymbols[k]) + "_" + frame) return static_cast<int>(10 * b + k);
    }
  }
  return -1;
}

// Rms torque of each joint in the standard motion, friction included.
VectorXd standard_torque(const Model& arm, FrictionCompensation& friction) {
  const MotionSamples motion = standard_motion(arm);
  ArmState state(arm, {arm.frames().back().name});
  VectorXd squares = VectorXd::Zero(arm.joints());
  for (Eigen::Index k = 0; k < motion.rows(); ++k) {
    state.update(motion.q.row(k).transpose(), motion.dq.row(k).transpose());
    VectorXd tau = state.mass_matrix() * motion.ddq.row(k).transpose() + state.bias();
    friction.set_axis_states(state);
    for (int a = 0; a < friction.axes(); ++a) {
      const double v = friction.axis(a).dot(state.dq());
      tau += friction.sliding(a, v < 0.0 ? -1.0 : 1.0, v) * friction.axis(a);
    }
    squares += tau.cwiseAbs2();
  }
  return (squares / static_cast<double>(motion.rows())).cwiseSqrt();
}

}  // namespace

TorqueUncertainty::TorqueUncertainty(const Model& arm, const UncertaintyOptions& options)
    : options_(options),
      regressor_(arm),
      friction_(arm),
      unexplained_(VectorXd::Zero(arm.joints())),
      u_(VectorXd::Zero(arm.joints())) {
  require(options.relative > 0.0 && options.deviations > 0.0 && options.velocity.revolute > 0.0 &&
              options.velocity.prismatic > 0.0,
          "TorqueUncertainty: found an option that is not above zero.");
  const VectorXd phi = control_parameters(arm, "TorqueUncertainty");
  if (arm.description().identified && arm.description().identified->has_scatter())
    read_identified(arm);
  if (!identified_) {
    for (Eigen::Index p = 0; p < phi.size(); ++p)
      if (phi[p] != 0.0) column_.push_back(static_cast<int>(p));
    factor_.resize(1, static_cast<Eigen::Index>(column_.size()));
    for (Eigen::Index k = 0; k < factor_.cols(); ++k)
      factor_(0, k) = options.relative * std::abs(phi[column_[k]]);
  }
  Y_ = MatrixXd::Zero(arm.joints(), phi.size());
  sum_ = MatrixXd::Zero(factor_.rows(), arm.joints());
}

// A base parameter acts through the column of its leading standard parameter.
void TorqueUncertainty::read_identified(const Model& arm) {
  const IdentifiedBase& base = *arm.description().identified;
  std::vector<const IdentifiedParameter*> inertial;
  Eigen::Index factors = 0;
  for (const IdentifiedParameter& p : base.parameters) {
    const int column = inertial_parameter_index(arm, p.name);
    if (column < 0 || p.scatter.size() == 0) continue;
    inertial.push_back(&p);
    column_.push_back(column);
    factors = std::max(factors, p.scatter.size());
  }
  if (inertial.empty()) return;
  identified_ = true;
  factor_ = MatrixXd::Zero(factors, inertial.size());
  for (size_t k = 0; k < inertial.size(); ++k)
    factor_.col(k).head(inertial[k]->scatter.size()) = inertial[k]->scatter;
  if (base.error.size() == arm.joints())
    unexplained_ = base.error.cwiseProduct(standard_torque(arm, friction_));
}

void TorqueUncertainty::add_friction(const ArmState& arm) noexcept {
  friction_.set_axis_states(arm);
  const double moving = std::min(1.0, options_.relative * options_.deviations / 3.0);
  for (int k = 0; k < friction_.axes(); ++k) {
    double v = 0.0;
    for (const JointCoefficient& c : friction_.terms(k)) v += c.coefficient * arm.dq()[c.coordinate];
    const double slow =
        friction_.prismatic(k) ? options_.velocity.prismatic : options_.velocity.revolute;
    const double level =
        std::max(std::abs(friction_.sliding(k, 1.0, v)), std::abs(friction_.sliding(k, -1.0, v)));
    const double unknown = (std::abs(v) < slow ? 1.0 : moving) * level;
    for (const JointCoefficient& c : friction_.terms(k))
      u_[c.coordinate] += std::abs(c.coefficient) * unknown;
  }
}

const VectorXd& TorqueUncertainty::update(const ArmState& arm, const VectorRef& ddq) noexcept {
  assert(ddq.size() == u_.size() && arm.joints() == u_.size());
  regressor_.evaluate(arm.q(), arm.dq(), ddq, Y_);
  sum_.setZero();
  for (size_t k = 0; k < column_.size(); ++k) {
    const auto sigma = factor_.col(static_cast<Eigen::Index>(k));
    const double* const y = &Y_(0, column_[k]);
    if (identified_) {
      for (Eigen::Index i = 0; i < u_.size(); ++i) {
        if (y[i] != 0.0) sum_.col(i) += y[i] * sigma;  // the joint moves the body
      }
    } else {
      const double variance = sigma[0] * sigma[0];
      double* const sum = sum_.data();
      for (Eigen::Index i = 0; i < u_.size(); ++i) sum[i] += variance * y[i] * y[i];
    }
  }
  for (Eigen::Index i = 0; i < u_.size(); ++i) {
    const double known = identified_ ? sum_.col(i).squaredNorm() : sum_(0, i);
    u_[i] = options_.deviations * std::sqrt(known + unexplained_[i] * unexplained_[i]);
  }
  add_friction(arm);
  return u_;
}

}  // namespace veridyn
