#include "veridyn/identification/portable_model.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "math/dense.hpp"
#include "support/near.hpp"
#include "support/random.hpp"
#include "support/sample_arms.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/files/sdf.hpp"
#include "veridyn/identification/pseudo_inertia.hpp"
#include "veridyn/identification/base_parameters.hpp"

namespace veridyn {
namespace {

Model with_bodies(const Model& arm, const VectorXd& phi) {
  ModelDescription d = arm.description();
  d.identified = IdentifiedBase{};
  for (std::size_t b = 0; b < arm.bodies().size(); ++b)
    d.frames[arm.bodies()[b].value].body->phi = phi.segment<kBodyParameters>(static_cast<Eigen::Index>(kBodyParameters * b));
  return Model(std::move(d));
}

// The arm as an identification may leave it: moved along what no torque shows, mostly to bodies that cannot be.
Model as_identified(const Model& arm) {
  const VectorXd phi = *arm.inertial_values();
  MatrixXd K = base_parameters(arm).K.leftCols(phi.size());
  Random random(5);
  VectorXd hidden = random.vector(static_cast<int>(phi.size()), -3.0, 3.0);
  for (std::size_t b = 0; b < arm.bodies().size(); ++b) {
    if (!arm.frames()[arm.bodies()[b].value].body->fixed) continue;
    const auto at = static_cast<Eigen::Index>(kBodyParameters * b);
    K.middleCols<kBodyParameters>(at).setZero();
    hidden.segment<kBodyParameters>(at).setZero();
  }
  hidden -= least_norm(K, VectorXd(K * hidden));
  return with_bodies(arm, phi + hidden);
}

double least_eigenvalue(const VectorXd& phi) {
  double least = 1e300;
  for (Eigen::Index at = 0; at < phi.size(); at += kBodyParameters)
    least = std::min(least, smallest_eigenvalue(pseudo_inertia(phi.segment<kBodyParameters>(at))));
  return least;
}

class PortableModels : public OnSampleArm {};
INSTANTIATE_TEST_SUITE_P(Sample, PortableModels, testing::ValuesIn(sample_arm_names()), sample_arm_name);

TEST_P(PortableModels, HavePhysicallyConsistentBodiesAndTheSameTorques) {
  const Model identified = as_identified(arm());
  ASSERT_LT(least_eigenvalue(*identified.inertial_values()), 0.0);
  const PortableModel portable = portable_model(identified);
  ASSERT_TRUE(portable.changed) << portable.remark;
  EXPECT_EQ(portable.prior, "a rod of 5 cm diameter and the density of water along every link");
  EXPECT_GT(least_eigenvalue(*portable.arm.inertial_values()), 0.0);
  RigidBodyDynamics before(arm(), phi()), after(portable.arm, *portable.arm.inertial_values());
  Random random(8);
  for (int k = 0; k < 5; ++k) {
    const VectorXd q = random.vector(joints(), -1.0, 1.0), dq = random.vector(joints(), -1.0, 1.0);
    const VectorXd ddq = random.vector(joints(), -1.0, 1.0);
    VectorXd expected(joints()), tau(joints());
    before.inverse_dynamics(q, dq, ddq, expected);
    after.inverse_dynamics(q, dq, ddq, tau);
    EXPECT_TRUE(near(tau, expected, 1e-8 * (1.0 + expected.cwiseAbs().maxCoeff())));
  }
}

// Where the torques admit the prior itself, nothing is nearer to it.
TEST_P(PortableModels, EqualThePriorIfItsTorquesAgree) {
  const PortableModel portable = portable_model(as_identified(arm()), arm());
  ASSERT_TRUE(portable.changed) << portable.remark;
  EXPECT_EQ(portable.prior, "the bodies of " + arm().name());
  EXPECT_TRUE(near(*portable.arm.inertial_values(), phi(), 1e-3 * phi().cwiseAbs().maxCoeff()));
}

// A pendulum of 0.4 m whose torques are those of a rod of water: its mass, which no torque shows, is the rod's.
TEST(PortableModel, AnUnidentifiedMassIsThatOfARodOfWater) {
  constexpr double kLength = 0.4, kMass = 1000.0 * M_PI * 0.025 * 0.025 * kLength;
  ArmBuilder builder("pendulum", 1, 3);
  const int link = builder.link(-1, JointType::kRevolute, {1.0}, 0.0, identity_pose(), identity_pose());
  builder.bare(link, JointType::kFixed, {0.0}, 0.0, {identity3(), {kLength, 0.0, 0.0}}, identity_pose());
  builder.description().gravity = {0.0, -9.81, 0.0};
  const double across = kMass * (kLength * kLength / 12.0 + 0.025 * 0.025 / 4.0);
  const Eigen::Vector3d middle(0.5 * kLength, 0.0, 0.0);
  Eigen::Matrix<double, 6, 1> inertia;
  inertia << 0.5 * kMass * 0.025 * 0.025, 0.0, across, 0.0, 0.0, across;
  const Model rod = with_bodies(builder.build(), inertial_parameters(kMass, middle, inertia));
  const Model identified = as_identified(rod);
  const PortableModel portable = portable_model(identified);
  ASSERT_TRUE(portable.changed) << portable.remark;
  const InertialParameters phi = *portable.arm.frames()[link].body->phi;
  EXPECT_NEAR(phi[0], kMass, 0.02 * kMass);
  EXPECT_NEAR(phi[1], 0.5 * kLength * kMass, 1e-6);
  EXPECT_NEAR(phi[9], across + kMass * middle.squaredNorm(), 1e-6);
  ASSERT_EQ(portable.bodies.size(), 1U);
  EXPECT_EQ(portable.bodies[0].mass, phi[0]);
  EXPECT_EQ(portable.bodies[0].undetermined, (std::vector<std::string>{"m", "hz", "Lxx", "Lxy", "Lyy", "Lxz", "Lyz"}));
  const ExportedModel exported = exported_model(identified);
  const std::string words = "<!-- not determined by torques alone: m, hz, Lxx, Lxy, Lyy, Lxz, Lyz -->";
  EXPECT_NE(to_sdf(exported.arm, exported.extras).find(words), std::string::npos) << to_sdf(exported.arm, exported.extras);
  EXPECT_NE(to_urdf(exported.arm, exported.extras).find(words), std::string::npos);
}

// A geared arm of the size of a UR5: what the gears of its first joints feel is in no link alone.
class GearedArm : public testing::Test {
 protected:
  GearedArm() : drawing_(build(1.0)) {}

