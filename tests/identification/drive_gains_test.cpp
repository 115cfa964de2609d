#include "veridyn/identification/drive_gains.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "identification/synthetic_recording.hpp"
#include "support/near.hpp"
#include "veridyn/identification/identification.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"

// Currents made from the torques of arms with values, with gains that the search does not know.

namespace veridyn {
namespace {

const Eigen::Vector3d kCentre(0.02, 0.1, 0.05);

// The arm with a box of 1 x 2 x 3 decimetres on a frame.
Model loaded(const Model& arm, const std::string& on, double mass) {
  ModelDescription d = arm.description();
  Frame box;
  box.name = "box";
  box.parent = arm.find_frame(on);
  box.body = Body{};
  Eigen::Matrix<double, 6, 1> inertia;
  inertia << 0.13, 0.0, 0.1, 0.0, 0.0, 0.05;
  box.body->phi = inertial_parameters(mass, kCentre, mass / 12.0 * inertia);
  d.frames.push_back(box);
  return Model(d);
}

class KnownMasses : public testing::Test {
 protected:
  // elbow-6r has vertical and level axes and a wrist.
  const Model arm_ = read_model("elbow-6r");
  const VectorXd gains_ = [] {
    VectorXd k(6);
    k << 12.0, 11.0, 9.0, 3.0, 2.5, 1.2;
    return k;
  }();
  const std::string frame_ = arm_.frames().back().name;

  ~KnownMasses() override {
    for (const std::string& path : written_) std::filesystem::remove(path);
  }

  std::string record(const Model& arm, unsigned seed, double noise) {
    MotionShape shape;
    shape.duration = 30.0;
    shape.rate = 100.0;
    shape.seed = seed;
    Recording r = synthetic_recording(arm, shape);
    r.current = r.tau + noise_like(r.tau, noise, seed + 50);
    for (Eigen::Index j = 0; j < r.current.cols(); ++j) r.current.col(j) /= gains_[j];
    r.tau.resize(0, 0);
    const std::string path = testing::TempDir() + "drive_gains_test_" + std::to_string(::getpid()) +
                             "_" + std::to_string(written_.size()) + ".csv";
    write_recording(r, path);
    written_.push_back(path);
    return path;
  }

  std::string free_arm(unsigned seed, double noise = 0.02) { return record(arm_, seed, noise); }
  std::string with_load(unsigned seed, double mass = 2.0, double noise = 0.02) {
    return record(loaded(arm_, frame_, mass), seed, noise);
  }

  DriveGains find(const std::vector<std::string>& recordings,
                  const std::vector<KnownMass>& loads) const {
    return find_drive_gains(arm_, recordings, loads, {});
  }

  void expect_gains(const DriveGains& found, double tolerance) const {
    EXPECT_EQ(found.problem, "");
    ASSERT_EQ(found.joints.size(), 6U);
    for (size_t j = 0; j < 6; ++j) {
      const DriveGain& g = found.joints[j];
      const double k = gains_[static_cast<Eigen::Index>(j)];
      EXPECT_TRUE(g.identifiable) << g.coordinate << ": " << g.reason;
      EXPECT_NEAR(g.value, k, tolerance * k) << g.coordinate;
      // Twice the 95 % interval: six joints at once.
      EXPECT_GT(k, g.value - 2.0 * (g.value - g.low)) << g.coordinate;
      EXPECT_LT(k, g.value + 2.0 * (g.high - g.value)) << g.coordinate;
    }
  }

