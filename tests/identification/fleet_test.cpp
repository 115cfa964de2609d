#include "veridyn/identification/fleet.hpp"

#include <gtest/gtest.h>

#include <unistd.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "identification/fleet/fleet_fit.hpp"
#include "identification/synthetic_recording.hpp"
#include "support/near.hpp"
#include "support/refusal.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

Model scara() {
  return read_model(VERIDYN_SOURCE_DIR "/data/robots/scara.yaml");
}

// The arm with its effects' values times these factors, one per standard parameter.
Model varied(const Model& arm, const VectorXd& factors) {
  const VectorXd values = true_parameters(arm).cwiseProduct(factors);
  return with_values(arm, values, VectorXd::Constant(values.size(), NAN));
}

struct Simulated {
  std::vector<std::string> names;
  std::vector<FactorSet> factors;
};

// A fleet whose friction differs by 5 % from arm to arm; `change` makes one of them odd.
template <typename Change>
Simulated fleet(int arms, int odd, const Change& change, unsigned seed = 3) {
  const Model arm = scara();
  const auto parameters = standard_parameters(arm);
  Random random(seed);
  Simulated out;
  for (int a = 0; a < arms; ++a) {
    VectorXd factors = VectorXd::Ones(parameters.size());
    for (size_t p = 0; p < parameters.size(); ++p)
      if (parameters[p].effect)
        factors[static_cast<Eigen::Index>(p)] = 1.0 + 0.05 * random.in(-1, 1);
    double gain = 1.0 + 0.005 * random.in(-1, 1);
    if (a == odd) change(parameters, factors, gain);
    MotionShape shape;
    shape.duration = 10.0;
    shape.rate = 100.0;
    shape.seed = static_cast<unsigned>(100 + a);
    Recording r = synthetic_recording(varied(arm, factors), shape);
    r.tau.col(1) *= gain;
    r.tau += noise_like(r.tau, 0.01, static_cast<unsigned>(a) + 1000 * (seed - 3));
    FactorSet set = compress(arm, std::vector<std::string>());
    set.recordings.push_back(compress(arm, r, {}));
    out.factors.push_back(std::move(set));
    out.names.push_back("arm-" + std::to_string(a));
  }
  return out;
}

void no_change(const std::vector<StandardParameter>&, VectorXd&, double&) {}

TEST(AFleet, FindsTheBodiesThatAllArmsShare) {
  const Model arm = scara();
  const Simulated all = fleet(12, -1, no_change);
  const Fleet found = identify_fleet(arm, all.names, all.factors);
  EXPECT_TRUE(found.outliers.empty()) << found.report();
  EXPECT_TRUE(found.other_bodies.empty()) << found.report();
  const BaseParameters base = base_parameters(arm);
  const VectorXd truth = base.K * true_parameters(arm);
  for (const BaseValue& b : found.base) {
    const auto at = std::find(base.names.begin(), base.names.end(), b.name) - base.names.begin();
    ASSERT_LT(at, base.size());
    EXPECT_NEAR(b.value, truth[at], 5.0 * b.std + 0.02 * std::abs(truth[at])) << b.expression;
  }
  for (const FleetSpread& s : found.spreads) EXPECT_EQ(s.arms, 12) << s.name;
}

// A tool left mounted must not bend the bodies of all, and the report says whose recordings were
// left out of them.
TEST(AFleet, NamesArmsExcludedFromTheSharedBodies) {
  const auto tool = [](const auto& parameters, VectorXd& factors, double&) {
    for (size_t p = 0; p < parameters.size(); ++p)
      if (parameters[p].body == 3) factors[static_cast<Eigen::Index>(p)] = 3.0;
  };
  const Simulated one_with_a_tool = fleet(12, 5, tool);
  const Simulated none = fleet(12, -1, no_change);
  const Fleet found =
      identify_fleet(scara(), one_with_a_tool.names, one_with_a_tool.factors);
  const Fleet same = identify_fleet(scara(), none.names, none.factors);
  ASSERT_EQ(found.other_bodies.size(), 1U) << found.report();
  const FleetLeftOut& out = found.other_bodies.front();
  EXPECT_EQ(out.arm, "arm-5");
  EXPECT_GT(out.with_fleet, out.with_own);
  EXPECT_NE(found.report().find("1 of 12 arms left out of the shared bodies"), std::string::npos);
  EXPECT_NE(found.report().find("arm-5:"), std::string::npos);
  ASSERT_EQ(found.base.size(), same.base.size());
  for (size_t k = 0; k < found.base.size(); ++k)
    EXPECT_NEAR(found.base[k].value, same.base[k].value, 3.0 * (found.base[k].std + same.base[k].std))
        << found.base[k].expression;
}

