#include "identification/check/signal_hypotheses.hpp"

#include <cmath>

namespace veridyn {
namespace {

const double kDegree = std::acos(-1.0) / 180.0;

void swap_columns(MatrixXd* values, int i, int j) {
  if (values->cols() > 0) values->col(i).swap(values->col(j));
}

// "a1=a2,a2=a1"
std::string exchanged(const std::string& signal, int i, int j) {
  const std::string a = signal + std::to_string(i + 1), b = signal + std::to_string(j + 1);
  return a + "=" + b + "," + b + "=" + a;
}

}  // namespace

bool SignalHypothesis::excludes(const SignalHypothesis& other) const {
  if (second != 0 && joint == other.joint && second == other.second && !whole && !other.whole) return false;
  const auto concerns = [&other](int k) { return k != 0 && (k == other.joint || k == other.second); };
  return joint == 0 || other.joint == 0 || concerns(joint) || concerns(second);
}

std::vector<SignalHypothesis> angles_in_degrees(const Model& arm, const Recording& recording) {
  std::vector<int> turning;
  for (int i = 0; i < arm.joints(); ++i)
    if (!arm.coordinates()[i].prismatic) turning.push_back(i);
  if (turning.empty()) return {};
  const auto scale = [turning](MatrixXd* values) {
    for (const int i : turning) {
      if (values->cols() > 0) values->col(i) *= kDegree;
    }
  };
  std::vector<SignalHypothesis> out;
  out.push_back({"degrees", 0, "Positions are degrees", "--units q=deg", [scale](Recording* r) { scale(&r->q); }});
  if (recording.dq.size() > 0)
    out.push_back({"degrees", 0, "Positions and velocities are degrees", "--units q=deg,dq=deg/s", [scale](Recording* r) {
                     scale(&r->q);
                     scale(&r->dq);
                   }});
  return out;
}

SignalHypothesis turned_torque(int joint) {
  return {"torque_sign", joint + 1, "", "", [joint](Recording* r) { r->tau.col(joint) *= -1.0; }};
}

std::vector<SignalHypothesis> exchanges(int i, int j, const std::string& pair, bool dq, const std::string& torque) {
  const std::string torques = exchanged(torque, i, j);
  const std::string motion = exchanged("q", i, j) + (dq ? "," + exchanged("dq", i, j) : "");
  const auto swap_torques = [i, j](Recording* r) { swap_columns(&r->tau, i, j); };
  const auto swap_motion = [i, j](Recording* r) {
    for (MatrixXd* signal : {&r->q, &r->dq, &r->ddq}) swap_columns(signal, i, j);
  };
  const auto swap_both = [=](Recording* r) {
    swap_torques(r);
    swap_motion(r);
  };
  return {{"swapped_joints", i + 1, "The torques of " + pair + " are swapped", "--map " + torques, swap_torques, j + 1},
          {"swapped_joints", i + 1, "Positions and velocities of " + pair + " are swapped", "--map " + motion, swap_motion, j + 1},
          {"swapped_joints", i + 1, "The whole of " + pair + " is swapped", "--map " + motion + "," + torques, swap_both, j + 1, true}};
}

SignalHypothesis currents(const VectorXd& gains) {
  return {"current", 0, "Efforts are motor currents", "--units tau=A",
          [gains](Recording* r) { r->tau = r->tau * gains.asDiagonal(); }};
}

}  // namespace veridyn
