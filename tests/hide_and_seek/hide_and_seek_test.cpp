#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "hide_and_seek/judge.hpp"
#include "hide_and_seek/outside.hpp"
#include "veridyn/files/model_file.hpp"

// A few cases of the scoreboard that must never be lost: different arms, different effects, and
// nothing hidden. The whole board is veridyn-hide-and-seek.

namespace veridyn::seek {
namespace {

struct Played {
  HiddenCase hidden;
  Diagnosis diagnosis;
  Verdict verdict;
};

// `recordings` to learn from (0: all), of motions with this share of the usual amplitude.
Played play(const CaseRequest& request, size_t recordings = 0, double reach = 1.0) {
  namespace fs = std::filesystem;
  const fs::path folder =
      fs::path(testing::TempDir()) / ("hide-and-seek-" + request.arm + "-" +
                                      (request.effects.empty() ? "none" : request.effects.front()));
  fs::create_directories(folder);
  Played out{hide(request), {}, {}};
  CaseFiles files = write_case(out.hidden, folder.string(), reach);
  if (recordings > 0) files.train.resize(recordings);
  DiagnosisOptions options;
  options.identification.threads = 2;
  out.diagnosis = seek_causes(out.hidden, files, folder.string(), options);
  out.verdict = judge(out.hidden, out.diagnosis);
  fs::remove_all(folder);
  return out;
}

// Named first with joint, nothing else named, its size right to 15 %, and a smaller error on the
// recording that took no part.
void expect_found(const Played& played, const std::string& parameter) {
  const std::string report = played.diagnosis.report();
  ASSERT_TRUE(played.verdict.first) << report;
  EXPECT_EQ(played.verdict.extras, 0) << report;
  EXPECT_LT(played.verdict.error_ratio, 0.85) << report;
  const double truth = played.hidden.causes.front().values.at(parameter);
  int found = 0;
  for (const FoundParameter& p : played.diagnosis.findings.front().parameters) {
    if (p.name != parameter) continue;
    ++found;
    EXPECT_NEAR(p.value, truth, 0.15 * std::abs(truth)) << report;
  }
  EXPECT_EQ(found, 1) << parameter << " is no parameter of the finding\n" << report;
}

TEST(HideAndSeek, DriftOnASixJointArm) {
  expect_found(play({"bench-6r", {"torque_drift"}, 1, 0.1, Mode::kBare}), "rate");
}

TEST(HideAndSeek, FrictionThatDiffersByDirectionOnAScara) {
  expect_found(play({"pick-scara", {"asymmetric_friction"}, 2, 0.1, Mode::kBare}),
               "viscous_difference");
}

// Presliding, which looks alike, is the first choice as long as only its constants are refined.
TEST(HideAndSeek, BacklashIsNotTakenForPreslidingOnOneNarrowRecording) {
  const Played played = play({"pick-scara", {"backlash"}, 2, 0.1, Mode::kBare}, 1, 0.4);
  EXPECT_TRUE(played.verdict.first) << played.diagnosis.report();
}

// Where a motion is narrow, the noise of the accelerations is large: an elastic transmission, made
// of their derivatives, would cancel some of it.
TEST(HideAndSeek, NoiseOfAccelerationsIsNoElasticTransmission) {
  const Played played =
      play({"pick-scara", {"load_dependent_friction"}, 19, 0.1, Mode::kBare}, 0, 0.4);
  EXPECT_TRUE(played.verdict.first) << played.diagnosis.report();
  EXPECT_EQ(played.verdict.extras, 0) << played.diagnosis.report();
}

// A load can follow a rotor there, with more numbers: it is a rival at most.
TEST(HideAndSeek, ARotorsInertiaIsNotTakenForALoadOnOneNarrowRecording) {
  const Played played = play({"pallet-4", {"rotor_inertia"}, 2, 0.1, Mode::kChanged}, 1, 0.4);
  EXPECT_TRUE(played.verdict.first) << played.diagnosis.report();
}

TEST(HideAndSeek, ACableOnAPalletizer) {
  expect_found(play({"pallet-4", {"cable_coupling"}, 2, 0.1, Mode::kBare}), "drag");
}

TEST(HideAndSeek, ViscosityThatChangesAlongTheWayOnThePsm) {
  expect_found(play({"psm-3dof", {"position_dependent_viscosity"}, 1, 0.1, Mode::kBare}), "slope");
}

TEST(HideAndSeek, NothingHiddenGivesNoName) {
  for (const char* arm : {"psm-3dof", "bench-6r"}) {
    const Played played = play({arm, {}, 1, 0.1, Mode::kBare});
    EXPECT_TRUE(played.diagnosis.findings.empty()) << played.diagnosis.report();
  }
}

// The judge itself: what it must and must not let pass.
TEST(Judge, CountsRightNamesStandInsAndWrongOnes) {
  HiddenCase hidden{{"psm-3dof", {"backlash"}, 1, 0.1, Mode::kBare},
                    make_bench("psm-3dof", 1),
                    {{"backlash", 1, -1, "", "", {{"level", 2.0}}}},
                    {},
                    {},
                    {},
                    true};
  Diagnosis d;
  d.baseline.model = read_model("psm-3dof");
  Finding right;
  right.cause = NewEffect{"backlash", {1}};
  right.parameters = {{"level", "N m", 2.1, 1.9, 2.3}};
  Finding elsewhere = right;
  elsewhere.cause = NewEffect{"backlash", {0}};
  Finding stand_in;
  stand_in.cause = NewEffect{"presliding_hysteresis", {1}};
  stand_in.rivals = {{NewEffect{"backlash", {1}}, ""}};

  EXPECT_FALSE(judge(hidden, d).first_rival);
  d.findings = {right};
  Verdict v = judge(hidden, d);
  EXPECT_TRUE(v.first && v.named == 1 && v.extras == 0 && v.intervals == 1 && v.covered == 1);
  d.findings = {elsewhere};
  v = judge(hidden, d);
  EXPECT_TRUE(!v.first && v.named == 0 && v.named_loosely == 1 && v.extras == 1);
  d.findings = {stand_in};
  v = judge(hidden, d);
  EXPECT_TRUE(!v.first && v.first_rival && v.named_rival == 1 && v.extras == 0);
  d.findings = {stand_in, right};  // the stand-in is one too many
  v = judge(hidden, d);
  EXPECT_TRUE(!v.first && v.first_rival && v.named == 1 && v.extras == 1);
  d.findings = {right};
  d.findings[0].parameters[0].low = 2.05;
  EXPECT_EQ(judge(hidden, d).covered, 0);
  d.findings = {right, elsewhere};
  EXPECT_EQ(judge(hidden, d).extras, 1);
  hidden.also_true = {{"backlash", 0, -1, "", "", {}}};
  EXPECT_EQ(judge(hidden, d).extras, 0);
  EXPECT_EQ(judge(hidden, d).named, 1);
}

// The arm warms up by 1 to 3 % from one recording to the next, and the model is of the first four.
TEST(TemperatureDrift, IsSmallFromTheModelToTodayAndNoMistakeToName) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    CaseRequest asked{"psm-3dof", {}, seed, 0.1, Mode::kChanged, Trouble::kTemperatureDrift};
    const HiddenCase hidden = hide(asked);
    ASSERT_FALSE(hidden.also_true.empty());
    for (const Cause& warmer : hidden.also_true) {
      const double before = hidden.bench.friction[warmer.joint].viscous;
      const double now = warmer.values.at("now") / before;
      EXPECT_GT(now, 0.85);
      EXPECT_LT(now, 0.96);
    }
    asked.mode = Mode::kBare;
    EXPECT_TRUE(hide(asked).also_true.empty());
  }
}