// Joints that go one way only: friction and offset are one column, and with bodies of its own the
// arm explains nearly everything, which says nothing of them.
FactorSet one_way(const Model& arm) {
  MotionShape shape;
  shape.duration = 4.0;
  shape.highest = 0.01;
  shape.rate = 100.0;
  FactorSet set = compress(arm, std::vector<std::string>());
  set.recordings.push_back(compress(arm, synthetic_recording(arm, shape), {}));
  return set;
}

TEST(AFleet, ExcludesArmsWithUndeterminedBodies) {
  Simulated all = fleet(12, -1, no_change);
  const Fleet same = identify_fleet(scara(), all.names, all.factors);
  EXPECT_TRUE(same.undetermined.empty());
  all.names.insert(all.names.begin() + 2, "one-way");
  all.factors.insert(all.factors.begin() + 2, one_way(scara()));
  const Fleet found = identify_fleet(scara(), all.names, all.factors);
  ASSERT_EQ(found.undetermined.size(), 1U) << found.report();
  EXPECT_EQ(found.undetermined[0].arm, "one-way");
  EXPECT_NE(found.undetermined[0].why.find("base parameters"), std::string::npos)
      << found.undetermined[0].why;
  EXPECT_TRUE(found.other_bodies.empty()) << found.report();
  EXPECT_NE(found.report().find("1 arm left out whose recordings leave the bodies open\n  one-way: "),
            std::string::npos)
      << found.report();
  EXPECT_EQ(found.members.size(), 12U);
  EXPECT_TRUE(near(found.parameters, same.parameters, 1e-12));
}

// Torques of zero would weigh infinitely.
TEST(AFleet, ExcludesArmsWithZeroTorques) {
  Simulated all = fleet(6, -1, no_change);
  MotionShape shape;
  shape.duration = 10.0;
  shape.rate = 100.0;
  Recording r = synthetic_recording(scara(), shape);
  r.tau.setZero();
  all.names.push_back("silent");
  all.factors.push_back(compress(scara(), std::vector<std::string>()));
  all.factors.back().recordings.push_back(compress(scara(), r, {}));
  const Fleet found = identify_fleet(scara(), all.names, all.factors);
  ASSERT_EQ(found.undetermined.size(), 1U) << found.report();
  EXPECT_EQ(found.undetermined[0].arm, "silent");
  EXPECT_NE(found.undetermined[0].why.find("zero throughout"), std::string::npos) << found.undetermined[0].why;
  all.factors.pop_back();
  all.names.pop_back();
  const Fleet same = identify_fleet(scara(), all.names, all.factors);
  EXPECT_TRUE(near(found.parameters, same.parameters, 1e-12));
}

TEST(AFleet, OfFewerThanThreeDeterminedArmsHasAReasonAndNoModel) {
  Simulated all = fleet(2, -1, no_change);
  const Fleet two = identify_fleet(scara(), all.names, all.factors);
  EXPECT_FALSE(two.model);
  EXPECT_EQ(two.reason, "found 2 arms, expected 3 at least");
  all.names.push_back("one-way");
  all.factors.push_back(one_way(scara()));
  const Fleet found = identify_fleet(scara(), all.names, all.factors);
  EXPECT_FALSE(found.model);
  EXPECT_NE(found.reason.find("one-way: "), std::string::npos) << found.reason;
}

// The spread of few arms is itself chance: equal ones are not named for it.
TEST(AFleet, OfFewEqualArmsHasNoOutliers) {
  for (const unsigned seed : {3U, 4U, 5U}) {
    for (const int arms : {3, 4, 5, 6, 8}) {
      const Simulated all = fleet(arms, -1, no_change, seed);
      const Fleet found = identify_fleet(scara(), all.names, all.factors);
      ASSERT_TRUE(found.model);
      EXPECT_TRUE(found.outliers.empty()) << arms << ": " << found.report();
      EXPECT_TRUE(found.other_bodies.empty()) << arms << ": " << found.report();
    }
  }
}

// What an arm's short recording hardly determines differs from the others' values by chance.
TEST(AFleet, DoesNotReportAnArmWithAShortRecordingAsAnOutlier) {
  const Model arm = scara();
  MotionShape shape;
  shape.duration = 2.0;  // a fifth of the others'
  shape.rate = 100.0;
  for (const unsigned seed : {3U, 4U, 5U}) {
    Simulated all = fleet(12, -1, no_change, seed);
    shape.seed = seed;
    Recording r = synthetic_recording(arm, shape);
    r.tau += noise_like(r.tau, 0.01, seed);
    all.names.push_back("short");
    all.factors.push_back(compress(arm, std::vector<std::string>()));
    all.factors.back().recordings.push_back(compress(arm, r, {}));
    const Fleet found = identify_fleet(arm, all.names, all.factors);
    EXPECT_EQ(found.members.size(), 13U) << found.report();
    EXPECT_TRUE(found.outliers.empty()) << found.report();
  }
}

