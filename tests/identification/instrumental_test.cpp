#include <gtest/gtest.h>

#include <cmath>

#include "support/near.hpp"
#include "support/random.hpp"
#include "veridyn/identification/identification.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/joint_torques.hpp"

// Noise in the recorded motion biases least squares and not the estimates with the motion without noise.

namespace veridyn {
namespace {

// Ten periods of 8 s at 100 Hz, with white noise of these deviations.
Recording swings(const Model& arm, double position_noise, double velocity_noise, double torque_noise, unsigned seed) {
  Random random(seed);
  Recording r;
  r.source = "swings";
  const Eigen::Index rows = 8001;
  r.time = VectorXd::LinSpaced(rows, 0.0, 80.0);
  r.q = MatrixXd::Zero(rows, 2);
  r.dq = r.q;
  MatrixXd ddq = r.q;
  for (Eigen::Index k = 0; k < rows; ++k) {
    for (int i = 0; i < 2; ++i) {
      for (int h = 1; h <= 4; ++h) {
        const double w = 2.0 * M_PI * h / 8.0, a = 0.5 / h, phase = 1.3 * h + 2.1 * i;
        r.q(k, i) += a * std::sin(w * r.time[k] + phase);
        r.dq(k, i) += a * w * std::cos(w * r.time[k] + phase);
        ddq(k, i) -= a * w * w * std::sin(w * r.time[k] + phase);
      }
    }
  }
  r.tau.resize(rows, 2);
  for (Eigen::Index k = 0; k < rows; ++k)
    r.tau.row(k) = joint_torques(arm, r.q.row(k).transpose(), r.dq.row(k).transpose(), ddq.row(k).transpose()).transpose();
  const auto noise = [&](MatrixXd& m, double deviation) {
    for (Eigen::Index k = 0; k < rows; ++k) m.row(k) += deviation * std::sqrt(3.0) * random.vector(2, -1.0, 1.0).transpose();
  };
  noise(r.q, position_noise);
  noise(r.dq, velocity_noise);
  noise(r.tau, torque_noise);
  return r;
}

IdentificationOptions with(Method method) {
  IdentificationOptions o;
  o.method = method;
  o.friction = JointFriction::kFile;
  o.preprocessing.cutoff = 10.0;
  o.preprocessing.signal_cutoff_ratio = 2.0;
  o.choose_velocities = false;
  return o;
}

// Relative error of a viscous friction, which noise of the velocity pulls down.
double error_of_damping(const Identification& id, const Model& arm) {
  double worst = 0.0;
  for (std::size_t e = 0; e < arm.effects().size(); ++e) {
    if (arm.effects()[e].effect != "viscous_friction") continue;
    const double truth = arm.effects()[e].values.at("coefficient");
    worst = std::max(worst, std::abs(id.model->effects()[e].values.at("coefficient") / truth - 1.0));
  }
  return worst;
}

// Viscous friction alone: its column is the velocity, whose noise attenuates least squares.
Model viscous_arm() {
  ModelDescription d = read_model("planar-2r").description();
  std::vector<EffectTerm> kept;
  for (const EffectTerm& term : d.effects) {
    if (term.effect == "viscous_friction") kept.push_back(term);
  }
  d.effects = kept;
  return Model(std::move(d));
}

TEST(Instruments, ReduceTheBiasOfANoisyVelocityToAThird) {
  const Model arm = viscous_arm();
  const Recording r = swings(arm, 1e-4, 0.5, 0.05, 3);
  const Identification ls = identify(arm, r, with(Method::kWls));
  const Identification iv = identify(arm, r, with(Method::kIv));
  const Identification didim = identify(arm, r, with(Method::kDidim));
  EXPECT_GT(error_of_damping(ls, arm), 0.08);
  EXPECT_LT(error_of_damping(iv, arm), 0.3 * error_of_damping(ls, arm));
  EXPECT_LT(error_of_damping(didim, arm), 0.3 * error_of_damping(ls, arm));
  EXPECT_TRUE(ls.endogeneity.empty());
  ASSERT_EQ(iv.endogeneity.size(), 2U);
  for (const EndogeneityTest& t : iv.endogeneity) {
    EXPECT_LT(t.p_value, 1e-4);
    EXPECT_GT(t.numerator_freedom, 0.0);
  }
  // Least squares is the best fit along the measured motion, and stays below the others there.
  EXPECT_GE(iv.objective, ls.objective);
  EXPECT_NE(iv.report().find("Durbin-Wu-Hausman"), std::string::npos);
  EXPECT_EQ(ls.report().find("Durbin-Wu-Hausman"), std::string::npos);
}

// Without noise in the motion all agree, and the test does not cry: of ten seeds and two joints at most four below 0.05.
TEST(Instruments, AgreeWithLeastSquaresForANoiseFreeMotion) {
  const Model arm = viscous_arm();
  int small = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    // A trace of noise, so that the two motions differ at all.
    const Recording r = swings(arm, 1e-7, 1e-6, 0.1, seed);
    const Identification iv = identify(arm, r, with(Method::kIv));
    for (const EndogeneityTest& t : iv.endogeneity) small += t.p_value < 0.05 ? 1 : 0;
    if (seed > 2) continue;
    const Identification ls = identify(arm, r, with(Method::kWls));
    for (std::size_t k = 0; k < ls.base.size(); ++k)
      EXPECT_NEAR(iv.base[k].value, ls.base[k].value, 0.5 * ls.base[k].std + 1e-9) << ls.base[k].name;
  }
  EXPECT_LE(small, 4);
}

TEST(Instruments, HaveDeviationsThatCoverTheErrors) {
  const Model arm = viscous_arm();
  for (const Method method : {Method::kIv, Method::kDidim}) {
    const Identification id = identify(arm, swings(arm, 1e-4, 0.2, 0.05, 5), with(method));
    ASSERT_TRUE(id.model.has_value());
    for (const BaseValue& b : id.base) EXPECT_GT(b.std, 0.0) << b.name;
    EXPECT_LT(error_of_damping(id, arm), 0.1);
  }
}

// The jackknife of two clusters, or of one, is no standard deviation: it is that of least squares, which says so.
TEST(Instruments, HaveNoDeviationsFromTwoClusters) {
  const Model arm = viscous_arm();
  const Recording r = rows_of(swings(arm, 1e-5, 1e-4, 0.01, 5), 0, 350);
  for (const Method method : {Method::kWls, Method::kIv, Method::kDidim}) {
    IdentificationOptions o = with(method);
    const Identification id = identify(arm, r, o);
    ASSERT_TRUE(id.model.has_value()) << id.reason;
    ASSERT_LT(id.factors.front().blocks.size(), 3U);
    for (const BaseValue& b : id.base) EXPECT_TRUE(std::isnan(b.std)) << b.name << ": " << b.std;
  }
}

// A joint whose parameters are all facts has nothing that could be biased; the other one is identified beside it.
TEST(Instruments, LeaveAJointOfFixedParametersOutOfTheTest) {
  const Model truth = viscous_arm();
  ModelDescription d = truth.description();
  d.frames[1].body->fixed = true;
  for (EffectTerm& term : d.effects) term.fixed = term.axis.coefficients[1] != 0.0;
  for (const Method method : {Method::kIv, Method::kDidim}) {
    const Identification id = identify(Model(d), swings(truth, 1e-5, 1e-4, 0.02, 5), with(method));
    ASSERT_TRUE(id.model.has_value()) << id.reason;
    EXPECT_LT(error_of_damping(id, truth), 0.02);
    ASSERT_EQ(id.endogeneity.size(), 2U);
    EXPECT_EQ(id.endogeneity[1].numerator_freedom, 0.0);
    EXPECT_EQ(id.endogeneity[1].p_value, 1.0);
  }
}

TEST(Instruments, RefuseAMinimumSpeed) {
  const Model arm = viscous_arm();
  IdentificationOptions o = with(Method::kIv);
  o.preprocessing.min_speed = 0.1;
  EXPECT_THROW(identify(arm, swings(arm, 1e-4, 0.1, 0.05, 5), o), InvalidInput);
}

}  // namespace
}  // namespace veridyn
