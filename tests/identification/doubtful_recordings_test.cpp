#include <gtest/gtest.h>

#include <string>

#include "identification/synthetic_recording.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/identification/identification.hpp"
#include "veridyn/identification/verdict.hpp"

// Recordings that cannot serve as what they are given for: a test with rows that were learned from, a test at rest.
namespace veridyn {
namespace {

const Model& elbow() {
  static const Model arm = read_model("elbow-6r");
  return arm;
}

Recording recorded(const std::string& source, unsigned seed, const Model& arm = elbow()) {
  MotionShape shape;
  shape.duration = 40.0;
  shape.period = 10.0;
  shape.seed = seed;
  Recording r = synthetic_recording(arm, shape);
  r.tau += noise_like(r.tau, 1e-3, seed);
  r.source = source;
  return r;
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// A copy, and a piece with times of its own.
TEST(ATestRecording, WithTrainingRowsIsNotHeldOut) {
  const Recording train = recorded("train", 1);
  Recording copy = train, piece = rows_of(train, 3000, 2500);
  copy.source = "copy";
  piece.source = "piece";
  piece.time.array() -= 7.0;
  for (const Recording& test : {copy, piece}) {
    const Identification id = identify(elbow(), train, test);
    ASSERT_EQ(id.warnings.size(), 1U);
    EXPECT_TRUE(has(id.warnings[0], test.source + ": its rows are rows of train, which is learned from")) << id.warnings[0];
    EXPECT_FALSE(verdict_of(id).held_out);
    EXPECT_FALSE(has(verdict_of(id).sentence, "held out")) << verdict_of(id).sentence;
    EXPECT_TRUE(has(id.report(), "learned from")) << id.report();
  }
  const Identification id = identify(elbow(), train, recorded("other", 2));
  EXPECT_TRUE(id.warnings.empty());
  EXPECT_TRUE(verdict_of(id).held_out);
}

// Other rows of one file are held out, and the same ones are not.
TEST(ATestRecording, OfOtherRowsOfAFileIsHeldOut) {
  const Recording r = recorded("file", 1);
  for (const long first : {4000L, 3000L}) {
    IdentificationOptions how;
    how.preprocessing.row_count = 4000;
    how.test_preprocessing = how.preprocessing;
    how.test_preprocessing->first_row = first;
    EXPECT_EQ(verdict_of(identify(elbow(), r, r, how)).held_out, first == 4000);
  }
}

// An arm at rest, whose dry friction holds torques of its own, and one that moves its last joint alone.
TEST(ATestRecording, OfAJointAtRestGivesNoVerdictForIt) {
  const Recording train = recorded("train", 1);
  for (const bool wrist : {false, true}) {
    Recording rest = recorded("rest", 2);
    const int still = wrist ? 5 : 6;
    rest.q.leftCols(still).rowwise() = rest.q.row(0).leftCols(still).eval();
    rest.dq.leftCols(still).setZero();
    rest.tau.leftCols(still).rowwise() = rest.tau.row(0).leftCols(still).eval();
    const Identification id = identify(elbow(), train, rest);
    const IdentificationVerdict v = verdict_of(id);
    for (int i = 0; i < still; ++i) EXPECT_EQ(v.joints[static_cast<size_t>(i)].state, IdentifiedState::kCannotTell) << i;
    EXPECT_EQ(v.joints[5].state == IdentifiedState::kCannotTell, !wrist);
    EXPECT_TRUE(has(v.sentence, "in the test recordings")) << v.sentence;
    EXPECT_FALSE(has(v.sentence, "over 1000 times")) << v.sentence;
    EXPECT_EQ(id.warnings.size(), wrist ? 0U : 1U);
  }
}

// A training recording in degrees makes no test seem at rest.
TEST(ATestRecording, ThatMovesAsUsualIsNotAtRest) {
  Recording degrees = recorded("degrees", 3);
  degrees.q *= 180.0 / M_PI;
  degrees.dq *= 180.0 / M_PI;
  const Identification id = identify(elbow(), {recorded("one", 1), recorded("two", 2), degrees}, recorded("test", 4));
  EXPECT_TRUE(id.still_in_test.empty());
}

// A torque that depends on no motion is at no noise, however little a model leaves of it.
TEST(ATorque, ThatAConstantExplainsAsWellDoesNotFollowFromTheMotion) {
  std::vector<Recording> all = {recorded("one", 1), recorded("test", 2)};
  for (Recording& r : all) {
    r.tau = noise_like(r.tau, 1.0, 5);
    for (auto column : r.tau.colwise()) column.array() = 30.0 + column.array() / column.cwiseAbs().maxCoeff();
  }
  ModelDescription bare = elbow().description();
  bare.effects.clear();
  IdentificationOptions how;
  how.friction = JointFriction::kPlain;  // with offsets
  const IdentificationVerdict v = verdict_of(identify(Model(std::move(bare)), all[0], all[1], how));
  for (const IdentifiedJoint& joint : v.joints) EXPECT_EQ(joint.state, IdentifiedState::kCannotTell) << joint.error;
  EXPECT_TRUE(has(v.sentence, "and a constant torque hardly more: little of it follows from the motion")) << v.sentence;
}

// The elbow arm with this much more mass at its flange, or with other friction at its shoulder.
Model changed(double mass, double friction) {
  ModelDescription d = elbow().description();
  (*d.frames.back().body->phi)[0] += mass;
  for (EffectTerm& term : d.effects)
    if (term.effect == "coulomb_friction" && term.axis.coefficients[1] != 0.0) term.values["level"] += friction;
  return Model(std::move(d));
}

// One of three with a load, or with other friction: it is the one that is named, with its joint.
TEST(TrainingRecordings, WithADifferentLoadOrFrictionAreReported) {
  for (const bool load : {true, false}) {
    const Recording other = recorded("other", 3, load ? changed(0.5, 0.0) : changed(0.0, 6.0));
    const Identification id = identify(elbow(), {recorded("one", 1), other, recorded("two", 2)});
    ASSERT_EQ(id.warnings.size(), 1U);
    EXPECT_EQ(id.warnings[0].find("other differs from the other training recordings: "), 0U) << id.warnings[0];
    EXPECT_TRUE(load || has(id.warnings[0], "of the torque of shoulder in other")) << id.warnings[0];
    EXPECT_TRUE(has(id.warnings[0], "Another load, friction or time?")) << id.warnings[0];
    EXPECT_TRUE(has(id.report(), id.warnings[0]));
  }
  Recording spoiled = recorded("other", 3);
  spoiled.tau.col(2) = spoiled.tau.col(1);
  const Identification wrong = identify(elbow(), {recorded("one", 1), spoiled, recorded("two", 2)});
  ASSERT_FALSE(wrong.warnings.empty());
  EXPECT_TRUE(has(wrong.warnings.back(), " in other, a fit to this one alone ")) << wrong.report();
  EXPECT_TRUE(has(wrong.warnings.back(), "No arm of this file fits other alone: a wrong file or column, or something that the model lacks?")) << wrong.report();
  // No arm fits a change of load midway; what it does to another recording shows.
  Recording glued = recorded("other", 3);
  glued.tau.bottomRows(4000) = recorded("loaded", 3, changed(1.5, 0.0)).tau.bottomRows(4000);
  const Identification changing = identify(elbow(), {recorded("one", 1), glued, recorded("two", 2)});
  ASSERT_FALSE(changing.warnings.empty());
  const std::string& sentence = changing.warnings.back();
  EXPECT_EQ(sentence.find("other differs"), 0U) << sentence;
  const std::size_t leaves = sentence.find("leaves ") + 7, alone = sentence.find(" alone ") + 7;
  EXPECT_NE(std::stod(sentence.substr(leaves)), std::stod(sentence.substr(alone))) << sentence;
  const Identification two = identify(elbow(), {recorded("one", 1), recorded("loaded", 2, changed(0.5, 0.0))});
  ASSERT_EQ(two.warnings.size(), 1U);
  EXPECT_EQ(two.warnings[0].find("one and loaded differ: "), 0U) << two.warnings[0];
}

// Neither noise nor an effect that the model does not have makes recordings differ.
TEST(TrainingRecordings, OfOneArmCauseNoWarning) {
  for (const double share : {1e-3, 0.2}) {
    std::vector<Recording> all = {recorded("one", 1), recorded("two", 2), recorded("three", 3)};
    for (Recording& r : all) {
      r.tau += noise_like(r.tau, share, 7);
      if (share > 0.1) r.tau.col(1).array() += 20.0 * r.q.col(2).array().square() * r.dq.col(1).array();
    }
    const Identification id = identify(elbow(), {all[0], all[1], all[2]});
    EXPECT_TRUE(id.warnings.empty()) << id.warnings[0];
    EXPECT_GT(id.train_error.relative[1], 0.2 * share);
  }
}

}  // namespace
}  // namespace veridyn
