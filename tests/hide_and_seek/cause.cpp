#include "hide_and_seek/cause.hpp"

#include <algorithm>
#include <cmath>

namespace veridyn::seek {
namespace {

constexpr double kSmooth = 1e-4;  // [rad/s] or [m/s]
constexpr double kRamp = 0.1;     // [s]
constexpr int kSubsteps = 5;      // of 5 ms, for memories

bool one_of(const std::string& name, const std::vector<std::string>& names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// Positions of the joint between rows, for effects that remember; next() gives the state at a row.
template <typename Advance>
VectorXd remembered(const Motion& motion, const VectorXd& time, int joint, const Advance& advance) {
  VectorXd out(time.size());
  double before = motion.at(time[0]).q[joint];
  double value = 0.0;
  for (Eigen::Index r = 0; r < time.size(); ++r) {
    const double last = r == 0 ? time[0] : time[r - 1];
    for (int k = 1; r > 0 && k <= kSubsteps; ++k) {
      const double now = motion.at(last + (time[r] - last) * k / kSubsteps).q[joint];
      value = advance(value, now - before);
      before = now;
    }
    out[r] = value;
  }
  return out;
}

// Dahl's contact: dz = (ds - |ds| z) / distance, by the midpoint rule.
VectorXd dahl(const Motion& motion, const VectorXd& time, int joint, double distance) {
  return remembered(motion, time, joint, [distance](double z, double step) {
    const auto rate = [&](double at) { return (step - std::abs(step) * at) / distance; };
    return z + rate(z + 0.5 * rate(z));
  });
}

// Play: the place between the teeth, -1 to 1; force in the outer fifth on either side.
VectorXd behind_a_gap(const Motion& motion, const VectorXd& time, int joint, double gap) {
  VectorXd place = remembered(motion, time, joint, [gap](double p, double step) {
    return std::max(-1.0, std::min(1.0, p + step / (0.5 * gap)));
  });
  for (double& p : place) p = std::abs(p) <= 0.8 ? 0.0 : (p > 0.0 ? p - 0.8 : p + 0.8) / 0.2;
  return place;
}

VectorXd second_derivative(const VectorXd& x, double step) {
  const Eigen::Index n = x.size();
  VectorXd out = VectorXd::Zero(n);
  for (Eigen::Index r = 1; r + 1 < n; ++r)
    out[r] = (x[r + 1] - 2.0 * x[r] + x[r - 1]) / (step * step);
  out[0] = out[1];
  out[n - 1] = out[n - 2];
  return out;
}

}  // namespace

const std::vector<std::string>& all_causes() {
  static const std::vector<std::string> kAll = {"rotor_inertia",
                                                "joint_spring",
                                                "viscous_friction",
                                                "coulomb_friction",
                                                "torque_offset",
                                                "stribeck_friction",
                                                "presliding_hysteresis",
                                                "asymmetric_friction",
                                                "position_dependent_friction",
                                                "position_dependent_viscosity",
                                                "load_dependent_friction",
                                                "quadratic_drag",
                                                "sublinear_viscous",
                                                "torque_ripple",
                                                "cable_coupling",
                                                "position_force",
                                                "backlash",
                                                "transmission_compliance",
                                                "torque_gain",
                                                "torque_drift",
                                                "time_delay",
                                                "payload",
                                                "gravity_tilt",
                                                "encoder_offset",
                                                "coupling_error",
                                                "external_contact",
                                                "warm_up",
                                                "end_stop",
                                                "torque_crosstalk"};
  return kAll;
}

bool is_structural(const std::string& effect) {
  return one_of(effect, {"payload", "gravity_tilt", "coupling_error"});
}

bool is_channel(const std::string& effect) {
  return one_of(effect, {"torque_gain", "time_delay", "encoder_offset", "torque_crosstalk"});
}

std::vector<std::string> linear_parameters(const std::string& effect) {
  static const std::map<std::string, std::vector<std::string>> kNames = {
      {"rotor_inertia", {"inertia"}},
      {"joint_spring", {"stiffness"}},
      {"viscous_friction", {"coefficient"}},
      {"coulomb_friction", {"level"}},
      {"torque_offset", {"offset"}},
      {"stribeck_friction", {"level"}},
      {"presliding_hysteresis", {"level"}},
      {"asymmetric_friction", {"level_difference", "viscous_difference"}},
      {"position_dependent_friction", {"slope"}},
      {"position_dependent_viscosity", {"slope"}},
      {"load_dependent_friction", {"coefficient"}},
      {"quadratic_drag", {"coefficient"}},
      {"sublinear_viscous", {"coefficient"}},
      {"torque_ripple", {"cosine", "sine"}},
      {"cable_coupling", {"stiffness", "drag"}},
      {"position_force", {"amplitude"}},
      {"backlash", {"level"}},
      {"transmission_compliance", {"compliance_inertia"}},
      {"torque_drift", {"rate"}},
      {"warm_up", {"level", "viscosity"}},
      {"end_stop", {"stiffness"}}};
  const auto found = kNames.find(effect);
  return found == kNames.end() ? std::vector<std::string>{} : found->second;
}

double direction(double speed) {
  return speed / std::hypot(speed, kSmooth);
}

void draw_shapes(Cause& cause, const Reach& reach, Draw& draw) {
  const std::string& e = cause.effect;
  std::map<std::string, double>& v = cause.values;
  if (e == "stribeck_friction") v["velocity"] = draw.log_in(0.03, 0.15) * reach.speed;
  if (e == "presliding_hysteresis") v["distance"] = draw.log_in(0.004, 0.08) * reach.travel;
  if (e == "backlash") v["gap"] = draw.log_in(0.003, 0.03) * reach.travel;
  if (e == "sublinear_viscous") v["exponent"] = draw.in(0.35, 0.75);
  if (e == "torque_ripple")
    v["order"] = reach.slides ? 2.0 * M_PI / draw.log_in(4e-3, 20e-3) : 6.0 + draw.below(60);
  if (e == "position_dependent_friction" || e == "position_dependent_viscosity" ||
      e == "joint_spring" || e == "cable_coupling" || e == "position_force")
    v["centre"] = reach.middle;
  if (e == "position_force") {
    v["wave_number"] = draw.in(2.5, 4.5) / (0.5 * reach.travel);
    v["phase"] = draw.in(-M_PI, M_PI);
  }
  if (e == "end_stop") {
    v["centre"] = reach.middle;
    v["reach"] = draw.in(0.1, 0.35) * reach.travel;
    v["side"] = draw.sign();
  }
  if (e == "warm_up") v["time_constant"] = draw.in(0.3, 0.8) * reach.duration;
}

MatrixXd cause_columns(const Cause& cause, const Motion& motion, const Motion::Rows& rows,
                       const VectorXd& load) {
  const std::string& e = cause.effect;
  const auto value = [&](const char* name) { return cause.values.at(name); };
  const Eigen::Index n = rows.time.size();
  const VectorXd q = rows.q.col(cause.joint);
  const VectorXd v = rows.dq.col(cause.joint);
  const VectorXd sign = v.unaryExpr([](double x) { return direction(x); });
  const double step = rows.time[1] - rows.time[0];
  MatrixXd out(n, static_cast<Eigen::Index>(linear_parameters(e).size()));
  const auto way = [&] { return (q.array() - value("centre")).eval(); };
  if (e == "rotor_inertia") out.col(0) = rows.ddq.col(cause.joint);
  if (e == "joint_spring") out.col(0) = way();
  if (e == "viscous_friction") out.col(0) = v;
  if (e == "coulomb_friction") out.col(0) = sign;
  if (e == "torque_offset") out.setOnes();
  if (e == "stribeck_friction")
    out.col(0) = sign.array() * (-(v.array() / value("velocity")).square()).exp();
  if (e == "presliding_hysteresis")
    out.col(0) = dahl(motion, rows.time, cause.joint, value("distance"));
  if (e == "asymmetric_friction") {
    out.col(0) = 0.5 * sign.cwiseAbs();
    out.col(1) = 0.5 * v.cwiseAbs();
  }
  if (e == "position_dependent_friction") out.col(0) = sign.array() * way();
  if (e == "position_dependent_viscosity") out.col(0) = v.array() * way();
  if (e == "load_dependent_friction") out.col(0) = load.cwiseAbs().cwiseProduct(sign);
  if (e == "quadratic_drag") out.col(0) = v.cwiseProduct(v.cwiseAbs());
  if (e == "sublinear_viscous") out.col(0) = sign.array() * v.array().abs().pow(value("exponent"));
  if (e == "torque_ripple") {
    out.col(0) = (value("order") * q.array()).cos();
    out.col(1) = (value("order") * q.array()).sin();
  }
  if (e == "cable_coupling") {
    out.col(0) = rows.q.col(cause.from).array() - value("centre");
    out.col(1) = rows.dq.col(cause.from).unaryExpr([](double x) { return direction(x); });
  }
  if (e == "position_force") out.col(0) = (value("wave_number") * way() + value("phase")).sin();
  if (e == "backlash") out.col(0) = behind_a_gap(motion, rows.time, cause.joint, value("gap"));
  if (e == "transmission_compliance") out.col(0) = second_derivative(load, step);
  if (e == "torque_drift") out.col(0) = rows.time;
  if (e == "end_stop") {
    for (Eigen::Index r = 0; r < n; ++r) {
      const double beyond = std::abs(q[r] - value("centre")) - value("reach");
      const bool there = beyond > 0.0 && (q[r] - value("centre")) * value("side") > 0.0;
      out(r, 0) = there ? value("side") * beyond : 0.0;
    }
  }
  if (e == "warm_up") {
    const Eigen::ArrayXd cold = (-rows.time.array() / value("time_constant")).exp();
    out.col(0) = sign.array() * cold;
    out.col(1) = v.array() * cold;
  }
  return out;
}

VectorXd contact_torque(const std::map<std::string, double>& values, const VectorXd& time) {
  return time.unaryExpr([&](double t) {
    const double inside = std::min(t - values.at("from"), values.at("to") - t);
    const double share = std::clamp(inside / kRamp, 0.0, 1.0);
    return values.at("effort") * share * share * (3.0 - 2.0 * share);
  });
}

VectorXd delayed(const VectorXd& signal, double step, double delay) {
  const Eigen::Index n = signal.size();
  const auto at = [&](Eigen::Index k) { return signal[std::clamp<Eigen::Index>(k, 0, n - 1)]; };
  VectorXd out(n);
  for (Eigen::Index r = 0; r < n; ++r) {
    const double place = static_cast<double>(r) - delay / step;
    const auto k = static_cast<Eigen::Index>(std::floor(place));
    const double u = place - static_cast<double>(k);
    out[r] = at(k) + 0.5 * u *
                         (at(k + 1) - at(k - 1) +
                          u * (2.0 * at(k - 1) - 5.0 * at(k) + 4.0 * at(k + 1) - at(k + 2) +
                               u * (3.0 * (at(k) - at(k + 1)) + at(k + 2) - at(k - 1))));
  }
  return out;
}

LagrangeArm changed(LagrangeArm arm, const std::vector<Cause>& causes) {
  for (const Cause& cause : causes) {
    const auto& v = cause.values;
    if (cause.effect == "gravity_tilt") {
      const double roll = v.at("roll");
      const double pitch = v.at("pitch");
      // g in the base, which stands turned by R = Ry(pitch) Rx(roll): R' g.
      const Vector3d g = arm.gravity;
      const Vector3d p{std::cos(pitch) * g.x() - std::sin(pitch) * g.z(), g.y(),
                       std::sin(pitch) * g.x() + std::cos(pitch) * g.z()};
      arm.gravity = {p.x(), std::cos(roll) * p.y() + std::sin(roll) * p.z(),
                     -std::sin(roll) * p.y() + std::cos(roll) * p.z()};
    }
    for (Link& link : arm.links) {
      if (link.name != cause.frame) continue;
      if (cause.effect == "payload")
        link.moments += point_mass(v.at("mass"), {v.at("x"), v.at("y"), v.at("z")});
      if (cause.effect != "coupling_error") continue;
      if (cause.constant == "a") link.a = v.at("value");
      if (cause.constant == "alpha") link.alpha = v.at("value");
      if (cause.constant == "d") link.d = v.at("value");
      if (cause.constant == "theta") link.theta = v.at("value");
      if (cause.constant == "ratio") link.ratios[cause.joint] = v.at("value");
    }
  }
  return arm;
}

}  // namespace veridyn::seek
