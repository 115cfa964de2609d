#include "veridyn/simulation/plausible_model.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "support/near.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

// The pseudo-inertia of a body: [S h; h' m] with S = trace(L)/2 - L; positive definite if and only
// if a mass distribution exists (seed errata on thesis 5.32).
Eigen::Matrix4d pseudo_inertia(const InertialParameters& phi) {
  Eigen::Matrix3d L;
  L << phi[4], phi[5], phi[7], phi[5], phi[6], phi[8], phi[7], phi[8], phi[9];
  Eigen::Matrix4d J;
  J.topLeftCorner<3, 3>() = 0.5 * L.trace() * Eigen::Matrix3d::Identity() - L;
  J.topRightCorner<3, 1>() = phi.segment<3>(1);
  J.bottomLeftCorner<1, 3>() = phi.segment<3>(1).transpose();
  J(3, 3) = phi[0];
  return J;
}

TEST(PlausibleModel, EveryBodyIsPhysicallyConsistent) {
  for (const char* robot : {"psm-3dof", "psm-wrist", "mtm", "ur10e"}) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
      const PlausibleModel plausible = plausible_model(read_model(robot), seed);
      const VectorXd phi = *plausible.arm.inertial_values();
      EXPECT_EQ(plausible.bodies, static_cast<int>(plausible.arm.bodies().size()));
      for (Eigen::Index b = 0; b < phi.size(); b += kBodyParameters) {
        const InertialParameters body = phi.segment<kBodyParameters>(b);
        EXPECT_GE(body[0], 0.2);
        EXPECT_LE(body[0], 3.0);
        EXPECT_LE(body.segment<3>(1).cwiseAbs().maxCoeff(), 0.1 * body[0]);
        EXPECT_GT(
            Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(pseudo_inertia(body)).eigenvalues()[0],
            0.0);
      }
    }
  }
}

TEST(PlausibleModel, EveryEffectGetsAFeasibleSize) {
  const Model arm = plausible_model(read_model("mtm"), 3).arm;
  for (const EffectTerm& term : arm.effects()) {
    for (const EffectParameter& p : find_effect(term.effect).parameters())
      EXPECT_GT(term.values.at(p.name), 0.0);
  }
}

TEST(PlausibleModel, TheSameSeedGivesTheSameArm) {
  const Model robot = read_model("psm-3dof");
  EXPECT_EQ(to_yaml(plausible_model(robot, 5).arm), to_yaml(plausible_model(robot, 5).arm));
  EXPECT_NE(to_yaml(plausible_model(robot, 5).arm), to_yaml(plausible_model(robot, 6).arm));
}

TEST(PlausibleModel, ValuesOfTheRobotFileAreKept) {
  const Model robot = read_model("scara");
  const PlausibleModel plausible = plausible_model(robot, 1);
  EXPECT_EQ(plausible.bodies + plausible.effects, 0);
  EXPECT_EQ(to_yaml(plausible.arm), to_yaml(robot));
}

}  // namespace
}  // namespace veridyn
