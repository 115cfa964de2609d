#include "veridyn/identification/joint_friction.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "veridyn/files/model_file.hpp"

// Friction that a maker's file lacks.

namespace veridyn {
namespace {

// planar-2r as a maker would deliver it: no friction, and values of its series.
Model bare(RobotValues values) {
  ModelDescription d = read_model("planar-2r").description();
  d.effects.clear();
  d.values = values;
  return Model(std::move(d));
}

long count(const Model& arm, const std::string& effect) {
  return std::count_if(arm.effects().begin(), arm.effects().end(), [&](const EffectTerm& e) { return e.effect == effect; });
}

TEST(JointFriction, IsAddedToAMakersFileWithoutAny) {
  const Model maker = bare(RobotValues::kPrior);
  const Model with = with_friction(maker, JointFriction::kAuto);
  for (const char* effect : {"viscous_friction", "coulomb_friction", "torque_offset"}) EXPECT_EQ(count(with, effect), 2) << effect;
  // The inertia of the first rotor cannot be told from that of the first link.
  ASSERT_EQ(count(with, "rotor_inertia"), 1);
  for (const EffectTerm& term : with.effects()) {
    if (term.effect != "rotor_inertia") continue;
    EXPECT_EQ(term.axis.coefficients, VectorXd::Unit(2, 1));
  }
  const Model lean = with_friction_alone(maker, JointFriction::kAuto);
  EXPECT_EQ(lean.effects().size(), 6U);
  EXPECT_EQ(count(lean, "rotor_inertia"), 0);
  const std::string remark = friction_remark(maker, with);
  EXPECT_NE(remark.find("offset of every joint, and the rotor inertia of elbow, are identified with it"), std::string::npos) << remark;
  EXPECT_NE(friction_remark(maker, lean).find("offset of every joint are identified with it"), std::string::npos);
}

TEST(JointFriction, OfAFileThatHasFrictionIsUnchanged) {
  const Model arm = read_model("planar-2r");
  for (const JointFriction asked : {JointFriction::kAuto, JointFriction::kFile}) {
    EXPECT_EQ(with_friction(arm, asked).effects().size(), arm.effects().size());
    EXPECT_EQ(with_friction_alone(arm, asked).effects().size(), arm.effects().size());
  }
  EXPECT_EQ(friction_remark(arm, arm), "");
  EXPECT_EQ(count(with_friction_alone(arm, JointFriction::kPlain), "torque_offset"), 2);
  EXPECT_EQ(count(with_friction_alone(arm, JointFriction::kPlain), "viscous_friction"), 2);  // not twice
  // A file that says of this very arm that it has none, and one that is to be taken as it is.
  const Model facts = bare(RobotValues::kFacts);
  EXPECT_TRUE(with_friction(facts, JointFriction::kAuto).effects().empty());
  EXPECT_TRUE(with_friction(bare(RobotValues::kPrior), JointFriction::kFile).effects().empty());
  const std::string remark = friction_remark(facts, facts);
  EXPECT_NE(remark.find("every real joint has"), std::string::npos) << remark;
  EXPECT_STREQ(name_of(JointFriction::kAuto), "auto");
  EXPECT_STREQ(name_of(JointFriction::kPlain), "plain");
  EXPECT_STREQ(name_of(JointFriction::kFile), "file");
}

// Numbers of single joints alone, in the order of the joints, with their deviations where these are known.
TEST(JointFriction, ValuesAreListedInTheOrderOfTheJoints) {
  ModelDescription d = read_model("planar-2r").description();
  d.effects[2].deviations["coefficient"] = 0.02;
  EffectTerm rotor;
  rotor.effect = "rotor_inertia";
  rotor.axis.coefficients = VectorXd::Unit(2, 1);
  rotor.values["inertia"] = 0.3;
  d.effects.push_back(rotor);
  EffectTerm across = d.effects[0];
  across.axis.coefficients = VectorXd::Ones(2);
  d.effects.push_back(across);
  EffectTerm hysteresis;  // no plain friction
  hysteresis.effect = "presliding_hysteresis";
  hysteresis.axis.coefficients = VectorXd::Unit(2, 0);
  d.effects.push_back(hysteresis);
  const std::vector<JointNumber> all = plain_friction_of(Model(std::move(d)));
  ASSERT_EQ(all.size(), 5U);
  const int joints[] = {0, 0, 1, 1, 1};
  const double values[] = {0.8, 1.2, 0.4, 0.6, 0.3};
  for (size_t k = 0; k < all.size(); ++k) {
    EXPECT_EQ(all[k].joint.value, joints[k]) << k;
    EXPECT_EQ(all[k].value, values[k]) << k;
  }
  EXPECT_EQ(all[0].unit, "N m s/rad");
  EXPECT_EQ(all[2].deviation, 0.02);
  EXPECT_TRUE(std::isnan(all[3].deviation));
  EXPECT_EQ(all[4].effect, "rotor_inertia");
}

}  // namespace
}  // namespace veridyn
