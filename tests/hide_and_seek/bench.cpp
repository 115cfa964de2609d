#include "hide_and_seek/bench.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <fstream>

#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn::seek {
namespace {

constexpr double kColour = 2.0;  // [Hz] corner of the coloured half

Model read_bench_robot(const std::string& arm) {
  const std::string own =
      std::string(VERIDYN_SOURCE_DIR) + "/tests/hide_and_seek/robots/" + arm + ".yaml";
  return read_model(std::ifstream(own) ? own : arm);
}

Eigen::Matrix3d random_turn(Draw& draw) {
  Eigen::Matrix3d M;
  for (double& x : M.reshaped()) x = draw.normal();
  // Gram and Schmidt.
  M.col(0).normalize();
  M.col(1) = (M.col(1) - M.col(0).dot(M.col(1)) * M.col(0)).normalized();
  M.col(2) = M.col(0).cross(M.col(1));
  return M;
}

// A rod from the link's origin back to where it hangs, with an ellipsoid on it.
Matrix4d random_body(double mass, const Vector3d& back, Draw& draw) {
  const double size = 0.5 * std::cbrt(mass / 3000.0) * draw.in(0.9, 1.5);
  Vector3d wobble;  // drawn from z to x, as in all boards so far
  for (const int k : {2, 1, 0}) wobble[k] = draw.normal();
  const Vector3d com = draw.in(0.2, 0.7) * back + 0.4 * size * wobble;
  Eigen::Matrix3d spread = back * back.transpose() / 12.0;
  const Eigen::Matrix3d R = random_turn(draw);
  for (int k = 0; k < 3; ++k) {
    const double axis = size * draw.in(0.6, 1.6);
    spread += R.col(k) * R.col(k).transpose() * axis * axis / 5.0;
  }
  Matrix4d out = point_mass(mass, com);
  out.topLeftCorner<3, 3>() += mass * spread;
  return out;
}

void draw_bodies(LagrangeArm& arm, double heaviest, Draw& draw) {
  const std::vector<Matrix4d> poses = arm.poses(VectorXd::Zero(arm.joints));
  std::vector<int> depth(arm.links.size(), 0);
  for (size_t k = 0; k < arm.links.size(); ++k) {
    Link& link = arm.links[k];
    const auto parent = static_cast<size_t>(link.parent);
    if (link.parent >= 0) depth[k] = depth[parent];
    if (!link.has_body) continue;
    const double mass = heaviest * std::pow(0.62, depth[k]++) * draw.in(0.7, 1.3);
    Vector3d back = Vector3d::Zero();
    if (link.parent >= 0) back = (poses[k].inverse() * poses[parent].col(3)).head<3>();
    link.moments = random_body(mass, back, draw);
  }
}

double rms(const VectorXd& x) {
  return std::sqrt(x.squaredNorm() / static_cast<double>(x.size()));
}

void add_friction(const Bench& bench, int number, IdealRecording& out) {
  const double viscosity = viscosity_factor(bench.trouble, bench.seed, place_in_time(number));
  for (int i = 0; i < bench.arm.joints; ++i) {
    const JointFriction& f = bench.friction[i];
    const double fastest = out.rows.dq.col(i).cwiseAbs().maxCoeff();
    const double width = step_width(bench.trouble, bench.seed, i, fastest);
    for (Eigen::Index r = 0; r < out.tau.rows(); ++r) {
      const double v = out.rows.dq(r, i);
      const double side = width > 0.0 ? smooth_direction(v, width) : direction(v);
      out.tau(r, i) += viscosity * f.viscous * v + f.coulomb * side + f.offset;
    }
  }
}

double heaviest_body(const std::string& arm, Draw& draw) {
  if (arm == "psm-3dof") return draw.in(1.2, 2.5);
  if (arm == "pallet-4") return draw.in(12.0, 25.0);
  return draw.in(5.0, 10.0);
}

}  // namespace

const std::vector<std::string>& bench_arms() {
  static const std::vector<std::string> kArms = {"bench-6r", "pick-scara", "pallet-4", "psm-3dof"};
  return kArms;
}

Bench make_bench(const std::string& name, unsigned seed) {
  const Model robot = read_bench_robot(name);
  Bench bench{robot, lagrange_arm(robot), {}, {}, seed};
  Draw draw(seed, "bodies of " + name);
  draw_bodies(bench.arm, heaviest_body(name, draw), draw);
  const Motion::Rows rows = Motion(robot, seed, 0).sampled(20.0);
  const MatrixXd rigid = bench.arm.torques(rows.q, rows.dq, rows.ddq);
  Draw other(seed, "joints of " + name);
  for (int i = 0; i < bench.arm.joints; ++i) {
    const bool slides = robot.coordinates()[i].prismatic;
    const double effort = rms(rigid.col(i)) + (slides ? 1.0 : 0.1);
    JointFriction f;
    f.coulomb = other.in(0.05, 0.15) * effort;
    f.viscous = other.in(0.03, 0.10) * effort / rms(rows.dq.col(i));
    f.offset = other.in(-0.05, 0.05) * effort;
    bench.friction.push_back(f);
    const double unit = slides ? 0.1 : 1.0;  // metres for radians
    bench.sensors.push_back(
        {other.in(0.03, 0.05), unit * other.log_in(1e-5, 1e-4), unit * other.log_in(1e-3, 8e-3)});
  }
  return bench;
}