// Doubles the first viscous friction.
void double_friction(const std::vector<StandardParameter>& parameters, VectorXd& factors, double&) {
  for (size_t p = 0; p < parameters.size(); ++p)
    if (parameters[p].name.find("viscous_friction") == 0 && parameters[p].effect) {
      factors[static_cast<Eigen::Index>(p)] = 2.0;
      return;
    }
}

// Of a dozen, and of four: the spreads of the other quantities say how far chance reaches.
TEST(AFleet, NamesTheArmWithAnotherFriction) {
  for (const int arms : {4, 5, 12}) {
    const int odd = arms / 2;
    const Simulated all = fleet(arms, odd, double_friction);
    const Fleet found = identify_fleet(scara(), all.names, all.factors);
    ASSERT_FALSE(found.outliers.empty()) << found.report();
    EXPECT_EQ(found.outliers[0].arm, "arm-" + std::to_string(odd));
    EXPECT_EQ(found.outliers[0].what.find("viscous_friction"), 0) << found.report();
    for (const FleetOutlier& o : found.outliers) EXPECT_EQ(o.arm, found.outliers[0].arm);
  }
}

TEST(AFleet, NamesTheArmWithAnotherGain) {
  const Simulated all =
      fleet(12, 4, [](const auto&, VectorXd&, double& gain) { gain = 1.15; });
  const Fleet found = identify_fleet(scara(), all.names, all.factors);
  ASSERT_FALSE(found.outliers.empty()) << found.report();
  const auto gain = std::find_if(found.outliers.begin(), found.outliers.end(), [](const auto& o) {
    return o.what.find("torque_gain:") == 0;
  });
  ASSERT_NE(gain, found.outliers.end()) << found.report();
  EXPECT_EQ(gain->arm, "arm-4");
  EXPECT_EQ(gain->joint, JointIndex{1});
  EXPECT_NEAR(gain->value / gain->median, 1.15, 0.02);
}

// Elimination arm by arm against one dense QR of the whole block arrow.
TEST(AFleet, EqualsADenseLeastSquaresOfAllArms) {
  const Model arm = scara();
  const Simulated all = fleet(5, -1, no_change);
  std::vector<ArmFactor> arms;
  for (size_t a = 0; a < all.factors.size(); ++a) {
    ArmFactor one;
    one.name = all.names[a];
    for (const auto& block : all.factors[a].recordings[0].blocks) {
      if (one.joints.empty()) {
        one.joints = block;
      } else {
        for (size_t i = 0; i < block.size(); ++i) one.joints[i].merge(block[i]);
      }
    }
    arms.push_back(one);
  }
  const FleetFit fit(arm, arms, {});
  const VectorXd weights = VectorXd::LinSpaced(arm.joints(), 0.5, 2.0);
  const Eigen::Index shared = fit.shared();
  SquareRootInformation total({fit.columns().end() - shared, fit.columns().end()});
  std::vector<SquareRootInformation> factors;
  for (const ArmFactor& one : arms) {
    factors.push_back(fit.arm_factor(fit.with_gains(one, {}), weights));
    total.merge(fit.shared_information(factors.back()));
  }
  const VectorXd beta = Eigen::ColPivHouseholderQR<MatrixXd>(total.R()).solve(total.z());
  const Eigen::Index own = factors[0].size() - shared;
  const auto count = static_cast<Eigen::Index>(arms.size());
  MatrixXd A = MatrixXd::Zero(count * factors[0].size(), count * own + shared);
  VectorXd b(A.rows());
  for (Eigen::Index a = 0; a < count; ++a) {
    const SquareRootInformation& f = factors[a];
    A.block(a * f.size(), a * own, f.size(), own) = f.R().leftCols(own);
    A.block(a * f.size(), count * own, f.size(), shared) = f.R().rightCols(shared);
    b.segment(a * f.size(), f.size()) = f.z();
  }
  const VectorXd x = Eigen::ColPivHouseholderQR<MatrixXd>(A).solve(b);
  EXPECT_TRUE(near(beta, VectorXd(x.tail(shared)), 1e-8 * (1.0 + x.tail(shared).norm())));
  for (Eigen::Index a = 0; a < count; ++a)
    EXPECT_TRUE(near(VectorXd(fit.values(factors[a], beta).head(own)),
                     VectorXd(x.segment(a * own, own)), 1e-7 * (1.0 + x.norm())));
}

