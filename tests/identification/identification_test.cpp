#include "veridyn/identification/identification.hpp"
#include "veridyn/identification/parameters_text.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "identification/synthetic_recording.hpp"
#include "support/near.hpp"
#include "identification/base_solution.hpp"
#include "veridyn/identification/pseudo_inertia.hpp"
#include "veridyn/math/require.hpp"
#include "math/zero_phase_filter.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

Model robot(const std::string& name) {
  return read_model(VERIDYN_SOURCE_DIR "/data/robots/" + name + ".yaml");
}

MotionShape lasting(double seconds, double period = 0.0, unsigned seed = 1) {
  MotionShape shape;
  shape.duration = seconds;
  shape.period = period;
  shape.seed = seed;
  return shape;
}

Recording noisy(const Model& arm, const MotionShape& shape, double share, unsigned seed) {
  Recording r = synthetic_recording(arm, shape);
  r.tau += noise_like(r.tau, share, seed);
  return r;
}

IdentificationOptions with(Method method) {
  IdentificationOptions o;
  o.method = method;
  return o;
}

// Base parameters of the arm's own values, by the name that the identification gives them.
std::map<std::string, double> true_base(const Model& arm) {
  const BaseParameters base = base_parameters(arm);
  const VectorXd beta = base.K * true_parameters(arm);
  std::map<std::string, double> out;
  for (int j = 0; j < base.size(); ++j) out[base.expressions[j]] = beta[j];
  return out;
}

// ||a - b|| over ||b|| of torques at random states, worst joint.
double torque_difference(const Model& arm, const VectorXd& a, const VectorXd& b) {
  const MatrixXd Y = random_regressor(arm, 80, 9);
  const VectorXd error = Y * (a - b);
  const VectorXd torque = Y * b;
  double worst = 0.0;
  for (int i = 0; i < arm.joints(); ++i) {
    const auto of_joint = [&](const VectorXd& v) {
      return VectorXd(Eigen::Map<const MatrixXd>(v.data(), arm.joints(), 80).row(i)).norm();
    };
    worst = std::max(worst, of_joint(error) / of_joint(torque));
  }
  return worst;
}

bool every_body_possible(const Model& arm, const VectorXd& parameters) {
  for (size_t b = 0; b < arm.bodies().size(); ++b) {
    const InertialVector phi = parameters.segment<10>(static_cast<Eigen::Index>(10 * b));
    if (smallest_eigenvalue(pseudo_inertia(phi)) <= 0.0) return false;
  }
  return true;
}

// ---- the truth comes back
// ------------------------------------------------------------------------------------------

class OfTextbookArms : public testing::TestWithParam<std::string> {
 protected:
  const Model arm_ = robot(GetParam());
};
INSTANTIATE_TEST_SUITE_P(Arms, OfTextbookArms, testing::Values("planar-2r", "scara", "elbow-6r"),
                         [](const auto& test) {
                           std::string name = test.param;
                           for (char& c : name)
                             c = std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
                           return name;
                         });

// What is wrong without noise is the derivative of the velocity, (w h)^4 / 30 = 3e-8 at 1 Hz, and
// what the ends of the light filter leave after 1.2 s and 0.5 s, about 1e-5 of a sample. So: 1e-4
// of itself, or 1e-6 of the largest of its unit.
TEST_P(OfTextbookArms, NoiseFreeRecordingsRecoverTheTrueParameters) {
  const Recording r = synthetic_recording(arm_, lasting(30.0));
  const std::map<std::string, double> truth = true_base(arm_);
  for (const Method method : {Method::kOls, Method::kWls, Method::kFeasible}) {
    const Identification id = identify(arm_, r, with(method));
    ASSERT_EQ(id.status, IdentificationStatus::kDone) << id.reason;
    ASSERT_EQ(id.base.size(), truth.size());
    for (const BaseValue& b : id.base) {
      ASSERT_EQ(truth.count(b.expression), 1U) << b.expression;
      double largest = 0.0;
      for (const BaseValue& other : id.base) {
        if (other.unit == b.unit) largest = std::max(largest, std::abs(other.value));
      }
      const double expected = truth.at(b.expression);
      EXPECT_NEAR(b.value, expected, std::max(1e-4 * std::abs(expected), 1e-6 * largest))
          << b.expression;
    }
    EXPECT_LT(torque_difference(arm_, id.parameters, true_parameters(arm_)), 1e-4);
    EXPECT_LT(id.train_error.relative.maxCoeff(), 1e-4);
    EXPECT_GT(id.rank_gap, 1e3);
    EXPECT_TRUE(id.feasible || method != Method::kFeasible);
  }
}

