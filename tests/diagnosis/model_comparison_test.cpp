#include "veridyn/diagnosis/model_comparison.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/near.hpp"
#include "support/random.hpp"
#include "diagnosis/comparison/comparison_words.hpp"
#include "math/eigen_pose.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/identification/base_parameters.hpp"
#include "veridyn/identification/pseudo_inertia.hpp"
#include "kinematics/standard_motion.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/math/require.hpp"
#include "math/student_t.hpp"
#include "veridyn/files/model_file.hpp"

// Models that were not identified, with statistics written into them by hand.

namespace veridyn {
namespace {

// The planar arm with a section of statistics: its own values are what least squares found, every
// cluster contributes at random, `deviation` times the size of the parameter.
Model with_statistics(const Model& arm, double deviation, int clusters, unsigned seed) {
  const BaseParameters base = base_parameters(arm);
  const std::vector<StandardParameter> parameters = standard_parameters(arm);
  Random random(seed);
  ModelDescription d = arm.description();
  d.identified = IdentifiedBase{};
  d.identified->clusters = clusters;
  for (int r = 0; r < base.size(); ++r) {
    const auto own = static_cast<size_t>(base.independent[r]);
    IdentifiedParameter p;
    p.name = parameters[own].name;
    p.unit = parameters[own].unit;
    for (size_t j = 0; j < parameters.size(); ++j) {
      const double k = base.K(r, static_cast<Eigen::Index>(j));
      if (k == 0.0) continue;
      p.combination[parameters[j].name] = k;
      p.value += k * parameters[j].value;
    }
    p.free = p.value;
    const double size = deviation * std::max(0.1, std::abs(p.value));
    p.scatter = size / std::sqrt(clusters) * random.vector(clusters, -1.7, 1.7);
    d.identified->parameters.push_back(p);
  }
  return Model(d);
}

Model planar() {
  return read_model("planar-2r");
}

// The same arm with a parameter of one effect multiplied.
Model with_effect(size_t effect, const std::string& key, double factor) {
  ModelDescription d = planar().description();
  d.effects[effect].values.at(key) *= factor;
  return Model(d);
}

const ModelDifference& named(const std::vector<ModelDifference>& all, const std::string& name) {
  for (const ModelDifference& d : all) {
    if (d.name == name) return d;
  }
  ADD_FAILURE() << "no " << name;
  return all.front();
}

const ModelDifference& quantity(const std::vector<ModelDifference>& all, const std::string& which,
                                JointIndex joint) {
  for (const ModelDifference& d : all) {
    if (name_of(d.quantity) == which && d.joint == joint) return d;
  }
  ADD_FAILURE() << "no " << which << " of joint " << joint.value + 1;
  return all.front();
}

constexpr size_t kShoulderCoulomb = 1;  // the second effect of the file
const char* const kShoulderLevel = "coulomb_friction(shoulder).level";

TEST(TheComparison, OfAModelWithItselfFindsNothing) {
  const Model arm = with_statistics(planar(), 0.05, 8, 1);
  const ModelComparison c = compare(arm, arm);
  EXPECT_EQ(c.verdict, ComparisonVerdict::kSame);
  EXPECT_TRUE(c.structure.empty());
  EXPECT_EQ(c.parameters.size(), 10U);
  for (const ModelDifference& d : c.parameters) EXPECT_NEAR(d.difference, 0.0, 1e-12) << d.name;
  for (const TorqueDifference& t : c.torque) EXPECT_EQ(t.difference, 0.0);
}

// Errors of the model would be taken for changes of the arm.
TEST(TheComparison, NamesTheModelThatFitsItsOwnRecordingsWorse) {
  ModelDescription before = with_statistics(planar(), 0.05, 8, 1).description(), after = before;
  before.identified->error = after.identified->error = Eigen::Vector2d(0.01, 0.02);
  EXPECT_EQ(compare(Model(before), Model(after)).report().find("fits its own"), std::string::npos);
  after.identified->error[1] = 0.1;
  const std::string report = compare(Model(before), Model(after)).report();
  EXPECT_NE(report.find("The model after fits its own recordings worse than the model before fits its own, on elbow (10.00 % of the torque against 2.00 %): "
                        "differences may be what it lacks.\n"), std::string::npos) << report;
}

// Torques in another unit change every number.
TEST(TheComparison, NamesOneFactorOfAllTorques) {
  const auto scaled = [](double bodies, double effects) {
    ModelDescription d = planar().description();
    for (Frame& frame : d.frames)
      if (frame.body) *frame.body->phi *= bodies;
    for (EffectTerm& term : d.effects)
      for (const EffectParameter& p : find_effect(term.effect).parameters()) term.values.at(p.name) *= effects;
    return with_statistics(Model(d), 0.001, 8, 2);
  };
  const Model before = with_statistics(planar(), 0.001, 8, 1);
  const std::string words = "times those before, and otherwise differ by no more than chance";
  EXPECT_NE(compare(before, scaled(1.2, 1.2)).report().find("The torques of all joints after are 1.2 " + words), std::string::npos)
      << compare(before, scaled(1.2, 1.2)).report();
  EXPECT_EQ(compare(before, scaled(1.2, 1.0)).report().find(words), std::string::npos);
  EXPECT_EQ(compare(before, scaled(1.0, 1.0)).report().find(words), std::string::npos);
}

// That one file has no friction is a difference of the files.
TEST(TheComparison, ReportsNoFrictionDifferenceIfOnlyOneModelHasFriction) {
  const Model before = with_statistics(planar(), 0.001, 8, 1);
  ModelDescription d = planar().description();
  d.effects.clear();
  const Model after = with_statistics(Model(d), 0.001, 8, 1);
  for (const ModelComparison& c : {compare(before, after), compare(after, before)}) {
    EXPECT_FALSE(c.structure.empty());
    EXPECT_FALSE(c.joints.empty());
    for (const ModelDifference& one : c.joints) EXPECT_NE(one.quantity, ComparedQuantity::kFriction) << one.sentence;
  }
  EXPECT_NO_FATAL_FAILURE(quantity(compare(before, before).joints, "friction", JointIndex{0}));
}

// One number, all by hand: Coulomb friction 20 % up, scatters of eight and twelve clusters.
TEST(TheComparison, GivesWelchsTestOfTheClusters) {
  const Model before = with_statistics(planar(), 0.02, 8, 1);
  const Model after = with_statistics(with_effect(kShoulderCoulomb, "level", 1.2), 0.03, 12, 2);
  const ModelComparison c = compare(before, after);
  EXPECT_FALSE(c.same_motion);
  const ModelDifference& d = named(c.parameters, kShoulderLevel);
  EXPECT_NEAR(d.before, 1.2, 1e-9);
  EXPECT_NEAR(d.difference, 0.24, 1e-9);
  const auto scatter = [](const Model& arm) {
    for (const IdentifiedParameter& p : arm.description().identified->parameters) {
      if (p.name == kShoulderLevel) return p.scatter;
    }
    return VectorXd();
  };
  const VectorXd a = scatter(before);
  const VectorXd b = scatter(after);
  const double va = a.squaredNorm();
  const double vb = b.squaredNorm();
  EXPECT_NEAR(d.deviation, std::sqrt(va + vb), 1e-6 * d.before + 1e-9);
  const auto freedom = [](const VectorXd& s) {
    const double g = static_cast<double>(s.size());
    const double kurtosis = g * s.array().pow(4).sum() / std::pow(s.squaredNorm(), 2);
    return std::min(g - 1.0, std::max(0.5 * (g - 1.0), 3.0 * g / kurtosis - 2.0));
  };
  const double dof = std::pow(va + vb, 2) / (va * va / freedom(a) + vb * vb / freedom(b));
  EXPECT_NEAR(d.degrees_of_freedom, dof, 1e-6 * dof);
  EXPECT_NEAR(d.p_value, student_t_two_sided(d.difference / d.deviation, dof), 1e-9);
  EXPECT_NEAR(0.5 * (d.low + d.high), d.difference, 1e-12);
  EXPECT_NEAR(0.5 * (d.high - d.low), student_t_quantile(0.05, dof) * d.deviation, 1e-9);
}

// k-th smallest times m - k + 1, running maximum.
TEST(TheComparison, CorrectsForTheNumberOfTests) {
  const ModelComparison c =
      compare(with_statistics(planar(), 0.05, 8, 3),
              with_statistics(with_effect(kShoulderCoulomb, "level", 1.3), 0.05, 8, 4));
  std::vector<std::pair<double, double>> p;
  for (const ModelDifference& d : c.parameters) p.emplace_back(d.p_value, d.p_corrected);
  for (const ModelDifference& d : c.joints) {
    if (d.same_as.empty()) {
      p.emplace_back(d.p_value, d.p_corrected);
      continue;
    }
    bool found = false;
    for (const ModelDifference& parameter : c.parameters) {
      if (parameter.expression != d.same_as) continue;
      found = true;
      EXPECT_EQ(d.p_corrected, parameter.p_corrected);
      EXPECT_NEAR(d.p_value, parameter.p_value, 1e-6);
    }
    EXPECT_TRUE(found) << d.same_as;
  }
  ASSERT_EQ(static_cast<int>(p.size()), c.compared());
  std::sort(p.begin(), p.end());
  double least = 0.0;
  for (size_t k = 0; k < p.size(); ++k) {
    least = std::max(least, std::min(1.0, p[k].first * static_cast<double>(p.size() - k)));
    EXPECT_NEAR(p[k].second, least, 1e-12);
  }
}

// Scatter that both have in common, cluster by cluster, cancels where the motion is the same.
TEST(TheComparison, PairsTheClustersOfOneMotion) {
  const auto in_motion = [](const Model& arm, double change) {
    ModelDescription moved = arm.description();
    moved.identified->motion = MatrixXd(8, 2);
    for (Eigen::Index c = 0; c < 8; ++c)
      moved.identified->motion.row(c)
          << 0.3 + 0.02 * static_cast<double>(c) + change * static_cast<double>(c % 3),
          0.5 - 0.03 * static_cast<double>(c);
    return Model(moved);
  };
  const Model before = in_motion(with_statistics(planar(), 0.5, 8, 5), 0.0);
  ModelDescription d =
      with_statistics(with_effect(kShoulderCoulomb, "level", 1.2), 0.5, 8, 6).description();
  for (size_t r = 0; r < d.identified->parameters.size(); ++r) {
    VectorXd& scatter = d.identified->parameters[r].scatter;
    scatter = before.description().identified->parameters[r].scatter + 0.01 * scatter;
  }
  const Model changed(d);
  const ModelComparison paired = compare(before, in_motion(changed, 1e-3));
  EXPECT_TRUE(paired.same_motion);
  EXPECT_TRUE(named(paired.parameters, kShoulderLevel).significant);
  const ModelComparison other = compare(before, in_motion(changed, 0.05));
  EXPECT_FALSE(other.same_motion);
  EXPECT_FALSE(named(other.parameters, kShoulderLevel).significant);
}

TEST(TheComparison, DoesNotDependOnTheBaseParametersOfTheSecondFile) {
  const Model before = with_statistics(planar(), 0.02, 8, 6);
  const Model after = with_statistics(with_effect(kShoulderCoulomb, "level", 1.2), 0.02, 8, 7);
  ModelDescription d = after.description();
  std::vector<IdentifiedParameter>& p = d.identified->parameters;
  // Every second one plus a multiple of the one before it.
  for (size_t r = 1; r < p.size(); r += 2) {
    const double w = 0.3 + 0.1 * static_cast<double>(r);
    for (const auto& [name, k] : p[r - 1].combination) p[r].combination[name] += w * k;
    p[r].value += w * p[r - 1].value;
    p[r].free += w * p[r - 1].free;
    p[r].scatter += w * p[r - 1].scatter;
  }
  const ModelComparison a = compare(before, after);
  const ModelComparison b = compare(before, Model(d));
  ASSERT_EQ(a.parameters.size(), b.parameters.size());
  EXPECT_TRUE(b.only_before.empty());
  EXPECT_TRUE(b.only_after.empty());
  for (const ModelDifference& x : a.parameters) {
    const ModelDifference& y = named(b.parameters, x.name);
    EXPECT_NEAR(x.after, y.after, 1e-9) << x.name;
    EXPECT_NEAR(x.deviation, y.deviation, 1e-6 * x.deviation) << x.name;
    EXPECT_NEAR(x.p_corrected, y.p_corrected, 1e-5) << x.name;
  }
}

// Closed forms of the textbook arm.
TEST(TheComparison, GivesFrictionWeightAndInertiaOfTheJoints) {
  ModelDescription heavier = planar().description();
  Body& fore = *heavier.frames[1].body;
  const double added = 0.5;  // [kg], at the frame's origin, 0.4 m from the elbow
  (*fore.phi)[0] += added;
  ModelDescription both = heavier;
  both.effects[kShoulderCoulomb].values["level"] += 0.3;
  both.effects[kShoulderCoulomb - 1].values["coefficient"] += 0.1;
  const ModelComparison c =
      compare(with_statistics(planar(), 0.01, 8, 8), with_statistics(Model(both), 0.01, 8, 9));
  const MotionSamples m = standard_motion(planar());
  // Friction: the level, and the coefficient times the mean speed 2/pi of its peak.
  const double mean_speed = 2.0 / M_PI * m.dq.col(0).cwiseAbs().maxCoeff();
  EXPECT_NEAR(quantity(c.joints, "friction", {0}).difference, 0.3 + 0.1 * mean_speed, 2e-3);
  EXPECT_NEAR(quantity(c.joints, "friction", {1}).difference, 0.0, 1e-9);
  // Inertia of the elbow: m r^2, whatever the pose.
  EXPECT_NEAR(quantity(c.joints, "inertia", {1}).difference, added * 0.16, 1e-6);
  // Weight on the elbow: m g r cos(q1 + q2), averaged over whole periods of the elbow.
  double weight = 0.0;
  int rows = 0;
  const double period = 1.0 / standard_frequency(1);
  for (Eigen::Index k = 0; k < m.rows(); ++k) {
    if (m.time[k] >= period * std::floor(30.0 / period) - 1e-9) continue;
    weight += added * 9.81 * 0.4 * std::cos(m.q(k, 0) + m.q(k, 1));
    ++rows;
  }
  EXPECT_NEAR(quantity(c.joints, "weight", {1}).difference, weight / rows, 1e-6);
  for (const ModelDifference& d : c.joints) EXPECT_NE(d.quantity, ComparedQuantity::kOffset) << d.sentence;
}

// A step of friction differs by its level at every instant.
TEST(TheComparison, GivesTheTorqueOfADifference) {
  const ModelComparison c =
      compare(with_statistics(planar(), 0.01, 8, 1),
              with_statistics(with_effect(kShoulderCoulomb, "level", 1.5), 0.01, 8, 2));
  ASSERT_EQ(c.torque.size(), 2U);
  EXPECT_NEAR(c.torque[0].difference, 0.6, 2e-3);
  EXPECT_NEAR(c.torque[0].effects, 0.6, 2e-3);
  EXPECT_EQ(c.torque[0].bodies, 0.0);
  EXPECT_EQ(c.torque[1].difference, 0.0);
  EXPECT_NEAR(c.torque[0].share, 0.6 / c.torque[0].before, 2e-4);
  EXPECT_GT(c.torque[0].by_chance, 0.0);
  EXPECT_NEAR(named(c.parameters, kShoulderLevel).torque[0], 0.6, 2e-3);
}

TEST(TheComparison, DescribesGrownFrictionAndChangedMoments) {
  ModelDescription changed = with_effect(kShoulderCoulomb, "level", 1.5).description();
  (*changed.frames[1].body->phi)[1] += 0.1;
  const ModelComparison c =
      compare(with_statistics(planar(), 0.01, 8, 1), with_statistics(Model(changed), 0.01, 8, 2));
  const std::string friction = named(c.parameters, kShoulderLevel).sentence;
  for (const char* words :
       {"Coulomb friction of joint 1 (shoulder) grew from 1.2", " to 1.8", "N m", "+50 %"}) {
    EXPECT_NE(friction.find(words), std::string::npos) << friction;
  }
  const std::string moment = named(c.parameters, "hx_fore").sentence;
  // The weight of 0.1 kg m is 0.981 N m at most; the standard motion passes the horizontal.
  for (const char* words : {"first moment hx_fore", "weight on joint 2 (elbow)", "0.98 N m"}) {
    EXPECT_NE(moment.find(words), std::string::npos) << moment;
  }
  const std::string report = c.report();
  EXPECT_NE(report.find(friction), std::string::npos) << report;
  EXPECT_NE(report.find(moment), std::string::npos) << report;
}

TEST(TheComparison, ComparesCommonParametersIfOneModelHasAnotherEffect) {
  ModelDescription d = with_effect(kShoulderCoulomb, "level", 1.3).description();
  EffectTerm offset;
  offset.effect = "torque_offset";
  offset.axis = d.effects[0].axis;
  offset.values["offset"] = 0.4;
  d.effects.push_back(offset);
  const ModelComparison c =
      compare(with_statistics(planar(), 0.01, 8, 1), with_statistics(Model(d), 0.01, 8, 2));
  ASSERT_EQ(c.structure.size(), 1U);
  EXPECT_EQ(c.structure[0].kind, StructureKind::kEffect);
  EXPECT_NE(c.structure[0].sentence.find("only the model after has torque_offset(shoulder)"),
            std::string::npos)
      << c.structure[0].sentence;
  EXPECT_EQ(c.parameters.size(), 10U);
  ASSERT_EQ(c.only_after.size(), 1U);
  EXPECT_EQ(c.only_after[0], "torque_offset(shoulder).offset");
  EXPECT_TRUE(named(c.parameters, kShoulderLevel).significant);
  // The quantities of the joint are compared all the same.
  EXPECT_NEAR(quantity(c.joints, "offset", {0}).difference, 0.4, 1e-9);
}

// A stop beyond the standard motion has no torque there. That one model lacks it is no difference of its stiffness.
TEST(TheComparison, DoesNotCompareAnEffectThatOneModelHasAlone) {
  ModelDescription d = planar().description();
  EffectTerm stop;
  stop.effect = "end_stop";
  stop.axis = d.effects[0].axis;
  stop.values = {{"stiffness", 3.0}, {"centre", 0.0}, {"reach", 2.2}, {"side", 1.0}};
  d.effects.push_back(stop);
  const Model with = with_statistics(Model(d), 0.01, 8, 1), without = with_statistics(planar(), 0.01, 8, 2);
  const std::vector<std::string> stiffness = {"end_stop(shoulder).stiffness"};
  EXPECT_EQ(compare(with, without).only_before, stiffness);
  EXPECT_EQ(compare(with, without).parameters.size(), 10U);
  EXPECT_EQ(compare(without, with).only_after, stiffness);
  EXPECT_EQ(compare(with, with).parameters.size(), 11U);
  EXPECT_NEAR(named(compare(with, with).parameters, stiffness[0]).before, 3.0, 1e-9);
}

// The planar arm with a load on a frame of its own, and with the same load as a part of the link that carries it.
struct Loaded {
  Loaded() {
    frame.name = "load";
    frame.parent = FrameIndex{static_cast<int>(of_its_own.frames.size()) - 1};
    frame.A = {rotation_x(0.3), {0.1, 0.05, 0.02}};
    frame.variable.coefficients = VectorXd::Zero(2);
    frame.body = Body{};
    Eigen::Matrix<double, 6, 1> inertia;
    inertia << 2e-3, 0, 3e-3, 0, 0, 4e-3;
    frame.body->phi = inertial_parameters(0.8, Eigen::Vector3d(0.02, 0, 0.01), inertia);
    of_its_own.frames.push_back(frame);
    const Eigen::Matrix4d T = eigen(frame.A).matrix();
    *in_the_link.frames.back().body->phi += inertial_parameters(Eigen::Matrix4d(T * pseudo_inertia(*frame.body->phi) * T.transpose()));
  }
  Frame frame;
  ModelDescription of_its_own = planar().description(), in_the_link = planar().description();
};

void expect_equal_differences(const ModelComparison& a, const ModelComparison& b) {
  EXPECT_EQ(a.parameters.size(), 10U);
  EXPECT_TRUE(a.only_before.empty() && a.only_after.empty());
  for (const ModelDifference& p : b.parameters) {
    EXPECT_NEAR(named(a.parameters, p.name).difference, p.difference, 1e-9) << p.name;
    EXPECT_EQ(named(a.parameters, p.name).expression, p.expression);
  }
  for (std::size_t i = 0; i < b.torque.size(); ++i) EXPECT_NEAR(a.torque[i].difference, b.torque[i].difference, 1e-9) << i;
}

// A diagnosed load is a frame with a body: its parameters count with those of the link that carries it.
TEST(TheComparison, ComparesAnArmWithTheSameArmUnderALoad) {
  const Loaded load;
  const Model plain = with_statistics(planar(), 0.01, 8, 1), loaded = with_statistics(Model(load.of_its_own), 0.01, 8, 2);
  for (const bool turned : {false, true}) {
    const ModelComparison c = turned ? compare(loaded, plain) : compare(plain, loaded);
    ASSERT_EQ(c.structure.size(), 1U);
    EXPECT_EQ(c.structure[0].kind, StructureKind::kBody);
    EXPECT_NE(c.structure[0].sentence.find(turned ? "only the model before has the body load (0.8 kg)" : "only the model after has the body load (0.8 kg)"),
              std::string::npos)
        << c.structure[0].sentence;
    EXPECT_EQ(c.before.clusters, 8);  // the statistics of both count
    EXPECT_EQ(c.after.clusters, 8) << c.after.note;
    EXPECT_EQ(c.verdict, ComparisonVerdict::kDiffer);
    const Model link(load.in_the_link);
    expect_equal_differences(c, turned ? compare(link, plain) : compare(plain, link));
  }
}

// A known load, such as a tool that was weighed, counts in the values of the link that carries it.
TEST(TheComparison, CountsAKnownLoadWithTheLinkThatCarriesIt) {
  Loaded load;
  const Model plain = with_statistics(planar(), 0.01, 8, 1), link(load.in_the_link);
  ModelDescription known = plain.description();
  load.frame.body->fixed = true;
  known.frames.push_back(load.frame);
  for (const bool turned : {false, true}) {
    const ModelComparison c = turned ? compare(Model(known), plain) : compare(plain, Model(known));
    EXPECT_EQ((turned ? c.before : c.after).clusters, 8);
    expect_equal_differences(c, turned ? compare(link, plain) : compare(plain, link));
  }
}

// A body that is missing below a joint that moves is another arm.
TEST(TheComparison, RefusesAnArmWithOneMoreJointFrame) {
  ModelDescription d = planar().description();
  Frame more = d.frames.back();
  more.name = "more";
  more.parent = FrameIndex{static_cast<int>(d.frames.size()) - 1};
  d.frames.push_back(more);
  EXPECT_THROW(compare(planar(), Model(d)), InvalidInput);
}

TEST(TheComparison, ComparesNoMassesIfFramesAreElsewhere) {
  ModelFileOptions other;
  other.constants["l1"] = 0.6;
  const ModelComparison c = compare(with_statistics(planar(), 0.01, 8, 1),
                                    with_statistics(read_model("planar-2r", other), 0.01, 8, 2));
  ASSERT_FALSE(c.structure.empty());
  EXPECT_EQ(c.structure[0].kind, StructureKind::kGeometry);
  EXPECT_NE(c.structure[0].sentence.find("constant l1 is 0.5 before and 0.6 after"),
            std::string::npos);
  for (const ModelDifference& d : c.parameters) EXPECT_FALSE(d.effect.empty()) << d.name;
  EXPECT_EQ(c.parameters.size(), 4U);
  EXPECT_EQ(c.only_before.size(), 6U);
}

TEST(TheComparison, TakesAFileWithoutStatisticsAsExact) {
  const Model before = with_statistics(planar(), 0.02, 8, 1);
  const Model after = with_effect(kShoulderCoulomb, "level", 1.2);
  const ModelComparison c = compare(before, after);
  EXPECT_EQ(c.after.clusters, 0);
  const ModelDifference& d = named(c.parameters, kShoulderLevel);
  EXPECT_NEAR(d.difference, 0.24, 1e-9);
  EXPECT_GT(d.deviation, 0.0);
  const ModelComparison neither = compare(planar(), after);
  EXPECT_EQ(neither.verdict, ComparisonVerdict::kCannotTell);
  EXPECT_TRUE(std::isnan(neither.parameters[0].deviation));
  EXPECT_NEAR(neither.torque[0].difference, 0.24, 1e-3);
}

// Somebody edited the file after the identification.
TEST(TheComparison, IgnoresStatisticsThatContradictTheValues) {
  const Model before = with_statistics(planar(), 0.02, 8, 1);
  ModelDescription edited = before.description();
  edited.effects[kShoulderCoulomb].values["level"] = 9.0;
  const ModelComparison c = compare(before, Model(edited));
  EXPECT_EQ(c.after.clusters, 0);
  EXPECT_NE(c.after.note.find("changed after the identification"), std::string::npos);
  EXPECT_NEAR(named(c.parameters, kShoulderLevel).after, 9.0, 1e-9);
}

TEST(TheComparison, RefusesTwoRobotsAndModelsWithoutValues) {
  const auto error = [](const Model& a, const Model& b) -> std::string {
    try {
      compare(a, b);
    } catch (const InvalidInput& e) {
      return e.what();
    }
    return "no error";
  };
  EXPECT_NE(error(planar(), read_model("scara")).find("expected two models of one arm"),
            std::string::npos);
  ModelDescription renamed = planar().description();
  renamed.coordinates[1].name = "wrist";
  EXPECT_NE(error(planar(), Model(renamed)).find("coordinate 2 is 'elbow' before and 'wrist' after"),
            std::string::npos);
  ModelDescription bare = planar().description();
  bare.frames[1].body.reset();
  EXPECT_NE(error(planar(), Model(bare)).find("frame 'fore' is turning on upper with a body before and turning on upper without a body after"),
            std::string::npos);
  EXPECT_NE(error(read_model("psm-3dof"), read_model("psm-3dof")).find("without values"),
            std::string::npos);
}

// What a joint's quantities are, from the recursions and the same motion: the weight's mean and its amplitude along the
// joint's own sine, and the mean of M_ii.
TEST(TheComparison, MeasuresWeightAndInertiaOverTheStandardMotion) {
  ModelDescription leaning = planar().description();
  leaning.gravity = {-6.0, -7.0, 0.0};
  const Model arm(std::move(leaning));
  const ModelComparison itself = compare(arm, arm);
  RigidBodyDynamics bodies(arm, *arm.inertial_values());
  const MotionSamples motion = standard_motion(arm);
  const VectorXd zero = VectorXd::Zero(arm.joints());
  for (int i = 0; i < arm.joints(); ++i) {
    const double period = 1.0 / standard_frequency(i);
    const double whole = period * std::floor((motion.time[motion.rows() - 1] - motion.time[0]) / period);
    const VectorXd way = motion.q.col(i).array() - motion.q(0, i);
    double rows = 0.0, weight = 0.0, along = 0.0, inertia = 0.0;
    for (int k = 0; k < motion.rows() && motion.time[k] - motion.time[0] < whole - 1e-9; ++k) {
      VectorXd g(arm.joints());
      RigidBodyDynamics::TorqueDerivatives by;
      bodies.inverse_dynamics_derivatives(motion.q.row(k).transpose(), zero, zero, g, by);
      rows += 1.0;
      weight += g[i];
      along += 2.0 * g[i] * way[k] / way.cwiseAbs().maxCoeff();
      inertia += by.by_ddq(i, i);
    }
    EXPECT_NEAR(quantity(itself.joints, "weight", {i}).before, weight / rows, 1e-9) << i;
    EXPECT_NEAR(quantity(itself.joints, "weight_slope", {i}).before, along / rows, 1e-9) << i;
    EXPECT_NEAR(quantity(itself.joints, "inertia", {i}).before, inertia / rows, 1e-9) << i;
    EXPECT_GT(std::abs(along / rows), 1.0) << i;
  }
}

// "Falls" is ambiguous for negative values; a prismatic joint has no angle; the interval is that of the difference.
TEST(TheComparison, DescribesNegativeValuesAndPrismaticJoints) {
  ModelDifference d;
  d.joint = {2};
  d.unit = "N";
  d.before = -8.754;
  d.after = -0.029;
  d.difference = d.after - d.before;
  d.deviation = 0.06;
  d.low = 8.6;
  d.high = 8.85;
  const std::string words = joint_sentence(read_model("psm-3dof"), kJointQuantities[3], d);
  for (const char* part : {"follows the position of joint 3 (insertion) went from -8.75", "by +8.7",
                           " N, 95 %: +8.6", " to +8.85"})
    EXPECT_NE(words.find(part), std::string::npos) << words;
  EXPECT_EQ(words.find("-100"), std::string::npos) << words;
}

TEST(TheComparison, ListsTheMostSignificantDifferencesAndCountsTheOthers) {
  ModelComparison c;
  c.verdict = ComparisonVerdict::kDiffer;
  for (int k = 0; k < 20; ++k) {
    ModelDifference d;
    d.significant = true;
    d.t = k % 2 == 0 ? k : -k;
    d.sentence = "number " + std::to_string(k) + ".";
    c.parameters.push_back(d);
  }
  const std::string report = c.report();
  EXPECT_LT(report.find("number 19."), report.find("number 18."));
  EXPECT_EQ(report.find("number 3."), std::string::npos) << report;
  EXPECT_NE(report.find("and 12 more"), std::string::npos) << report;
}

}  // namespace
}  // namespace veridyn