  // Chain of yaw, pitch, pitch, pitch, yaw, pitch.
  static Model build(double heavier) {
    ArmBuilder builder("geared", 6, 3);
    const double places[][3] = {{0, 0, 0.09}, {0, 0.136, 0}, {0, -0.12, 0.425}, {0, 0, 0.392}, {0, 0.093, 0}, {0, 0, 0.095}};
    const double masses[] = {3.7, 8.4, 2.3, 1.2, 1.2, 0.25};
    const double lengths[] = {0.1, 0.43, 0.39, 0.1, 0.1, 0.05};
    for (int i = 0; i < 6; ++i) {
      const bool upright = i == 0 || i == 4;
      // The joint's axis is z of the frame: of a pitch it is the y axis of the link before.
      const Mat3d R = upright ? identity3() : rotation_x(-M_PI / 2);
      const Mat3d back = upright ? identity3() : rotation_x(M_PI / 2);
      const int k = builder.link(i - 1, JointType::kRevolute, builder.unit(i), 0.0, {R, {places[i][0], places[i][1], places[i][2]}}, {back, {0, 0, 0}});
      const double m = masses[i] * (i == 1 ? heavier : 1.0), l = lengths[i], r = 0.05;
      Eigen::Matrix<double, 6, 1> inertia;
      inertia << m * (l * l / 12 + r * r / 4), 0, m * (l * l / 12 + r * r / 4), 0, 0, m * r * r / 2;
      builder.description().frames[static_cast<size_t>(k)].body->phi = inertial_parameters(m, {0.0, 0.01, 0.45 * l}, inertia);
    }
    builder.description().gravity = {0, 0, -9.81};
    return builder.build();
  }

  // Identified: rotor inertias of joints where torques tell them, those of the first two joints within their links,
  // which are then possible only as heavier ones.
  Model identified() const {
    ModelDescription d = build(0.93).description();
    for (int i = 2; i < 6; ++i) {
      EffectTerm rotor;
      rotor.effect = "rotor_inertia";
      rotor.axis = {VectorXd::Unit(6, i), 0.0};
      rotor.values["inertia"] = i < 3 ? 0.9 : 0.1;
      d.effects.push_back(rotor);
    }
    (*d.frames[0].body->phi)[9] += 1.3;
    (*d.frames[1].body->phi)[6] += 1.2;
    d.identified = IdentifiedBase{};
    for (size_t k = 0; k < d.frames.size(); ++k) d.frames[k].body->prior = drawing_.frames()[k].body->phi;
    return Model(std::move(d));
  }