TEST_P(OfTextbookArms, FilterAndVelocityOptionsDoNotBiasTheParameters) {
  const Recording r = synthetic_recording(arm_, lasting(30.0));
  IdentificationOptions o = with(Method::kOls);
  for (const double cutoff : {0.0, 3.0, 20.0}) {
    for (const VelocitySource velocity : {VelocitySource::kRecorded, VelocitySource::kDerived}) {
      o.preprocessing.cutoff = cutoff;
      o.preprocessing.velocity = velocity;
      // The ends' transients die away as fast as the cut-off is high. A derivative of a derivative
      // loses twice.
      o.preprocessing.drop_start = o.preprocessing.drop_end =
          cutoff > 0.0 ? std::max(1.2, 6.0 / cutoff) : 0.1;
      EXPECT_LT(torque_difference(arm_, identify(arm_, r, o).parameters, true_parameters(arm_)),
                3e-4)
          << cutoff;
    }
  }
}

// (value - truth) / std should scatter with standard deviation one; over all base parameters of
// three draws.
TEST_P(OfTextbookArms, StandardDeviationsCoverTheErrors) {
  const std::map<std::string, double> truth = true_base(arm_);
  for (const double period : {0.0, 7.5}) {
    double z2 = 0.0;
    int count = 0;
    for (unsigned seed = 1; seed <= 3; ++seed) {
      const Identification id =
          identify(arm_, noisy(arm_, lasting(30.0, period, 4), 0.1, seed), with(Method::kWls));
      ASSERT_EQ(id.status, IdentificationStatus::kDone);
      for (const BaseValue& b : id.base) {
        ASSERT_GT(b.std, 0.0);
        z2 += std::pow((b.value - truth.at(b.expression)) / b.std, 2);
        ++count;
      }
      EXPECT_LE(id.effective_samples, id.rows);
    }
    const double rms = std::sqrt(z2 / count);
    EXPECT_GT(rms, 0.5) << "period " << period;
    EXPECT_LT(rms, 2.0) << "period " << period;
  }
}

// Residual weights are the inverse noise of every joint: they beat none where joints differ.
TEST(ResidualWeights, ReduceTheErrorIfJointNoiseDiffers) {
  const Model arm = robot("elbow-6r");
  Recording r = synthetic_recording(arm, lasting(30.0));
  MatrixXd noise = noise_like(r.tau, 0.02, 5);
  noise.col(1) *= 10.0;
  r.tau += noise;
  IdentificationOptions o = with(Method::kWls);
  o.weights = JointWeights::kResidual;
  const double weighted =
      torque_difference(arm, identify(arm, r, o).parameters, true_parameters(arm));
  EXPECT_LT(weighted, 0.5 * torque_difference(arm, identify(arm, r, with(Method::kOls)).parameters,
                                              true_parameters(arm)));
}

// ---- matched filtering: what goes wrong otherwise
// ------------------------------------------------------------------

// One joint with 2 N m of Coulomb friction that reverses about twice a second, low-passed at 4 Hz.
Model one_joint() {
  return read_yaml(R"(
veridyn: 1
name: one-joint
source: test
gravity: [0, 0, 0]
convention: standard
coordinates:
  - {name: turn, limits: {position: [-2, 2]}}
frames:
  - {name: rod, parent: world, dh: [0.3, 0, 0, 0], revolute: {turn: 1},
     body: {mass: 1, com: [-0.1, 0, 0], inertia: {xx: 0.01, yy: 0.02, zz: 0.02}}}
effects:
  - {effect: viscous_friction, axis: {turn: 1}, coefficient: 0.5}
  - {effect: coulomb_friction, axis: {turn: 1}, level: 2.0}
)",
                   "one-joint.yaml");
}

