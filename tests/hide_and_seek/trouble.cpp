#include "hide_and_seek/trouble.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "veridyn/math/require.hpp"

namespace veridyn::seek {
namespace {

constexpr double kLateShare = 0.1;
constexpr double kRings = 12.0;         // [Hz]
constexpr double kRingSeconds = 0.6;    // until when
constexpr double kRingDecay = 0.15;     // [s]
constexpr Eigen::Index kBaseStride = 5;  // rows; gravity changes slowly

double rms(const VectorXd& x) {
  return std::sqrt(x.squaredNorm() / static_cast<double>(std::max<Eigen::Index>(1, x.size())));
}

void repeat_rows(Draw& draw, MatrixXd& q, MatrixXd& dq, MatrixXd& tau) {
  for (Eigen::Index r = 1; r < q.rows(); ++r) {
    if (draw.in(0.0, 1.0) >= kLateShare) continue;
    for (MatrixXd* m : {&q, &dq, &tau}) m->row(r) = MatrixXd(m->row(r - 1));
  }
}

void quantise(Draw& draw, MatrixXd& dq) {
  for (Eigen::Index i = 0; i < dq.cols(); ++i) {
    const double range = dq.col(i).maxCoeff() - dq.col(i).minCoeff();
    const double step = draw.in(0.01, 0.03) * range;
    for (double& x : dq.col(i)) x = std::round(x / step) * step;
  }
}

void clip(Draw& draw, MatrixXd& tau) {
  const auto joint = static_cast<Eigen::Index>(draw.below(static_cast<int>(tau.cols())));
  const double limit = draw.in(0.85, 0.95) * tau.col(joint).cwiseAbs().maxCoeff();
  for (double& x : tau.col(joint)) x = std::clamp(x, -limit, limit);
}

void ring(Draw& draw, const VectorXd& time, MatrixXd& tau) {
  for (Eigen::Index i = 0; i < tau.cols(); ++i) {
    const double size = draw.in(1.0, 3.0) * rms(tau.col(i));
    for (Eigen::Index r = 0; r < tau.rows(); ++r) {
      const double t = time[r] - time[0];
      if (t > kRingSeconds) break;
      tau(r, i) += size * std::exp(-t / kRingDecay) * std::sin(2.0 * M_PI * kRings * t);
    }
  }
}

}  // namespace

const std::vector<Trouble>& all_troubles() {
  static const std::vector<Trouble> kAll = {
      Trouble::kLateRows,         Trouble::kQuantisedVelocity, Trouble::kSaturation,
      Trouble::kStartUpRinging,   Trouble::kTemperatureDrift,  Trouble::kSmoothedSign,
      Trouble::kElasticBase};
  return kAll;
}

const char* name_of(Trouble trouble) {
  switch (trouble) {
    case Trouble::kLateRows:
      return "late_rows";
    case Trouble::kQuantisedVelocity:
      return "quantised_velocity";
    case Trouble::kSaturation:
      return "saturation";
    case Trouble::kStartUpRinging:
      return "start_up_ringing";
    case Trouble::kTemperatureDrift:
      return "temperature_drift";
    case Trouble::kSmoothedSign:
      return "smoothed_sign";
    case Trouble::kElasticBase:
      return "elastic_base";
    case Trouble::kNone:
      break;
  }
  return "none";
}

Trouble trouble_of(const std::string& name) {
  for (const Trouble t : all_troubles()) {
    if (name == name_of(t)) return t;
  }
  require(name == "none", "hide and seek: found the trouble '", name,
          "', expected one of late_rows, quantised_velocity, saturation, start_up_ringing, "
          "temperature_drift, smoothed_sign, elastic_base.");
  return Trouble::kNone;
}

double smooth_direction(double speed, double width) {
  return std::tanh(speed / width);
}

double viscosity_factor(Trouble trouble, unsigned seed, int place) {
  if (trouble != Trouble::kTemperatureDrift) return 1.0;
  const double step = Draw(seed, "temperature").in(0.01, 0.03);
  return std::pow(1.0 - step, place);
}

double step_width(Trouble trouble, unsigned seed, int joint, double largest_speed) {
  if (trouble != Trouble::kSmoothedSign) return 0.0;
  return Draw(seed, "step of joint " + std::to_string(joint)).in(0.01, 0.03) * largest_speed;
}

MatrixXd elastic_base_torque(const LagrangeArm& arm, unsigned seed, const MatrixXd& q,
                             const MatrixXd& rigid) {
  Draw draw(seed, "elastic base");
  const double largest = draw.in(3e-3, 8e-3);
  const Eigen::Index second = std::min<Eigen::Index>(1, rigid.cols() - 1);
  const double first_peak = std::max(rigid.col(0).cwiseAbs().maxCoeff(), 1e-12);
  const double second_peak = std::max(rigid.col(second).cwiseAbs().maxCoeff(), 1e-12);
  MatrixXd out = MatrixXd::Zero(rigid.rows(), rigid.cols());
  const VectorXd rest = VectorXd::Zero(q.cols());
  const auto at = [&](Eigen::Index r) {
    const Vector3d lean(largest * rigid(r, 0) / first_peak,
                        largest * rigid(r, second) / second_peak, 0.0);
    LagrangeArm leaning = arm;
    leaning.gravity = -lean.cross(arm.gravity);  // torques are linear in gravity: the change only
    return VectorXd(leaning.torque(q.row(r).transpose(), rest, rest));
  };
  VectorXd before = at(0);
  out.row(0) = before;
  for (Eigen::Index r = 0; r + 1 < rigid.rows(); r += kBaseStride) {
    const Eigen::Index next = std::min(r + kBaseStride, rigid.rows() - 1);
    const VectorXd after = at(next);
    for (Eigen::Index k = r; k <= next; ++k) {
      const double share = static_cast<double>(k - r) / static_cast<double>(next - r);
      out.row(k) = (before + share * (after - before)).transpose();
    }
    before = after;
  }
  return out;
}

void trouble_rows(Trouble trouble, unsigned seed, int number, const VectorXd& time, MatrixXd& q,
                  MatrixXd& dq, MatrixXd& tau) {
  // The same drive clips and the same converter quantises in all recordings of one arm.
  Draw of_arm(seed, std::string("trouble ") + name_of(trouble));
  Draw of_recording(seed, std::string(name_of(trouble)) + " " + std::to_string(number));
  if (trouble == Trouble::kLateRows) repeat_rows(of_recording, q, dq, tau);
  if (trouble == Trouble::kQuantisedVelocity) quantise(of_arm, dq);
  if (trouble == Trouble::kSaturation) clip(of_arm, tau);
  if (trouble == Trouble::kStartUpRinging) ring(of_recording, time, tau);
}

}  // namespace veridyn::seek
