#include "hide_and_seek/trouble.hpp"

#include <algorithm>
#include <cmath>

#include "veridyn/math/require.hpp"

namespace veridyn::seek {
namespace {

constexpr double kLateShare = 0.1;
constexpr double kRings = 12.0;         // [Hz]
constexpr double kRingSeconds = 0.6;    // until when
constexpr double kRingDecay = 0.15;     // [s]
constexpr Eigen::Index kBaseStride = 5;  // rows; a base follows what is slow

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

// Below the arm's links a base that turns about x and then about y: two coordinates after its own. Three
// rows of DH with quarter turns, each of which makes x, y, z of the next link y, z, x of its parent.
LagrangeArm on_turning_base(LagrangeArm arm) {
  std::vector<Link> links(3);
  for (int k = 0; k < 3; ++k) {
    links[k].parent = k - 1;
    links[k].alpha = links[k].theta = M_PI_2;
    links[k].ratios = VectorXd::Zero(arm.joints + 2);
    if (k > 0) links[k].ratios[arm.joints + k - 1] = 1.0;
  }
  for (Link link : arm.links) {
    link.parent = link.parent < 0 ? 2 : link.parent + 3;
    link.ratios.conservativeResize(arm.joints + 2);
    link.ratios.tail(2).setZero();
    links.push_back(std::move(link));
  }
  arm.links = std::move(links);
  arm.joints += 2;
  return arm;
}

Motion::Rows every(Eigen::Index stride, const Motion::Rows& rows) {
  const Eigen::Index count = (rows.q.rows() - 1) / stride + 1;
  Motion::Rows out{VectorXd(count), MatrixXd(count, rows.q.cols()), {}, {}};
  out.dq = out.ddq = out.q;
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::Index r = k * stride;
    out.time[k] = rows.time[r];
    out.q.row(k) = rows.q.row(r);
    out.dq.row(k) = rows.dq.row(r);
    out.ddq.row(k) = rows.ddq.row(r);
  }
  return out;
}

Motion::Rows with_turns(Motion::Rows rows) {
  for (MatrixXd* m : {&rows.q, &rows.dq, &rows.ddq}) {
    m->conservativeResize(m->rows(), m->cols() + 2);
    m->rightCols(2).setZero();
  }
  return rows;
}

// By central differences; the ends have the slopes beside them.
VectorXd slope_of(const VectorXd& x, double step) {
  const Eigen::Index n = x.size();
  VectorXd out = VectorXd::Zero(n);
  for (Eigen::Index r = 1; r + 1 < n; ++r) out[r] = (x[r + 1] - x[r - 1]) / (2.0 * step);
  if (n > 2) {
    out[0] = out[1];
    out[n - 1] = out[n - 2];
  }
  return out;
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

MatrixXd elastic_base_torque(const LagrangeArm& arm, unsigned seed, const Motion::Rows& rows, double softer) {
  Draw draw(seed, "elastic base");
  const LagrangeArm on_base = on_turning_base(arm);
  const Motion::Rows coarse = every(kBaseStride, rows);
  const Eigen::Index n = arm.joints;
  Motion::Rows moved = with_turns(coarse);
  const MatrixXd rigid = on_base.torques(moved.q, moved.dq, moved.ddq);
  const double peak = std::max(rigid.rightCols(2).cwiseAbs().maxCoeff(), 1e-12);
  const double step = coarse.time[1] - coarse.time[0];
  for (Eigen::Index k = n; k < n + 2; ++k) {
    moved.q.col(k) = -softer * draw.in(3e-3, 8e-3) / peak * rigid.col(k);
    moved.dq.col(k) = slope_of(moved.q.col(k), step);
    moved.ddq.col(k) = slope_of(moved.dq.col(k), step);
  }
  const MatrixXd added = (on_base.torques(moved.q, moved.dq, moved.ddq) - rigid).leftCols(n);
  MatrixXd out(rows.q.rows(), n);
  for (Eigen::Index r = 0; r < out.rows(); ++r) {
    const Eigen::Index k = std::min(r / kBaseStride, added.rows() - 2);
    const double share = static_cast<double>(r - k * kBaseStride) / static_cast<double>(kBaseStride);
    out.row(r) = added.row(k) + share * (added.row(k + 1) - added.row(k));
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