TEST(Coulomb, FrictionIsUnbiasedOnlyWithMatchedFiltering) {
  const Model arm = one_joint();
  MotionShape shape = lasting(40.0);
  shape.highest = 1.5;
  const Recording r = synthetic_recording(arm, shape);
  const auto level = [&](Filtering filtering) {
    IdentificationOptions o = with(Method::kOls);
    o.preprocessing.cutoff = 4.0;
    o.preprocessing.filtering = filtering;
    const Identification id = identify(arm, r, o);
    const std::vector<std::string> names = parameter_names(standard_parameters(arm));
    const auto at =
        std::find(names.begin(), names.end(), "coulomb_friction(turn).level") - names.begin();
    EXPECT_LT(at, id.parameters.size());
    return id.parameters[at];
  };
  EXPECT_NEAR(level(Filtering::kMatched), 2.0, 0.01 * 2.0);
  EXPECT_GT(std::abs(level(Filtering::kSignals) - 2.0), 0.05 * 2.0);
}

// ---- feasible
// ------------------------------------------------------------------------------------------------------

// Of one sum of squares over two sets of columns.
constexpr double kRounding = 1e-12;

class FeasibleFits : public testing::TestWithParam<std::string> {
 protected:
  const Model arm_ = robot(GetParam());
  // Enough noise to push small bodies over the edge.
  const Recording noisy_ = noisy(arm_, lasting(25.0), 0.3, 7);
};
INSTANTIATE_TEST_SUITE_P(Arms, FeasibleFits, testing::Values("scara", "elbow-6r"),
                         [](const auto& test) {
                           return test.param == "scara" ? std::string("scara")
                                                        : std::string("elbow");
                         });

TEST_P(FeasibleFits, AreConsistentAndNeverBelowTheUnconstrainedOptimum) {
  const Identification free = identify(arm_, noisy_, with(Method::kWls));
  const Identification id = identify(arm_, noisy_, with(Method::kFeasible));
  ASSERT_EQ(id.status, IdentificationStatus::kDone) << id.reason;
  EXPECT_TRUE(id.feasible);
  EXPECT_TRUE(every_body_possible(arm_, id.parameters));
  EXPECT_EQ(free.feasible, every_body_possible(arm_, free.parameters));
  EXPECT_GE(id.objective, id.unconstrained_objective * (1.0 - kRounding));
  EXPECT_DOUBLE_EQ(id.unconstrained_objective, free.objective);
  EXPECT_LE(id.duality_gap, 1e-6);
  // Signs of friction and boxes of the file hold as well.
  const std::vector<StandardParameter> parameters = standard_parameters(arm_);
  for (size_t j = 0; j < parameters.size(); ++j) {
    EXPECT_GE(id.parameters[static_cast<Eigen::Index>(j)], parameters[j].lower)
        << parameters[j].name;
    if (parameters[j].component == 0 && !parameters[j].effect) {
      EXPECT_LE(id.parameters[static_cast<Eigen::Index>(j)], arm_.description().box.mass_max)
          << parameters[j].name;
    }
  }
}

// Every physically consistent body has positive principal moments, so that this weaker condition alone fits no
// worse.
TEST_P(FeasibleFits, PrincipalMomentsAloneFitNoWorseThanFullConsistency) {
  IdentificationOptions o = with(Method::kFeasible);
  const Identification strict = identify(arm_, noisy_, o);
  o.condition = PhysicalCondition::kPrincipalMoments;
  const Identification weak = identify(arm_, noisy_, o);
  EXPECT_LE(weak.objective, strict.objective * (1.0 + 1e-8));
  EXPECT_GE(weak.objective, weak.unconstrained_objective * (1.0 - kRounding));
  EXPECT_EQ(weak.feasible, every_body_possible(arm_, weak.parameters));
}