// One arm's logger writes the velocity of a joint in degrees. Taken as it is, it would look like
// other bodies and other friction.
TEST(AFleet, DerivesInconsistentVelocitiesFromThePosition) {
  const Model arm = scara();
  const auto folder = std::filesystem::temp_directory_path() / ("veridyn-fleet-" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  std::vector<FleetArm> arms;
  for (int a = 0; a < 5; ++a) {
    MotionShape shape;
    shape.duration = 10.0;
    shape.rate = 100.0;
    shape.seed = static_cast<unsigned>(100 + a);
    Recording r = synthetic_recording(arm, shape);
    r.tau += noise_like(r.tau, 0.01, static_cast<unsigned>(a));
    if (a == 2) r.dq.col(1) *= 180.0 / M_PI;
    arms.push_back({"arm-" + std::to_string(a), {(folder / (std::to_string(a) + ".csv")).string()}});
    write_recording(r, arms.back().files.front());
  }
  const Fleet found = identify_fleet(arm, arms);
  // Factors that identify() made of that recording say the same.
  PreprocessingOptions derived;
  derived.derive_velocity_of = {{1}};
  std::vector<FleetArm> with_factors = arms;
  with_factors[2].files.front() = (folder / "2.factors").string();
  save_factors(compress(arm, arms[2].files, derived), with_factors[2].files.front());
  const Fleet same = identify_fleet(arm, with_factors);
  EXPECT_TRUE(same.unusable_recordings.empty()) << same.report();
  EXPECT_TRUE(near(same.parameters, found.parameters, 1e-9 * found.parameters.norm()));
  std::filesystem::remove_all(folder);
  EXPECT_TRUE(found.outliers.empty()) << found.report();
  EXPECT_TRUE(found.other_bodies.empty()) << found.report();
  ASSERT_EQ(found.remarks.size(), 1U) << found.report();
  EXPECT_NE(found.remarks[0].find("2.csv: dq2"), std::string::npos) << found.remarks[0];
  for (const FleetMember& m : found.members) EXPECT_LT(m.relative_error.maxCoeff(), 0.03) << m.name;
}

TEST(AFleet, RefusesProbabilitiesOutsideOfZeroToOne) {
  const Simulated some = fleet(3, -1, no_change);
  for (const double p : {0.0, -0.1, 1.0, std::nan("")}) {
    FleetOptions options;
    options.significance = p;
    EXPECT_TRUE(refuses_with("significance", [&] { identify_fleet(scara(), some.names, some.factors, options); })) << p;
  }
}

TEST(AFleet, ReadsItsListAndRefusesInvalidLines) {
  const std::string folder = testing::TempDir() + "veridyn-fleet-list";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const std::string path = folder + "/list.csv";
  std::ofstream(path) << "arm,file\n# comment\nred,a.csv\nblue, b.csv\nred,/c.csv\n";
  const std::vector<FleetArm> arms = read_fleet(path);
  ASSERT_EQ(arms.size(), 2);
  EXPECT_EQ(arms[0].files, (std::vector<std::string>{folder + "/a.csv", "/c.csv"}));
  EXPECT_EQ(arms[1].name, "blue");
  std::ofstream(path) << "\xEF\xBB\xBF" "arm,file\r\nred\ta.csv\r\n";  // as a spreadsheet may write it
  ASSERT_EQ(read_fleet(path).size(), 1U);
  EXPECT_EQ(read_fleet(path)[0].name, "red");
  std::ofstream(path) << "red\n";
  EXPECT_THROW(read_fleet(path), InvalidInput);
  std::ofstream(path) << "";
  EXPECT_THROW(read_fleet(path), InvalidInput);
  // One recording, by another path of it, by links, and as a copy; two files of one size are two.
  std::ofstream(folder + "/full.csv") << "t,q1\n0,1\n";
  std::ofstream(folder + "/other.csv") << "t,q1\n0,2\n";
  std::filesystem::create_symlink("full.csv", folder + "/link.csv");
  std::filesystem::create_hard_link(folder + "/full.csv", folder + "/hard.csv");
  std::filesystem::copy_file(folder + "/full.csv", folder + "/copy.csv");
  for (const std::string same : {"./full.csv", "link.csv", "hard.csv", "copy.csv"}) {
    std::ofstream(path) << "red,full.csv\nblue,other.csv\ngreen," << same << "\n";
    try {
      read_fleet(path);
      ADD_FAILURE() << "one recording under two arms was taken: " << same;
    } catch (const InvalidInput& e) {
      EXPECT_NE(std::string(e.what()).find("list.csv:3: found"), std::string::npos) << e.what();
      EXPECT_NE(std::string(e.what()).find("as in line 1"), std::string::npos) << e.what();
    }
  }
  std::ofstream(path) << "red,a.csv\nblue,./a.csv\n";  // though it does not exist
  EXPECT_THROW(read_fleet(path), InvalidInput);
  EXPECT_THROW(identify_fleet(scara(), {{"red", {"missing.csv"}}}), InvalidInput);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace veridyn