 private:
  std::vector<std::string> written_;
};

TEST_F(KnownMasses, RecoverTheGainsOfEveryJoint) {
  const std::string load = with_load(3, 2.0, 0.0);
  const DriveGains found =
      find({free_arm(1, 0.0), free_arm(2, 0.0), load}, {{2.0, frame_, {load}}});
  for (size_t j = 0; j < 6; ++j)
    EXPECT_NEAR(found.joints[j].value / gains_[static_cast<Eigen::Index>(j)], 1.0, 1e-4);
  ASSERT_TRUE(found.loads[0].centre.has_value());
  EXPECT_TRUE(near(*found.loads[0].centre, kCentre, 1e-4));
}

TEST_F(KnownMasses, RecoverGainsWithinOnePercentUnderNoise) {
  const std::string load = with_load(3);
  const DriveGains found = find({free_arm(1), free_arm(2), load}, {{2.0, frame_, {load}}});
  expect_gains(found, 0.01);
  EXPECT_EQ(found.unloaded.size(), 2U);
  EXPECT_EQ(found.loads[0].known.recordings, std::vector<std::string>{load});
  EXPECT_FALSE(found.loads[0].identified);
}

// Friction and offsets of another day, or of warmer gears, do not pass for a load.
TEST_F(KnownMasses, AreSeparatedFromFrictionDrift) {
  ModelDescription warm = loaded(arm_, frame_, 2.0).description();
  for (EffectTerm& term : warm.effects) {
    if (term.effect == "rotor_inertia") continue;
    for (auto& [key, value] : term.values) value *= 1.3;
  }
  const std::string load = record(Model(warm), 3, 0.02);
  expect_gains(find({free_arm(1), free_arm(2), load}, {{2.0, frame_, {load}}}), 0.01);
}

// Not said which recording carries it, and it is not the last one.
TEST_F(KnownMasses, AreAssignedToTheRecordingsThatCarryThem) {
  const std::string load = with_load(3);
  const std::string first = free_arm(1);
  const std::string second = free_arm(2);
  for (const std::vector<std::string>& order :
       {std::vector<std::string>{load, first}, {first, load}, {first, load, second}}) {
    const DriveGains found = find(order, {{2.0, frame_, {}}});
    expect_gains(found, 0.02);
    EXPECT_TRUE(found.loads[0].identified);
    EXPECT_EQ(found.loads[0].known.recordings, std::vector<std::string>{load});
    EXPECT_EQ(found.unloaded.size(), order.size() - 1);
  }
}

TEST_F(KnownMasses, TwoMassesInTwoRecordingsGiveTheGains) {
  const std::string light = with_load(3, 1.0);
  const std::string heavy = with_load(4, 3.0);
  const std::string light_name = std::filesystem::path(light).filename().string();
  const DriveGains found =
      find({free_arm(1), light, heavy}, {{1.0, frame_, {light_name}}, {3.0, frame_, {heavy}}});
  expect_gains(found, 0.01);
  ASSERT_EQ(found.loads.size(), 2U);
  EXPECT_EQ(found.loads[0].known.recordings, std::vector<std::string>{light});
  EXPECT_TRUE(near(*found.loads[1].centre, kCentre, 5e-3));
}

// A load on the first link, whose axis is vertical, weighs on no joint; one on the flange does.
TEST_F(KnownMasses, AGainNeedsOnlyOneMassThatWeighsOnItsJoint) {
  const std::string column = arm_.frames().front().name;
  constexpr double kNoise = 50.0;  // no gain is identifiable
  const std::string first = record(loaded(arm_, column, 1.0), 3, kNoise);
  const std::string last = with_load(4, 2.0, kNoise);
  const DriveGains found = find({free_arm(1, kNoise), first, last}, {{1.0, column, {first}}, {2.0, frame_, {last}}});
  ASSERT_EQ(found.joints.size(), 6U);
  for (const DriveGain& g : found.joints) EXPECT_FALSE(g.identifiable);
  EXPECT_NE(found.joints[0].reason.find("its axis feels no weight"), std::string::npos) << found.joints[0].reason;
  for (const int j : {1, 2}) EXPECT_NE(found.joints[j].reason.find("too little tells it apart"), std::string::npos) << found.joints[j].reason;
}

// Gains scale with the mass that is claimed.
TEST_F(KnownMasses, GainsAreProportionalToTheStatedMass) {
  const std::string load = with_load(3);
  const std::string without = free_arm(1);
  const DriveGains right = find({without, load}, {{2.0, frame_, {load}}});
  const DriveGains doubled = find({without, load}, {{4.0, frame_, {load}}});
  for (size_t j = 0; j < 6; ++j)
    EXPECT_NEAR(doubled.joints[j].value, 2.0 * right.joints[j].value, 1e-6 * right.joints[j].value);
}

TEST_F(KnownMasses, InNoRecordingAreReportedAsMissing) {
  const DriveGains none = find({free_arm(1), free_arm(2)}, {{2.0, frame_, {}}});
  EXPECT_NE(none.problem.find("do not show the known mass"), std::string::npos) << none.problem;
}

TEST_F(KnownMasses, AssignedToTheWrongRecordingAreReported) {
  const std::string load = with_load(3);
  const std::string without = free_arm(1);
  const DriveGains swapped = find({without, load}, {{2.0, frame_, {without}}});
  EXPECT_NE(swapped.problem.find("in the other recordings"), std::string::npos) << swapped.problem;
}

TEST_F(KnownMasses, ReportJointsWhoseGainIsUndetermined) {
  ModelDescription d = arm_.description();
  d.frames.back().body.reset();  // the last joint turns nothing but its own rotor and friction
  const Model bare(d);
  const std::string frame = d.frames[static_cast<size_t>(d.frames.size()) - 2].name;
  const std::string load = record(loaded(bare, frame, 2.0), 3, 0.02);
  const DriveGains found =
      find_drive_gains(bare, {record(bare, 1, 0.02), load}, {{2.0, frame, {load}}}, {});
  EXPECT_EQ(found.problem, "");
  for (size_t j = 0; j < 5; ++j) EXPECT_TRUE(found.joints[j].identifiable) << j;
  EXPECT_FALSE(found.joints[5].identifiable);
  EXPECT_NE(found.joints[5].reason.find("nothing ties its currents"), std::string::npos)
      << found.joints[5].reason;
  EXPECT_NE(found.report().find("not identifiable: nothing ties"), std::string::npos);
  // Such an arm cannot be identified, unless its file has the gain.
  IdentificationOptions options;
  options.known_masses = {{2.0, frame, {load}}};
  const std::string without = record(bare, 1, 0.02);
  EXPECT_EQ(identify(bare, {without, load}, {}, options).status,
            IdentificationStatus::kNoDriveGains);
  d.coordinates[5].drive_gain = gains_[5];
  const Identification id = identify(Model(d), {without, load}, {}, options);
  ASSERT_TRUE(id.model.has_value()) << id.reason;
  EXPECT_EQ(id.model->coordinates()[5].drive_gain, gains_[5]);
  EXPECT_EQ(id.model->coordinates()[5].drive_gain_deviation, 0.0);
}

// The gains are in the model, and the model is that of the arm without its load.
TEST_F(KnownMasses, GiveAModelInNewtonMetres) {
  const std::string load = with_load(3);
  IdentificationOptions options;
  options.method = Method::kWls;
  options.known_masses = {{2.0, frame_, {load}}};
  const Identification id = identify(arm_, {free_arm(1), free_arm(2), load}, {}, options);
  ASSERT_TRUE(id.model.has_value()) << id.reason;
  ASSERT_TRUE(id.drive_gains.has_value());
  EXPECT_EQ(id.train.size(), 2U);
  for (size_t j = 0; j < 6; ++j) {
    const Coordinate& c = id.model->coordinates()[j];
    EXPECT_EQ(c.drive_gain, id.drive_gains->joints[j].value);
    EXPECT_EQ(c.drive_gain_deviation, id.drive_gains->joints[j].deviation);
  }
  const Model read = read_yaml(to_yaml(*id.model), "model.yaml");
  EXPECT_EQ(read.coordinates()[2].drive_gain, id.drive_gains->joints[2].value);
  EXPECT_EQ(read.coordinates()[2].drive_gain_deviation, id.drive_gains->joints[2].deviation);
  const MatrixXd Y = random_regressor(arm_, 60, 3);
  const VectorXd truth = Y * true_parameters(arm_);
  EXPECT_LT((Y * id.parameters - truth).norm(), 0.02 * truth.norm());
}

TEST_F(KnownMasses, OfInconsistentRequestsAreRefused) {
  const std::string load = with_load(3);
  const std::string without = free_arm(1);
  const auto error = [&](const std::vector<std::string>& recordings,
                         const std::vector<KnownMass>& loads) -> std::string {
    try {
      find(recordings, loads);
    } catch (const InvalidInput& e) {
      return e.what();
    }
    return "no error";
  };
  EXPECT_NE(error({without, load}, {}).find("found none"), std::string::npos);
  EXPECT_NE(error({}, {{2.0, frame_, {}}}).find("found no recording"), std::string::npos);
  EXPECT_NE(error({without}, {{2.0, frame_, {}}}).find("one recording"), std::string::npos);
  EXPECT_NE(error({without, load}, {{2.0, "nowhere", {}}}).find("'nowhere'"), std::string::npos);
  EXPECT_NE(error({without, load}, {{-2.0, frame_, {}}}).find("mass above 0"), std::string::npos);
  EXPECT_NE(error({without, load}, {{2.0, frame_, {"x.csv"}}}).find("'x.csv'"), std::string::npos);
  EXPECT_NE(error({without, load}, {{2.0, frame_, {without, load}}}).find("every recording"),
            std::string::npos);
  EXPECT_NE(error({without, load}, {{2.0, frame_, {load}}, {1.0, frame_, {load}}})
                .find("two known masses"),
            std::string::npos);
  EXPECT_NE(error({without, load}, {{2.0, frame_, {}}, {1.0, frame_, {load}}}).find("several"),
            std::string::npos);
}

TEST(AKnownMass, IsReadFromItsText) {
  const KnownMass plain = parse_known_mass("2.805@flange");
  EXPECT_EQ(plain.mass, 2.805);
  EXPECT_EQ(plain.frame, "flange");
  EXPECT_TRUE(plain.recordings.empty());
  const KnownMass named = parse_known_mass("1e-1@tool=a.csv,b/c.csv");
  EXPECT_EQ(named.mass, 0.1);
  EXPECT_EQ(named.frame, "tool");
  EXPECT_EQ(named.recordings, (std::vector<std::string>{"a.csv", "b/c.csv"}));
  for (const char* bad :
       {"", "2", "@flange", "2@", "x@flange", "2kg@flange", "-1@flange", "0@flange",
        "2@flange=", "2@flange=a,,b", "2@=a", "nan@flange", "inf@flange"}) {
    EXPECT_THROW(parse_known_mass(bad), InvalidInput) << bad;
  }
}

}  // namespace
}  // namespace veridyn