TEST_P(FeasibleFits, EqualAHeavyPriorAndIgnoreALightOne) {
  ModelDescription d = arm_.description();
  d.name = "prior";
  for (Frame& f : d.frames) {
    if (f.body) *f.body->phi *= 1.3;  // denser, and as possible as before
  }
  const VectorXd expected = *Model(d).inertial_values();
  IdentificationOptions o = with(Method::kFeasible);
  const Identification none = identify(arm_, noisy_, o);
  o.prior = Model(d);
  o.prior_weight = 1e7;
  const Identification heavy = identify(arm_, noisy_, o);
  EXPECT_EQ(heavy.prior, "prior");
  EXPECT_TRUE(heavy.feasible);
  for (Eigen::Index j = 0; j < expected.size(); ++j) {
    const Eigen::Index mass = 10 * (j / 10);
    EXPECT_NEAR(heavy.parameters[j], expected[j], 1e-2 * expected[mass]) << j;
  }
  EXPECT_GE(heavy.objective, none.objective * (1.0 - 1e-8));
  o.prior_weight = 1e-6;
  const Identification light = identify(arm_, noisy_, o);
  EXPECT_NEAR(light.objective, none.objective, 1e-3 * none.objective);
  EXPECT_LT((light.objective - none.objective), heavy.objective - none.objective);
}

// ---- facts
// ---------------------------------------------------------------------------------------------------------

// A body whose values are facts keeps them, and the others are what they are beside it.
TEST(Facts, OfABodyAreKeptAndTheOthersIdentified) {
  for (const char* name : {"planar-2r", "scara"}) {
    ModelDescription d = robot(name).description();
    Frame& last = *std::find_if(d.frames.rbegin(), d.frames.rend(),
                                [](const Frame& f) { return f.body.has_value(); });
    last.body->fixed = true;
    const Model arm{d};
    const Recording r = synthetic_recording(arm, lasting(25.0));
    const Eigen::Index at = 10 * (static_cast<Eigen::Index>(arm.bodies().size()) - 1);
    for (const Method method : {Method::kOls, Method::kWls, Method::kFeasible}) {
      const Identification id = identify(arm, r, with(method));
      ASSERT_EQ(id.status, IdentificationStatus::kDone) << name << ": " << id.reason;
      EXPECT_TRUE(near(id.parameters.segment(at, 10), *last.body->phi, 0.0));
      EXPECT_LT(torque_difference(arm, id.parameters, true_parameters(arm)), 1e-4) << name;
      EXPECT_TRUE(id.model->frames().back().body->fixed ||
                  id.model->description().frames.back().name != last.name);
    }
  }
}

TEST(Facts, OfEffectsAreKeptAndTheOthersIdentified) {
  ModelDescription d = robot("planar-2r").description();
  for (EffectTerm& term : d.effects) term.fixed = term.effect == "coulomb_friction";
  const Model arm{d};
  for (const Method method : {Method::kOls, Method::kFeasible}) {
    const Identification id = identify(arm, synthetic_recording(arm, lasting(25.0)), with(method));
    ASSERT_EQ(id.status, IdentificationStatus::kDone) << id.reason;
    EXPECT_LT(torque_difference(arm, id.parameters, true_parameters(arm)), 1e-4);
    const std::vector<StandardParameter> parameters = standard_parameters(arm);
    for (size_t j = 0; j < parameters.size(); ++j) {
      if (!parameters[j].fixed) continue;
      EXPECT_EQ(id.parameters[static_cast<Eigen::Index>(j)], parameters[j].value)
          << parameters[j].name;
    }
  }
}

// ---- data that cannot answer
// ---------------------------------------------------------------------------------------

TEST(AJointThatNeverMoves, IsNamedWithTheParametersItLeavesUndetermined) {
  for (const int still : {0, 5}) {
    const Model arm = robot("elbow-6r");
    MatrixXd ddq;
    Recording r = sines(arm, lasting(20.0), ddq);
    r.q.col(still).setConstant(0.3);
    r.dq.col(still).setZero();
    ddq.col(still).setZero();
    r.tau = torques(arm, r, ddq);
    const std::string joint = arm.coordinates()[still].name;
    const Identification id = identify(arm, r);
    EXPECT_EQ(id.status, IdentificationStatus::kRankDeficient);
    EXPECT_EQ(id.still_joints, std::vector<std::string>{joint});
    EXPECT_FALSE(id.model.has_value());
    EXPECT_NE(id.reason.find("joint " + joint + " never moves"), std::string::npos) << id.reason;
    const std::string friction = "viscous_friction(" + joint + ").coefficient";
    EXPECT_NE(std::find(id.undetermined.begin(), id.undetermined.end(), friction),
              id.undetermined.end())
        << id.reason;
    EXPECT_NE(id.reason.find(friction), std::string::npos);
    // Another joint's friction is not open.
    for (const std::string& open : id.undetermined)
      EXPECT_EQ(open.find("viscous_friction(elbow)"), std::string::npos) << open;
    EXPECT_THROW(save(id, testing::TempDir() + "nothing.yaml"), InvalidInput);
  }
}

