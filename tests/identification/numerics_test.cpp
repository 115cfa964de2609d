#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "identification/synthetic_recording.hpp"
#include "support/near.hpp"
#include "veridyn/identification/identification.hpp"
#include "veridyn/identification/pseudo_inertia.hpp"
#include "veridyn/identification/verdict.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/identification/base_parameters.hpp"

// Recordings and columns at the edge of what can be identified: an answer is right, or it is a status
// that says why there is none.

namespace veridyn {
namespace {

Model planar() { return read_model(VERIDYN_SOURCE_DIR "/data/robots/planar-2r.yaml"); }

Recording recorded(const Model& arm, double noise = 0.01) {
  MotionShape shape;
  shape.duration = 12.0;
  Recording r = synthetic_recording(arm, shape);
  r.tau += noise_like(r.tau, noise, 3);
  return r;
}

IdentificationOptions with(Method method) {
  IdentificationOptions o;
  o.method = method;
  return o;
}

// tau = Y phi is linear: torques in other units give parameters in these units, and the same errors.
TEST(Torques, InUnitsOffByAThousandGiveParametersOffByAThousand) {
  const Recording r = recorded(planar());
  for (const Method method : {Method::kOls, Method::kWls}) {
    const Identification in_si = identify(planar(), r, with(method));
    ASSERT_EQ(in_si.status, IdentificationStatus::kDone);
    for (const double factor : {1e-9, 1e-3, 1e3, 1e4}) {
      Recording other = r;
      other.tau *= factor;
      const Identification id = identify(planar(), other, with(method));
      ASSERT_EQ(id.status, IdentificationStatus::kDone) << factor << ": " << id.reason;
      EXPECT_TRUE(near(id.parameters / factor, in_si.parameters, 1e-9 * in_si.parameters.norm())) << factor;
      EXPECT_TRUE(near(id.train_error.relative, in_si.train_error.relative, 1e-9)) << factor;
    }
  }
}

// Two equal columns have one sum, wherever it is written.
TEST(AnEffectThatIsGivenTwice, GivesOneBaseParameterAndTheSameError) {
  ModelDescription d = planar().description();
  const auto viscous = std::find_if(d.effects.begin(), d.effects.end(),
                                    [](const EffectTerm& e) { return e.effect == "viscous_friction"; });
  ASSERT_NE(viscous, d.effects.end());
  d.effects.push_back(EffectTerm(*viscous));
  const Model twice{d};
  const Recording r = recorded(planar(), 0.0);
  const Identification one = identify(planar(), r, with(Method::kWls));
  const Identification two = identify(twice, r, with(Method::kWls));
  ASSERT_EQ(two.status, IdentificationStatus::kDone) << two.reason;
  EXPECT_EQ(two.base.size(), one.base.size());
  EXPECT_TRUE(near(two.train_error.relative, one.train_error.relative, 1e-9));
}

TEST(JointsThatMoveAsOne, AreFittedOrReportedAsUndetermined) {
  const Model arm = planar();
  for (const double ratio : {1.0, -1.0, 0.5}) {
    MatrixXd ddq;
    MotionShape shape;
    shape.duration = 12.0;
    Recording r = sines(arm, shape, ddq);
    r.q.col(1) = ratio * r.q.col(0);
    r.dq.col(1) = ratio * r.dq.col(0);
    ddq.col(1) = ratio * ddq.col(0);
    r.tau = torques(arm, r, ddq);
    const Identification id = identify(arm, r, with(Method::kWls));
    if (id.status == IdentificationStatus::kDone) {
      EXPECT_LT(id.train_error.relative.maxCoeff(), 1e-4) << ratio;
    } else {
      EXPECT_EQ(id.status, IdentificationStatus::kRankDeficient) << ratio;
      EXPECT_FALSE(id.model.has_value());
      EXPECT_NE(id.reason.find(" of 10 base parameters"), std::string::npos) << id.reason;
    }
  }
}

// A joint that rests in one recording of several does not count as still.
TEST(AJointThatRestsInTheLastRecording, IsNotReportedAsNeverMoving) {
  MatrixXd ddq;
  MotionShape shape;
  shape.duration = 12.0;
  Recording last = sines(planar(), shape, ddq);
  last.q.col(1).setConstant(0.3);
  last.dq.col(1).setZero();
  ddq.col(1).setZero();
  last.tau = torques(planar(), last, ddq);
  last.source = "last";
  const Identification id = identify(planar(), std::vector<Recording>{recorded(planar()), last}, {}, with(Method::kWls));
  EXPECT_EQ(id.status, IdentificationStatus::kDone) << id.reason;
  EXPECT_TRUE(id.still_joints.empty());
}

// What a joint that never moves would tell may be known already.
TEST(AStillJoint, IsAcceptedIfAllParametersAreDetermined) {
  ModelDescription d = planar().description();
  d.frames[1].body->fixed = true;
  for (EffectTerm& term : d.effects) term.fixed = term.axis.coefficients[1] != 0.0;
  const Model arm{d};
  MatrixXd ddq;
  MotionShape shape;
  shape.duration = 12.0;
  Recording r = sines(arm, shape, ddq);
  r.q.col(1).setConstant(0.3);
  r.dq.col(1).setZero();
  ddq.col(1).setZero();
  r.tau = torques(arm, r, ddq);
  for (const Method method : {Method::kWls, Method::kFeasible}) {
    const Identification id = identify(arm, r, with(method));
    ASSERT_EQ(id.status, IdentificationStatus::kDone) << id.reason;
    EXPECT_EQ(id.still_joints, std::vector<std::string>{"elbow"});
    EXPECT_TRUE(near(id.model->effects()[0].values.at("coefficient") * VectorXd::Ones(1), VectorXd::Constant(1, 0.8), 1e-3));
    EXPECT_LT(id.train_error.relative[0], 1e-3);
  }
}

// Every joint that stands still is named, and the recordings are counted.
TEST(StillJoints, AreReportedInOneSentence) {
  Recording r = recorded(planar());
  r.q.rowwise() = r.q.row(0).eval();
  r.dq.setZero();
  for (const bool prior : {false, true}) {
    IdentificationOptions options;
    if (prior) options.prior = planar();
    const Identification id = identify(planar(), std::vector<Recording>{r, r, r}, {}, options);
    EXPECT_EQ(id.status, IdentificationStatus::kRankDeficient);
    EXPECT_NE(id.reason.find("synthetic and 2 more: joints shoulder, elbow never move (--fix shoulder=VALUE holds a joint there); gravity, offsets and forces of position of an arm at rest are identified with --at-rest"), std::string::npos) << id.reason;
  }
}

// A box of one body is kept to, and named where it is the limit.
TEST(ABoundingBox, OfMassAndCentreIsRespectedAndNamed) {
  ModelDescription d = planar().description();
  d.frames[1].body->box.mass_max = 1.5;  // its mass is 2.5 kg
  d.frames[1].body->box.com_reach = 0.1;  // its centre is at 0.2 m
  const Identification id = identify(Model(d), recorded(planar()));
  ASSERT_TRUE(id.model.has_value()) << id.reason;
  EXPECT_LE(id.parameters[10], 1.5);
  EXPECT_LE(std::abs(id.parameters[11]), 0.1 * id.parameters[10] + 1e-12);
  EXPECT_NE(std::find(id.active_constraints.begin(), id.active_constraints.end(), "m_fore <= 1.5"), id.active_constraints.end());
  EXPECT_NE(id.report().find("m_fore <= 1.5"), std::string::npos);
}

// A model is judged on samples, or not at all.
TEST(Evaluation, WithoutUsableSamplesReportsAReason) {
  Recording brief = rows_of(recorded(planar()), 0, 200);
  brief.source = "brief";
  const Identification id = evaluate(planar(), brief);
  EXPECT_FALSE(id.model.has_value());
  EXPECT_NE(id.reason.find("brief: no usable samples are left"), std::string::npos) << id.reason;
  EXPECT_THROW(evaluate(planar(), std::vector<Recording>{}), InvalidInput);
  EXPECT_THROW(evaluate(read_model("psm-3dof"), brief), InvalidInput);
}

// An arm whose parameters are all facts has none to identify.
TEST(AnArm, WithOnlyFixedParametersIsRefusedWithAReason) {
  for (const Method method : {Method::kOls, Method::kFeasible, Method::kIv}) {
    const Identification id = identify(with_fixed_parameters(planar()), recorded(planar()), with(method));
    EXPECT_EQ(id.status, IdentificationStatus::kNoData);
    EXPECT_FALSE(id.model.has_value());
    EXPECT_NE(id.reason.find("declares all as facts"), std::string::npos) << id.reason;
  }
}

// No error is a share of a torque that is zero: such a joint is named, and 0 % would be a lie.
TEST(AJointWithoutTorque, IsNamedAndHasNoError) {
  Recording r = recorded(planar());
  r.tau.col(1).setZero();
  const Identification id = identify(planar(), r, with(Method::kWls));
  ASSERT_TRUE(id.model.has_value()) << id.reason;
  EXPECT_TRUE(std::isfinite(id.train_error.relative[0]));
  EXPECT_TRUE(std::isinf(id.train_error.relative[1]));
  const IdentificationVerdict verdict = verdict_of(id);
  ASSERT_EQ(verdict.joints.size(), 2U);
  EXPECT_NE(verdict.joints[0].state, IdentifiedState::kNoTorque);
  EXPECT_EQ(verdict.joints[1].state, IdentifiedState::kNoTorque);
  EXPECT_NE(verdict.sentence.find("elbow has no torque"), std::string::npos) << verdict.sentence;
  EXPECT_EQ(id.report().find("inf"), std::string::npos) << id.report();
}

// Beside torques whose squares vanish any model, a prior too, would be without error.
TEST(Torques, ThatAreZeroThroughoutAreRefused) {
  const Recording good = recorded(planar());
  for (const double factor : {0.0, 1e-18, 1e-200, 1e-310}) {
    Recording none = good;
    none.source = "none";
    none.tau *= factor;
    IdentificationOptions options;
    options.prior = planar();
    for (const Identification& id : {identify(planar(), none), identify(planar(), none, options), evaluate(planar(), none)}) {
      EXPECT_FALSE(id.model.has_value()) << factor;
      EXPECT_NE(id.reason.find("none: the torques of all joints are zero throughout"), std::string::npos) << id.reason;
    }
    try {
      identify(planar(), good, none);
      ADD_FAILURE() << "a held-out error of torques that are zero";
    } catch (const InvalidInput& error) {
      EXPECT_NE(std::string(error.what()).find("none: the torques"), std::string::npos) << error.what();
    }
  }
}

// Torques below those of the lightest possible body: the best possible arm is worse than none.
TEST(Torques, TooSmallForAnyBodyAreRefused) {
  Recording tiny = recorded(planar());
  tiny.tau *= 1e-9;
  IdentificationOptions with_prior;
  with_prior.prior = planar();
  for (const IdentificationOptions& options : {IdentificationOptions{}, with_prior}) {
    const Identification id = identify(planar(), tiny, options);
    EXPECT_EQ(id.status, IdentificationStatus::kNotConverged);
    EXPECT_FALSE(id.model.has_value());
    EXPECT_NE(id.reason.find("too small for the lightest one"), std::string::npos) << id.reason;
  }
  EXPECT_TRUE(identify(planar(), tiny, with(Method::kWls)).model.has_value());
}

// A prior fills what torques leave open. Where it is far from the arm, the fit is as good as without,
// or a status says that it is not.
TEST(APrior, FarFromTheArmGivesAnEquallyGoodFitOrAStatus) {
  const Recording r = recorded(planar());
  int done = 0, refused = 0;
  for (const double factor : {1e-6, 1e-3, 1.0, 1e3, 1e6}) {
    ModelDescription d = planar().description();
    for (Frame& frame : d.frames)
      if (frame.body) *frame.body->phi *= factor;
    for (const double units : {1e-3, 1.0, 1e3}) {
      Recording other = r;
      other.tau *= units;
      const Identification without = identify(planar(), other);
      IdentificationOptions options;
      options.prior = Model(d);
      const Identification id = identify(planar(), other, options);
      if (id.status != IdentificationStatus::kDone) {
        EXPECT_NE(id.reason.find("prior 'planar-2r' does not let it"), std::string::npos) << id.reason;
        EXPECT_FALSE(id.model.has_value());
        ++refused;
        continue;
      }
      ++done;
      EXPECT_LE(id.objective, 1.1001 * without.objective) << factor << ", " << units;
      for (Eigen::Index b = 0; b < 2; ++b)
        EXPECT_GE(smallest_eigenvalue(pseudo_inertia(id.parameters.segment<10>(10 * b))), 0.0);
    }
  }
  EXPECT_GE(done, 5);
  EXPECT_GE(refused, 1);
}

// Two columns that differ by a share of noise: with less of it the rank falls once, and never comes
// back; whatever it is, the kept columns predict what all of them do.
TEST(TheRank, DropsByOneAsColumnsBecomeCollinear) {
  Random random(8);
  const VectorXd a = random.vector(60, -1, 1), b = random.vector(60, -1, 1), noise = random.vector(60, -1, 1);
  int before = 3;
  for (int k = 1; k <= 32; ++k) {
    const double share = std::pow(10.0, -0.5 * k);
    MatrixXd A(60, 3);
    A << a, b, a + share * noise;
    SquareRootInformation f(std::vector<std::string>{"a", "b", "c"});
    f.absorb(A, VectorXd::Zero(60));
    const BaseParameters base = base_parameters(f, {0, 1, 2});
    EXPECT_GE(base.size(), 2) << share;
    EXPECT_LE(base.size(), before) << share;
    before = base.size();
    MatrixXd kept(60, base.size());
    for (int j = 0; j < base.size(); ++j) kept.col(j) = A.col(base.independent[j]);
    const double alike = base.size() == 3 ? 0.0 : 2.0 * share * noise.norm();
    EXPECT_LE((kept * base.K - A).norm(), alike + 1e-13 * A.norm()) << share;
  }
  EXPECT_EQ(before, 2);
}

}  // namespace
}  // namespace veridyn
