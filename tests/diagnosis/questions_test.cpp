#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "diagnosis/evidence/effect_facts.hpp"
#include "diagnosis/causes/extended_arm.hpp"
#include "diagnosis/causes/geometry.hpp"
#include "diagnosis/evidence/hypotheses.hpp"
#include "effects/kinematic_error.hpp"
#include "diagnosis/causes/ripple.hpp"
#include "veridyn/files/model_file.hpp"

// What is asked of an arm, and what becomes of an arm with the answers.

namespace veridyn {
namespace {

// A recording in which the joints move so far, under some torque.
CompressedRecording moving(const std::vector<double>& travels) {
  CompressedRecording out;
  for (const double travel : travels) {
    TorqueFacts joint;
    joint.lowest = -0.5 * travel;
    joint.highest = 0.5 * travel;
    joint.largest_speed = travel;
    joint.minimum = -1.0;
    joint.maximum = 1.0;
    out.joints.push_back(joint);
  }
  out.facts.duration = 20.0;
  return out;
}

std::multiset<std::string> causes_of(const Model& arm, const AugmentedModel& asked) {
  std::multiset<std::string> out;
  for (const Hypothesis& h : asked.hypotheses) out.insert(to_text(arm, h.cause));
  return out;
}

TEST(Hypotheses, AskForEveryJointThatMovesAndForTheArm) {
  const Model arm = read_model("planar-2r");
  CandidateList list;
  list.wanted = {"joint_spring", "time_delay"};
  const auto asked = [&](const std::vector<double>& travels) {
    return causes_of(arm, augmented_model(arm, {moving(travels)}, list));
  };
  EXPECT_EQ(asked({1.0, 1.0}),
            (std::multiset<std::string>{"joint_spring:shoulder", "joint_spring:elbow",
                                        "time_delay:arm", "time_delay:shoulder",
                                        "time_delay:elbow"}));
  EXPECT_EQ(asked({0.0, 1.0}), (std::multiset<std::string>{"joint_spring:elbow", "time_delay:arm",
                                                           "time_delay:elbow"}));
  EXPECT_TRUE(asked({0.0, 0.0}).empty());
}

// Without torque, as where a joint never moves: neither its own errors nor what its torque does in another's channel. One
// recording that has it is enough.
TEST(Hypotheses, AskForNoJointWithoutTorque) {
  const Model arm = read_model("planar-2r");
  CandidateList list;
  list.wanted = {"joint_spring", "time_delay", "torque_crosstalk"};
  CompressedRecording silent = moving({1.0, 1.0});
  silent.joints[1].minimum = silent.joints[1].maximum = 0.0;
  EXPECT_EQ(causes_of(arm, augmented_model(arm, {silent, silent}, list)),
            (std::multiset<std::string>{"joint_spring:shoulder", "time_delay:arm", "time_delay:shoulder"}));
  const CompressedRecording sound = moving({1.0, 1.0});
  EXPECT_EQ(causes_of(arm, augmented_model(arm, {silent, sound}, list)), causes_of(arm, augmented_model(arm, {sound}, list)));
}

// Every hypothesis has its columns among the parameters of the augmented model, and nobody else has
// them.
TEST(Hypotheses, HaveColumnsOfTheirOwn) {
  const Model arm = read_model("planar-2r");
  CandidateList list;
  list.changes = true;
  const AugmentedModel asked = augmented_model(arm, {moving({1.0, 1.0})}, list);
  const auto parameters = standard_parameters(asked.model);
  std::set<std::string> seen;
  ASSERT_GT(asked.hypotheses.size(), 20U);
  for (const Hypothesis& h : asked.hypotheses) {
    EXPECT_FALSE(h.columns.empty()) << effect_of(h.cause);
    EXPECT_EQ(h.columns, columns_in(parameters, h)) << effect_of(h.cause);
    EXPECT_EQ(h.columns.size(), h.signs.size()) << effect_of(h.cause);
    for (const std::string& column : h.columns) EXPECT_TRUE(seen.insert(column).second) << column;
  }
}

TEST(Hypotheses, OfAModelWithValuesAreChangesAndLoads) {
  const Model arm = read_model("planar-2r");
  CandidateList list;
  list.changes = true;
  list.wanted = {"payload", "viscous_friction"};
  const AugmentedModel asked = augmented_model(arm, {moving({1.0, 1.0})}, list);
  int loads = 0;
  int changes = 0;
  for (const Hypothesis& h : asked.hypotheses) {
    if (is_load(h)) {
      ++loads;
      EXPECT_EQ(h.joint->value, frame_of(h.cause)->value);  // a frame for every joint here
      continue;
    }
    ++changes;
    EXPECT_TRUE(is_change(h)) << effect_of(h.cause);
    EXPECT_FALSE(is_other_constant(h));
    ASSERT_EQ(h.lowest.size(), 1U);
    EXPECT_DOUBLE_EQ(h.lowest[0], h.joint->value == 0 ? -0.8 : -0.4);
    EXPECT_EQ(term_of(asked.model, h).effect, "viscous_friction");
    EXPECT_EQ(arm.effects()[h.own->value].effect, "viscous_friction");
  }
  EXPECT_EQ(loads, 2);
  EXPECT_EQ(changes, 2);
}

TEST(Hypotheses, FramesThatAreFixedToEachOtherAreOneLink) {
  const Model arm = read_model("psm-3dof");
  const std::vector<FrameIndex> frames = payload_frames(arm);
  for (size_t a = 0; a < frames.size(); ++a) {
    for (size_t b = 0; b < a; ++b) EXPECT_FALSE(same_link(arm, frames[a], frames[b]));
  }
  for (int k = 0; k < static_cast<int>(arm.frames().size()); ++k) {
    const bool moves = arm.moves(k, 0) || arm.moves(k, 1) || arm.moves(k, 2);
    EXPECT_EQ(std::count_if(frames.begin(), frames.end(),
                            [&](FrameIndex other) { return moves && same_link(arm, {k}, other); }),
              moves ? 1 : 0);
  }
}

TEST(EffectFacts, ComeFromTheEffects) {
  EXPECT_TRUE(is_friction("coulomb_friction"));
  EXPECT_FALSE(is_friction("joint_spring"));
  EXPECT_FALSE(is_friction("payload"));
  EXPECT_TRUE(asks_for_waves({}));
  EXPECT_TRUE(asks_for_waves({"torque_ripple"}));
  EXPECT_FALSE(asks_for_waves({"joint_spring"}));
  EXPECT_EQ(elementary_effects(), (std::vector<std::string>{"torque_offset", "coulomb_friction",
                                                            "viscous_friction"}));
}

// A slide's zero is a length, a hinge's an angle.
TEST(EffectFacts, PhrasesOfChannelsKnowSlidesFromHinges) {
  const Model arm = read_model("psm-3dof");
  int slides = 0;
  for (int i = 0; i < arm.joints(); ++i) {
    EffectTerm term;
    term.effect = "encoder_offset";
    term.axis.coefficients = VectorXd::Unit(arm.joints(), i);
    const bool slide = arm.coordinates()[i].prismatic;
    slides += static_cast<int>(slide);
    const std::string words = channel_phrase(arm, term, {0.002});
    EXPECT_NE(words.find(slide ? "2 mm too large" : "2 mrad too large"), std::string::npos) << words;
  }
  EXPECT_EQ(slides, 1);
}

// In one motion much goes together: what depends on the place, and errors of channels, need another.
TEST(Hypotheses, ThatOneMotionMayMisleadAboutAreKnown) {
  CandidateList list;
  list.wanted = {"joint_spring", "time_delay", "quadratic_drag"};
  const AugmentedModel asked = augmented_model(read_model("planar-2r"), {moving({1.0, 1.0})}, list);
  for (const Hypothesis& h : asked.hypotheses)
    EXPECT_EQ(h.extrapolates, effect_of(h.cause) != "quadratic_drag") << effect_of(h.cause);
}

// An order of a ripple is the best of many that were looked at; its significance pays for that.
TEST(Hypotheses, OrdersOfARippleHaveBeenTriedManyTimes) {
  CandidateList list;
  list.wanted = {"torque_ripple", "joint_spring"};
  list.ripple_orders = {{40.0}, {}};
  const AugmentedModel asked = augmented_model(read_model("planar-2r"), {moving({1.0, 1.0})}, list);
  int ripples = 0;
  for (const Hypothesis& h : asked.hypotheses) {
    const bool ripple = effect_of(h.cause) == "torque_ripple";
    ripples += static_cast<int>(ripple);
    EXPECT_DOUBLE_EQ(h.tried, ripple ? list.limits.ripple_finest : 1.0) << effect_of(h.cause);
  }
  EXPECT_EQ(ripples, 1);
}

TEST(ExtendedArm, HasNewChangedLoadedAndCorrectedParts) {
  const Model arm = read_model("planar-2r");
  FoundCause change;
  change.hypothesis.cause = ChangedEffect{"viscous_friction", {0}};
  change.hypothesis.own = TermIndex{0};
  change.values = {0.5};
  FoundCause spring;
  spring.hypothesis.cause = NewEffect{"joint_spring", {1}};
  spring.term.effect = "joint_spring";
  spring.term.axis.coefficients = VectorXd::Unit(2, 1);
  spring.values = {3.0, 1.0};
  FoundCause load;
  load.hypothesis.cause = AddedLoad{{1}};
  load.hypothesis.part = BodyIndex{2};
  load.load = inertial_parameters(2.0, Eigen::Vector3d(0.1, 0.0, 0.0),
                                  Eigen::Matrix<double, 6, 1>::Zero());
  FoundCause delay;
  delay.hypothesis.cause = ChannelError{"time_delay", JointIndex{1}};
  delay.term.effect = "time_delay";
  delay.term.axis.coefficients = VectorXd::Unit(2, 1);
  delay.values = {0.02};
  const Model out = extended_arm(arm, {change, spring, load, delay}, true);
  EXPECT_DOUBLE_EQ(out.effects()[0].values.at("coefficient"), 1.3);
  ASSERT_EQ(out.effects().size(), arm.effects().size() + 1);
  EXPECT_EQ(out.effects().back().effect, "joint_spring");
  EXPECT_FALSE(out.effects().back().values.empty());
  ASSERT_EQ(out.frames().size(), 3U);
  EXPECT_EQ(out.frames()[2].name, "payload");
  EXPECT_EQ(out.frames()[2].parent, FrameIndex{1});
  EXPECT_DOUBLE_EQ((*out.frames()[2].body->phi)[0], 2.0);
  EXPECT_DOUBLE_EQ(out.coordinates()[1].recorded.torque_delay, 0.02);
  // Friction cannot fall below nothing.
  change.values = {-5.0};
  EXPECT_DOUBLE_EQ(extended_arm(arm, {change}, true).effects()[0].values.at("coefficient"), 0.0);
  // An arm that is to be identified gets no values.
  EXPECT_TRUE(extended_arm(arm, {spring}, false).effects().back().values.empty());
}

// Wherever the order lies between two of the grid, which are a rad^-1 apart.
TEST(Ripple, WavesOfTheResidualAlongTheTravel) {
  for (const double order : {39.8, 40.05, 40.3, 40.55}) {
    Identification id;
    id.model = read_model("planar-2r");
    id.train.resize(1);
    PredictionSeries& x = id.train[0].series;
    for (auto* table : {&x.q, &x.measured, &x.modelled}) table->resize(2);
    for (int k = 0; k < 3000; ++k) {
      x.time.push_back(0.01 * k);
      const double q = 1.5 * std::sin(0.7 * x.time.back());
      for (size_t i = 0; i < 2; ++i) {
        x.q[i].push_back(q);
        x.modelled[i].push_back(std::cos(q));
        x.measured[i].push_back(std::cos(q) + (i == 0 ? 0.1 * std::sin(order * q) : 0.0));
      }
    }
    const auto orders = ripple_orders(id, {});
    ASSERT_EQ(orders.size(), 2U);
    ASSERT_FALSE(orders[0].empty());
    EXPECT_NEAR(orders[0].front(), order, 0.2);
    EXPECT_LE(orders[0].size(), 2U);
  }
}

TEST(Geometry, NumbersOfTheRowsAndTheArmWithAnother) {
  const Model arm = read_model("planar-2r");
  const std::vector<FrameConstant> constants = row_constants(arm);
  ASSERT_EQ(constants.size(), 8U);  // four for each of two frames
  for (const FrameConstant& c : constants) {
    const Model other = with_constant(arm, c, value_in(arm, c) + 0.1);
    const int frame = c.frame.value;
    const DhRow& row = *other.frames()[frame].dh;
    const DhRow& before = *arm.frames()[frame].dh;
    const double changed = std::abs(row.a - before.a) + std::abs(row.alpha - before.alpha) +
                           std::abs(row.d - before.d) + std::abs(row.theta - before.theta);
    EXPECT_NEAR(changed, 0.1, 1e-12) << words_for(arm, c);
    EXPECT_EQ(words_for(arm, c), name_of(arm, c) + " of frame " + arm.frames()[frame].name);
    EXPECT_EQ(unit_of(c), c.number == FrameNumber::kTheta || c.number == FrameNumber::kAlpha ? "rad" : "m");
    // The text form of the cause is read back.
    EXPECT_TRUE(alike(parse_cause(arm, to_text(arm, KinematicError{c})), KinematicError{c})) << words_for(arm, c);
  }
}

}  // namespace
}  // namespace veridyn
