#include "veridyn/simulation/joint_torques.hpp"

#include "simulation/plant_torques.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/effects/effect_facts.hpp"

namespace veridyn {
namespace {

void require_values(const Model& arm) {
  for (const EffectTerm& term : arm.effects()) {
    require(EffectFacts(arm, term).has_values(), "joint_torques: arm '", arm.name(), "' has ",
            term.effect, " without values.");
  }
}

void require_shape(const Model& arm, const MotionSamples& m) {
  const auto fits = [&](const MatrixXd& signal) {
    return signal.rows() == m.time.size() && signal.cols() == arm.joints();
  };
  require(m.rows() > 0 && fits(m.q) && fits(m.dq) && fits(m.ddq), "joint_torques: time has ",
          m.time.size(), " rows, q is (", m.q.rows(), ", ", m.q.cols(), "), dq (", m.dq.rows(),
          ", ", m.dq.cols(), "), ddq (", m.ddq.rows(), ", ", m.ddq.cols(), "); arm '", arm.name(),
          "' has ", arm.joints(), " joints.");
}

bool is_strictly_increasing(const VectorXd& time) {
  for (Eigen::Index k = 1; k < time.size(); ++k) {
    if (!(time[k] > time[k - 1])) return false;
  }
  return true;
}

}  // namespace

MatrixXd joint_torques(const Model& arm, const MotionSamples& motion, int substeps) {
  require_shape(arm, motion);
  require_values(arm);
  require(substeps >= 1, "joint_torques: found ", substeps, " substeps, expected 1 or more.");
  return plant_torques(arm, motion, is_strictly_increasing(motion.time) ? substeps : 1);
}

VectorXd joint_torques(const Model& arm, const VectorRef& q, const VectorRef& dq,
                       const VectorRef& ddq) {
  const MotionSamples one{VectorXd::Zero(1), q.transpose(), dq.transpose(), ddq.transpose()};
  return joint_torques(arm, one, 1).row(0);
}

}  // namespace veridyn