  // Torques of bodies and rotors at random states.
  static MatrixXd torques(const Model& arm) {
    RigidBodyDynamics dynamics(arm, *arm.inertial_values());
    Random random(8);
    MatrixXd out(arm.joints(), 20);
    for (Eigen::Index k = 0; k < out.cols(); ++k) {
      const VectorXd q = random.vector(6, -2.0, 2.0), dq = random.vector(6, -1.0, 1.0), ddq = random.vector(6, -2.0, 2.0);
      VectorXd tau(6);
      dynamics.inverse_dynamics(q, dq, ddq, tau);
      for (const EffectTerm& term : arm.effects())
        tau += term.values.at("inertia") * ddq.cwiseProduct(term.axis.coefficients);
      out.col(k) = tau;
    }
    return out;
  }

  static void expect_masses_of(const Model& drawing, const Model& exported) {
    for (const auto [k] : drawing.bodies()) {
      const double mass = (*drawing.frames()[k].body->phi)[0];
      EXPECT_NEAR((*exported.frames()[k].body->phi)[0], mass, 0.2 * mass) << drawing.frames()[k].name;
    }
  }

  Model drawing_;
};

TEST_F(GearedArm, ExportedBodiesHaveThePriorMassesAndTheSameTorques) {
  const Model model = identified();
  ASSERT_LT(least_eigenvalue(*model.inertial_values()), 0.0);
  const MatrixXd before = torques(model);
  for (const RotorPlace place : {RotorPlace::kBodies, RotorPlace::kArmatures}) {
    const PortableModel portable = portable_model(model, std::nullopt, place);
    ASSERT_TRUE(portable.changed) << portable.remark;
    EXPECT_GT(least_eigenvalue(*portable.arm.inertial_values()), 0.0);
    expect_masses_of(drawing_, portable.arm);
    EXPECT_LT((torques(portable.arm) - before).cwiseAbs().maxCoeff(), 1e-8 * before.cwiseAbs().maxCoeff());
  }
}

// Where the format has a place for it, the gear's inertia is no link's.
TEST_F(GearedArm, RotorInertiaIsExportedAsArmature) {
  const PortableModel portable = portable_model(identified(), std::nullopt, RotorPlace::kArmatures);
  ASSERT_TRUE(portable.changed) << portable.remark;
  ASSERT_EQ(portable.arm.effects().size(), 6U);
  for (const EffectTerm& term : portable.arm.effects()) {
    if (term.axis.coefficients[0] == 1.0) {
      EXPECT_NEAR(term.values.at("inertia"), 1.3, 0.1);
    }
    if (term.axis.coefficients[1] == 1.0) {
      EXPECT_NEAR(term.values.at("inertia"), 1.2, 0.1);
    }
  }
  const double drawn = (*drawing_.frames()[1].body->phi)[6];
  EXPECT_NEAR((*portable.arm.frames()[1].body->phi)[6], drawn, 0.3 * drawn);
}

TEST(PortableModel, KeepsFixedAndUnidentifiedParameters) {
  ArmBuilder builder("facts", 2, 7);
  const int fact = builder.link(-1, JointType::kRevolute, {1.0, 0.0}, 0.0, identity_pose(), identity_pose());
  const int other = builder.link(fact, JointType::kRevolute, {0.0, 1.0}, 0.0, {identity3(), {0.3, 0.0, 0.1}}, identity_pose());
  builder.description().frames[fact].body->fixed = true;
  const Model arm = builder.build();
  EXPECT_FALSE(portable_model(arm).changed);
  EXPECT_TRUE(portable_model(arm).bodies.empty());
  const Model identified = as_identified(arm);
  const PortableModel portable = portable_model(identified);
  ASSERT_TRUE(portable.changed) << portable.remark;
  EXPECT_EQ(*portable.arm.frames()[fact].body->phi, *arm.frames()[fact].body->phi);
  EXPECT_NE(*portable.arm.frames()[other].body->phi, *identified.frames()[other].body->phi);
  ASSERT_EQ(portable.bodies.size(), 2U);
  EXPECT_TRUE(portable.bodies[0].undetermined.empty());
  EXPECT_FALSE(portable.bodies[1].undetermined.empty());
}

}  // namespace
}  // namespace veridyn