TEST(AMotionThatIsTooPoor, IsReportedAsRankDeficient) {
  const Model arm = robot("planar-2r");
  // Both joints at one slow speed forever: inertia does not act.
  Recording r;
  r.source = "poor";
  r.time = VectorXd::LinSpaced(4000, 0.0, 20.0);
  r.q = MatrixXd(4000, 2);
  r.q.col(0) = 0.1 * r.time;
  r.q.col(1) = 0.05 * r.time;
  r.dq = MatrixXd(4000, 2);
  r.dq.col(0).setConstant(0.1);
  r.dq.col(1).setConstant(0.05);
  r.tau = torques(arm, r, MatrixXd::Zero(4000, 2));
  const Identification id = identify(arm, r);
  EXPECT_EQ(id.status, IdentificationStatus::kRankDeficient);
  EXPECT_TRUE(id.still_joints.empty());
  EXPECT_NE(id.reason.find(" of 10 base parameters"), std::string::npos) << id.reason;
  EXPECT_FALSE(id.undetermined.empty());
}

TEST(ARecordingWithoutUsableSamples, HasTheStatusNoData) {
  const Model arm = robot("planar-2r");
  const Identification id = identify(arm, synthetic_recording(arm, lasting(1.5)));
  EXPECT_EQ(id.status, IdentificationStatus::kNoData);
  EXPECT_NE(id.reason.find("no usable samples"), std::string::npos) << id.reason;
  EXPECT_NE(id.report().find("no model"), std::string::npos);
  EXPECT_THROW(identify(arm, std::vector<std::string>{}), InvalidInput);
}

// ---- what is reported
// ----------------------------------------------------------------------------------------------

// What gaps take from a recording is said, of those it was learned from and of those it was tested on.
TEST(GapsOfARecording, AreReportedWithTheShareOfSamplesLost) {
  const Model arm = robot("planar-2r");
  MotionShape shape;
  Recording whole = synthetic_recording(arm, shape);
  Recording holed = whole;
  holed.source = "holed";
  holed.tau.middleRows(2000, 1200).setConstant(std::numeric_limits<double>::quiet_NaN());
  const auto said = [](const Identification& id) {
    return std::count_if(id.remarks.begin(), id.remarks.end(), [](const std::string& remark) {
      return remark.find("holed: 2") == 0 && remark.find("% of the samples lie in gaps") != std::string::npos;
    });
  };
  EXPECT_EQ(said(identify(arm, whole, whole)), 0);
  EXPECT_EQ(said(identify(arm, holed, whole)), 1);
  EXPECT_EQ(said(identify(arm, whole, holed)), 1);
}

TEST(TheNoiseFloor, EqualsTheFilteredNoiseOfTheTrainingRecording) {
  const Model arm = robot("scara");
  const Recording clean = synthetic_recording(arm, lasting(60.0, 6.0));
  Recording r = clean;
  const MatrixXd noise = noise_like(clean.tau, 0.1, 3);
  r.tau += noise;
  const Identification id = identify(arm, r);
  ASSERT_EQ(id.noise_floor.size(), 4);
  MatrixXd planted = noise;
  ZeroPhaseFilter(5.0, 6, 200.0).apply(planted);
  for (int i = 0; i < 4; ++i) {
    const double expected = planted.col(i).norm() / r.tau.col(i).norm();
    EXPECT_NEAR(id.noise_floor[i], expected, 0.15 * expected);
    // A right model's error is all noise.
    EXPECT_NEAR(id.train_error.relative[i], expected, 0.15 * expected);
  }
}