// Crosstalk looks like a cable from the other joint until its torque is asked about, and a damper that acts
// above a speed looks like pushes at the fastest moments.
TEST(HideAndSeek, CausesThatAreOnNoListBringNoOtherName) {
  for (const char* cause : {"crosstalk", "one_way_damper"}) {
    const OutsideScore score = outside_score({}, "pallet-4", cause, 31);
    EXPECT_TRUE(score.joint && (score.signals || score.worded)) << cause;
    EXPECT_EQ(score.false_names, 0) << cause;
    // A damper that ends within a few degrees of turning back is more than a curve of the speed has intervals for.
    EXPECT_GT(score.explained, std::string(cause) == "crosstalk" ? 0.8 : 0.35) << cause;
  }
}

// A force on the tip is asked about only because a joint's error depends on positions without a name; then it
// takes the place of the curve.
TEST(HideAndSeek, AForceOnTheTipIsNamedAfterTheCurveThatItExplains) {
  const OutsideScore score = outside_score({}, "pick-scara", "tip_force", 1);
  EXPECT_TRUE(score.worded);
  EXPECT_EQ(score.false_names, 0);
  EXPECT_GT(score.explained, 0.98);
}

// A torque that is recorded with a dead zone is in no constant proportion to the true one: what grows with the load is
// a part of that curve and no friction.
TEST(HideAndSeek, BesideACurveOfTheTorqueNothingElseGrowsWithIt) {
  const OutsideScore score = outside_score({}, "psm-3dof", "torque_dead_zone", 1531);
  EXPECT_TRUE(score.signals);
  EXPECT_EQ(score.false_names, 0);
}

// The end of the palletizer is its flange, and the last frame of its file its balance weight.
TEST(HideAndSeek, AForceAtTheEndOfATreeOfLinksIsNamed) {
  const OutsideScore score = outside_score({}, "pallet-4", "tip_force", 1573);
  EXPECT_TRUE(score.worded);
  EXPECT_EQ(score.false_names, 0);
}

// Names that came before it (a cable, springs, a lean of the base) are asked about anew beside it.
TEST(HideAndSeek, ALaterCauseTakesThePlaceOfTheNamesThatStoodForIt) {
  const OutsideScore score = outside_score({}, "psm-3dof", "tip_force", 1);
  EXPECT_TRUE(score.worded);
  EXPECT_EQ(score.false_names, 0);
  EXPECT_GT(score.explained, 0.98);
}