IdealRecording ideal_recording(const Bench& bench, const std::vector<Cause>& causes,
                               const Motion& motion, int number, const MatrixXd* rigid) {
  const LagrangeArm arm = changed(bench.arm, causes);
  IdealRecording out;
  out.nominal = std::none_of(causes.begin(), causes.end(),
                             [](const Cause& c) { return is_structural(c.effect); });
  const bool same = rigid != nullptr && out.nominal;
  out.rows = motion.sampled(kRate);
  out.rigid = same ? *rigid : arm.torques(out.rows.q, out.rows.dq, out.rows.ddq);
  out.tau = out.rigid;
  out.q = out.rows.q;
  add_friction(bench, number, out);
  if (bench.trouble == Trouble::kElasticBase)
    out.tau += elastic_base_torque(arm, bench.seed, out.rows);
  for (const Cause& cause : causes) {
    const std::vector<std::string> names = linear_parameters(cause.effect);
    if (!names.empty()) {
      const MatrixXd columns = cause_columns(cause, motion, out.rows, out.rigid.col(cause.joint));
      for (size_t p = 0; p < names.size(); ++p)
        out.tau.col(cause.joint) +=
            cause.values.at(names[p]) * columns.col(p);
    } else if (cause.effect == "external_contact") {
      std::map<std::string, double> values = cause.values;
      draw_contact_time(values, motion.duration(), bench.seed, number);
      out.tau.col(cause.joint) += contact_torque(values, out.rows.time);
    }
  }
  for (const Cause& cause : causes) {
    for (int i = 0; i < arm.joints; ++i) {
      if (cause.joint >= 0 && cause.joint != i) continue;  // -1: the whole arm
      if (cause.effect == "time_delay")
        out.tau.col(i) = delayed(out.tau.col(i), 1.0 / kRate, cause.values.at("seconds"));
      if (cause.effect == "torque_gain") out.tau.col(i) *= cause.values.at("gain");
      if (cause.effect == "torque_crosstalk") out.tau.col(i) += cause.values.at("share") * out.tau.col(cause.from);
    }
    if (cause.effect == "encoder_offset")
      out.q.col(cause.joint).array() += cause.values.at("offset");
  }
  return out;
}

void draw_contact_time(std::map<std::string, double>& values, double duration, unsigned seed,
                       int number) {
  Draw draw(seed, "contact " + std::to_string(number));
  values["from"] = draw.in(0.15, 0.8) * duration;
  values["to"] = values["from"] + draw.in(0.5, 1.0);
}

VectorXd torque_noise(double rms, Eigen::Index rows, Draw& draw) {
  const double memory = std::exp(-2.0 * M_PI * kColour / kRate);
  double coloured = draw.normal();
  VectorXd out(rows);
  for (double& x : out) {
    x = std::sqrt(0.5) * rms * (coloured + draw.normal());
    coloured = memory * coloured + std::sqrt(1.0 - memory * memory) * draw.normal();
  }
  return out;
}

void write_recording(const Bench& bench, const IdealRecording& ideal, unsigned seed, int number,
                     const std::string& path) {
  Draw draw(seed, "sensors " + std::to_string(number));
  const Eigen::Index rows = ideal.tau.rows();
  MatrixXd q = ideal.q;
  MatrixXd dq = ideal.rows.dq;
  MatrixXd tau = ideal.tau;
  for (Eigen::Index i = 0; i < q.cols(); ++i) {
    const JointSensors& s = bench.sensors[i];
    for (double& x : q.col(i)) x = std::round(x / s.encoder_step) * s.encoder_step;
    for (double& x : dq.col(i)) x += s.velocity_noise * draw.normal();
    tau.col(i) += torque_noise(s.torque_noise * rms(ideal.tau.col(i)), rows, draw);
  }
  trouble_rows(bench.trouble, bench.seed, number, ideal.rows.time, q, dq, tau);
  std::string out = "t";
  for (const char* signal : {"q", "dq", "tau"}) {
    for (Eigen::Index i = 1; i <= q.cols(); ++i) out += fmt::format(",{}{}", signal, i);
  }
  for (Eigen::Index r = 0; r < rows; ++r) {
    out += fmt::format("\n{:.4f}", ideal.rows.time[r]);
    for (const MatrixXd* m : {&q, &dq, &tau}) {
      for (Eigen::Index i = 0; i < q.cols(); ++i) out += fmt::format(",{:.7g}", (*m)(r, i));
    }
  }
  std::ofstream file(path);
  file << out << "\n";
  require(file.good(), "hide and seek: ", path, " cannot be written.");
}

}  // namespace veridyn::seek