TEST(ASavedModel, PredictsTheSameTorques) {
  const Model arm = robot("elbow-6r");
  const Identification id = identify(arm, noisy(arm, lasting(20.0), 0.05, 2));
  ASSERT_TRUE(id.model.has_value());
  EXPECT_TRUE(near(true_parameters(*id.model), id.parameters, 0.0));
  const std::string path = testing::TempDir() + "identification_test.yaml";
  save(id, path);
  const Model again = read_model(path);
  EXPECT_LT(torque_difference(arm, true_parameters(again), id.parameters), 1e-9);
  std::filesystem::remove(path);
}

TEST(Errors, OfEachRecordingEqualThoseOfTheFittedModel) {
  const Model arm = robot("planar-2r");
  const std::string folder = testing::TempDir();
  const std::vector<std::string> train{folder + "id_test_a.csv", folder + "id_test_b.csv"};
  const std::vector<std::string> test{folder + "id_test_c.csv"};
  std::vector<Recording> recordings;
  for (unsigned k = 0; k < 3; ++k) {
    recordings.push_back(noisy(arm, lasting(20.0, 0.0, k + 1), 0.1, k));
    write_recording(recordings.back(), k < 2 ? train[k] : test[0]);
  }
  IdentificationOptions o = with(Method::kOls);
  o.preprocessing.cutoff = 0.0;
  o.preprocessing.drop_start = o.preprocessing.drop_end = 0.0;
  std::vector<double> progress;
  o.progress = [&](const std::string&, double share) { progress.push_back(share); };
  const Identification id = identify(arm, train, test, o);
  ASSERT_EQ(id.status, IdentificationStatus::kDone) << id.reason;
  ASSERT_EQ(id.train.size(), 2U);
  ASSERT_EQ(id.test.size(), 1U);
  Eigen::Vector2d train_error2 = Eigen::Vector2d::Zero();
  Eigen::Vector2d train_torque2 = Eigen::Vector2d::Zero();
  for (size_t k = 0; k < 3; ++k) {
    const Recording& r = recordings[k];
    const MatrixXd ddq = differentiate(r.dq, 0.005);
    MatrixXd error = r.tau;
    for (Eigen::Index row = 0; row < r.rows(); ++row) {
      error.row(row) -= full_regressor(arm, r.q.row(row).transpose(), r.dq.row(row).transpose(),
                                       ddq.row(row).transpose()) *
                        id.parameters;
    }
    const RecordingError& reported = k < 2 ? id.train[k] : id.test[0];
    EXPECT_EQ(reported.source, k < 2 ? train[k] : test[0]);
    for (int i = 0; i < 2; ++i)
      EXPECT_NEAR(reported.error.relative[i], error.col(i).norm() / r.tau.col(i).norm(), 1e-6);
    if (k == 2) continue;
    train_error2 += error.colwise().squaredNorm().transpose();
    train_torque2 += r.tau.colwise().squaredNorm().transpose();
  }
  EXPECT_TRUE(near(id.train_error.relative,
                   (train_error2.array() / train_torque2.array()).sqrt().matrix(), 1e-6));
  EXPECT_TRUE(near(id.test_error.relative, id.test[0].error.relative, 0.0));
  EXPECT_EQ(id.rows, 2 * 2 * 4000.0);
  // Held-out recordings take no part in the fit, nor does the number of threads.
  o.progress = nullptr;
  o.threads = 1;
  EXPECT_TRUE(near(identify(arm, train, {}, o).parameters, id.parameters, 0.0));
  EXPECT_TRUE(std::is_sorted(progress.begin(), progress.end()));
  EXPECT_EQ(progress.back(), 1.0);
  for (const std::string& path : {train[0], train[1], test[0]}) std::filesystem::remove(path);
}

TEST(TheReport, NamesStatusErrorsAndBaseParameters) {
  const Model arm = robot("planar-2r");
  const Identification id = identify(arm, noisy(arm, lasting(20.0), 0.05, 2));
  const std::string text = id.report() + parameters_text(id);
  EXPECT_EQ(id.report().find("coulomb_friction(elbow).level"), std::string::npos);
  for (const char* word : {"planar-2r", "feasible least squares", "10 base parameters", "rank gap",
                           "training", "coulomb_friction(elbow).level"}) {
    EXPECT_NE(text.find(word), std::string::npos) << word << " in\n" << text;
  }
}

}  // namespace
}  // namespace veridyn