// Crosstalk on another joint, which is accepted before, is asked about again beside a stop.
TEST(HideAndSeek, AStopAndCrosstalkOnAnotherJointAreNamedTogether) {
  const Played played = play({"pick-scara", {"end_stop", "torque_crosstalk"}, 1601, 0.1, Mode::kBare});
  EXPECT_EQ(played.verdict.named, 2) << played.diagnosis.report();
  EXPECT_EQ(played.verdict.extras, 0) << played.diagnosis.report();
}

// A wrong constant of the robot file acts through positions, as a base that gives way does.
TEST(HideAndSeek, AnElasticBaseTakesThePlaceOfAWrongConstantThatStoodForIt) {
  const OutsideScore score = outside_score({}, "bench-6r", "elastic_base", 1601);
  EXPECT_TRUE(score.worded);
  EXPECT_EQ(score.false_names, 0);
}

// Without the question about a stop, this joint has a spring and a force of position; one stop predicts held-out parts
// better.
TEST(HideAndSeek, AStopTakesThePlaceOfTheNamesOnItsJoint) {
  expect_found(play({"psm-3dof", {"end_stop"}, 1502, 0.1, Mode::kBare}), "stiffness");
}

// A stop on one joint is compared with the curve of that joint; a curve of another joint stays beside it.
TEST(HideAndSeek, AStopIsNamedBesideACurveOfAnotherJoint) {
  const Played played = play({"planar-2r", {"end_stop"}, 1502, 0.1, Mode::kChanged});
  EXPECT_TRUE(played.verdict.first) << played.diagnosis.report();
}

// A counterbalance on a lever is no end stop, whose error still depends on the same position; crosstalk is no
// cable, whose error still depends on the velocity of the joint that it comes from.
TEST(HideAndSeek, ANameWhoseOwnSignalsStillPredictTheErrorHasAnotherShape) {
  EXPECT_EQ(outside_score({}, "pallet-4", "counterbalance_lever", 1).false_names, 0);
  EXPECT_EQ(outside_score({}, "psm-3dof", "crosstalk", 1).false_names, 0);
}

// No gain below zero is asked for: a joint's torque with the wrong sign is said, and nothing is thrown.
TEST(HideAndSeek, ATorqueWithTheWrongSignIsSaid) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::path(testing::TempDir()) / "hide-and-seek-wrong-sign";
  fs::create_directories(folder);
  const Bench bench = make_bench("psm-3dof", 811);
  std::vector<std::string> train;
  for (int k = 1; k <= kBareTrain + 1; ++k) {
    IdealRecording ideal = ideal_recording(bench, {}, Motion(bench.robot, bench.seed, k), k);
    ideal.tau.col(1) *= -1.0;
    train.push_back((folder / ("recording-" + std::to_string(k) + ".csv")).string());
    write_recording(bench, ideal, bench.seed, k, train.back());
  }
  const std::vector<std::string> test = {train.back()};
  train.pop_back();
  const Diagnosis d = diagnose(bench.robot, train, test);
  int said = 0;
  for (const RecordingQuality& q : d.data_quality) {
    for (const QualityFinding& f : q.findings) said += f.finding == "torque_sign" && f.joint == 2 ? 1 : 0;
  }
  EXPECT_EQ(said, 1) << d.report();
  fs::remove_all(folder);
}

// The yaw axis of the PSM is fixed to the base: a lean about it has the same torques as a wrong zero of its
// encoder, and a second parameter that says nothing.
TEST(HideAndSeek, AWrongZeroComesBeforeALeanOfTheBaseWithTheSameTorques) {
  const Played played = play({"psm-3dof", {"large_zero"}, 211, 0.1, Mode::kChanged});
  expect_found(played, "offset");
  bool lean = false;  // a rival, or the answer of a question about the recording
  for (const Rival& r : played.diagnosis.findings.front().rivals) lean |= effect_of(r.cause) == "gravity_tilt";
  for (const RecordingQuality& q : played.diagnosis.data_quality) lean |= q.find("gravity") != nullptr;
  EXPECT_TRUE(lean) << played.diagnosis.report();
}

// Without the question that comes after the names, the base's torques are those of a spring of the second joint.
TEST(HideAndSeek, AnElasticBaseTakesThePlaceOfTheSpringThatStoodForIt) {
  const Played played = play({"pick-scara", {}, 214, 0.1, Mode::kBare, Trouble::kElasticBase});
  ASSERT_EQ(played.diagnosis.findings.size(), 1U) << played.diagnosis.report();
  EXPECT_EQ(effect_of(played.diagnosis.findings[0].cause), "base_compliance");
  for (const FoundParameter& p : played.diagnosis.findings[0].parameters) EXPECT_GE(p.value, 0.0) << p.name;
  EXPECT_EQ(played.verdict.extras, 0);
}

}  // namespace
}  // namespace veridyn::seek
