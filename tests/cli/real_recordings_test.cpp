#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>

#include "cli/tool.hpp"
#include "veridyn/files/model_file.hpp"

// Recordings of real arms, measured by others. Targets are held-out errors in percent: published
// ones where the comment says so.

namespace veridyn {
namespace {

using nlohmann::json;

constexpr double kMargin = 0.5;  // percentage points

std::string data_folder() {
  if (const char* named = std::getenv("VERIDYN_REAL_DATA")) return named;
  return std::string(VERIDYN_SOURCE_DIR) + "/../shared/data";
}

class RealRecordings : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::is_directory(data_folder())) {
      GTEST_SKIP() << "no real recordings: " << data_folder()
                   << " is not there, and VERIDYN_REAL_DATA names no folder";
    }
  }

  static std::string file(const std::string& name) { return data_folder() + "/" + name; }

  json identify(const std::string& robot, const Words& arguments) const {
    return result({"identify", robot}, arguments);
  }

  json diagnose(const std::string& robot, const Words& arguments) const {
    return result({"diagnose", robot}, arguments);
  }

  json result(const Words& command, const Words& arguments) const {
    const std::string out = folder_.path("out.json");
    const ToolRun run = run_tool(command + arguments + Words{"--json", out, "--quiet"});
    EXPECT_EQ(run.status, 0) << run.err;
    return run.status == 0 ? json_of(out) : json();
  }

  static std::vector<double> percent(const json& errors) {
    std::vector<double> out;
    for (const json& e : errors) out.push_back(100.0 * e.get<double>());
    return out;
  }

  TemporaryFolder folder_;
};

void expect_near(const std::vector<double>& found, const std::vector<double>& target) {
  ASSERT_EQ(found.size(), target.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_NEAR(found[i], target[i], kMargin) << "joint " << i + 1;
  }
}

void expect_no_worse(const std::vector<double>& found, const std::vector<double>& target) {
  ASSERT_EQ(found.size(), target.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_LE(found[i], target[i] + kMargin) << "joint " << i + 1;
  }
}

void expect_about(const std::vector<double>& found, const std::vector<double>& target) {
  ASSERT_EQ(found.size(), target.size());
  for (std::size_t i = 0; i < found.size(); ++i)
    EXPECT_NEAR(found[i], target[i], 2.5) << "joint " << i + 1;
}

// Settings of the published code for psm-wrist.
Words published_wrist_settings() {
  return {"--filtering",  "signals", "--filter-cutoff", "16.96", "--filter-order", "6",
          "--drop-start", "1",       "--drop-end",      "1",     "--test-rows",    "200:1311"};
}

// Published: WPI-AIM/dvrk_dynamics_identification, weighted least squares.
TEST_F(RealRecordings, WristByWeightedLeastSquaresIsAsPublished) {
  const json out = identify("psm-wrist", Words{"--train", file("psm-wrist/one.csv"), "--test",
                                               file("psm-wrist/two.csv"), "--method", "wls"} +
                                             published_wrist_settings());
  ASSERT_FALSE(out.is_null());
  EXPECT_EQ(out["base_parameters"].size(), 49u);
  expect_near(percent(out["test"]["relative_error"]), {10.3, 18.2, 19.8, 13.4, 23.9, 21.1, 26.6});
}

// Published: the same, feasible, of a solve that had not converged. Its rotor inertias carried no
// sign: compared alike.
TEST_F(RealRecordings, WristFeasibleIsNoWorseThanPublished) {
  const json out = identify(
      "psm-wrist", Words{"--train", file("psm-wrist/one.csv"), "--test", file("psm-wrist/two.csv"),
                         "--method", "feasible", "--weights", "residual", "--signs", "any"} +
                       published_wrist_settings());
  ASSERT_FALSE(out.is_null());
  EXPECT_TRUE(out["feasible"].get<bool>());
  EXPECT_TRUE(out["certified"].get<bool>());
  expect_no_worse(percent(out["test"]["relative_error"]),
                  {9.3, 17.8, 19.1, 13.4, 23.9, 21.3, 26.4});
}

// With rotor inertias that are not negative joints 5 to 7 fit worse: the recordings ask for
// negative ones, which stand for something else (a torque that lags). Measured with this
// tool: 25.3, 23.8, 29.4 %.
TEST_F(RealRecordings, WristErrorsWithNonNegativeRotorInertiasStayBelowTheirBounds) {
  const json out = identify("psm-wrist", Words{"--train", file("psm-wrist/one.csv"), "--test",
                                               file("psm-wrist/two.csv"), "--method", "feasible"} +
                                             published_wrist_settings());
  ASSERT_FALSE(out.is_null());
  EXPECT_TRUE(out["feasible"].get<bool>());
  expect_no_worse(percent(out["test"]["relative_error"]), {10, 17.8, 19.5, 13.4, 25.3, 23.8, 29.4});
}

json identify_thesis_arm(const std::function<json(const Words&)>& identify) {
  Words words = {"--train"};
  const std::string folder = data_folder() + "/psm1-thesis/fourier-";
  for (const char* k : {"1", "2", "3", "4"}) words.push_back(folder + k + ".csv");
  words.push_back("--test");
  for (const char* k : {"5", "6"}) words.push_back(folder + k + ".csv");
  return identify(words + Words{"--filter-cutoff", "3.5", "--filter-order", "8"});
}

TEST_F(RealRecordings, TheThesisArmKeepsItsRecordedErrors) {
  const json out =
      identify_thesis_arm([this](const Words& words) { return identify("psm-3dof", words); });
  ASSERT_FALSE(out.is_null());
  EXPECT_EQ(out["base_parameters"].size(), 25u);
  const json& tests = out["test"]["recordings"];
  expect_no_worse(percent(tests[0]["repaired"]["relative_error"]), {5.1, 12.7, 20.1});
  expect_no_worse(percent(tests[1]["repaired"]["relative_error"]), {7.0, 21.6, 26.4});
}

// Recordings 5 and 6 come late: 12 % of the rows repeat the one before, and are filled in. Even
// what no model can explain, the difference between repeats of the motion, is smaller then.
TEST_F(RealRecordings, FillingLateRowsReducesTheRepeatErrorOfTheInsertion) {
  const auto floors = [](const json& out) { return percent(out["noise_floor"]["relative_error"]); };
  for (const char* k : {"5", "6"}) {
    const Words words = {"--train", file("psm1-thesis/fourier-") + k + ".csv", "--filter-cutoff",
                         "3.5"};
    const json filled = identify("psm-3dof", words);
    const json kept = identify("psm-3dof", words + Words{"--stale-rows", "kept"});
    ASSERT_FALSE(filled.is_null() || kept.is_null());
    EXPECT_LT(floors(filled)[2], 0.9 * floors(kept)[2]);
    for (int joint : {0, 1}) EXPECT_LT(floors(filled)[joint], 1.05 * floors(kept)[joint]);
    const json& recording = filled["train"]["recordings"][0];
    ASSERT_TRUE(recording.contains("filled_rows"));
    EXPECT_NEAR(recording["filled_rows"]["share"].get<double>(), 0.13, 0.01);
  }
  const json out =
      identify_thesis_arm([this](const Words& words) { return identify("psm-3dof", words); });
  ASSERT_FALSE(out.is_null());
  for (const json& recording : out["test"]["recordings"]) {
    ASSERT_TRUE(recording.contains("repaired"));
    const std::vector<double> filled = percent(recording["repaired"]["relative_error"]);
    const std::vector<double> kept = percent(recording["relative_error"]);
    for (std::size_t joint = 0; joint < 3; ++joint) EXPECT_LT(filled[joint], kept[joint] + 0.1);
    EXPECT_LT(filled[2], kept[2] - 0.4);
  }
}

// With the constants as the thesis prints them, the errors are what the printed table gives; it was
// made from the rows as recorded.
TEST_F(RealRecordings, ThePrintedTableHasItsPublishedError) {
  const json out = identify_thesis_arm([this](const Words& words) {
    return identify("psm-3dof-printed", words + Words{"--method", "wls", "--filtering", "signals",
                                                      "--stale-rows", "kept"});
  });
  ASSERT_FALSE(out.is_null());
  EXPECT_EQ(out["base_parameters"].size(), 28u);
  const json& tests = out["test"]["recordings"];
  expect_about(percent(tests[0]["relative_error"]), {13.0, 14.6, 28.5});
  expect_about(percent(tests[1]["relative_error"]), {13.8, 22.9, 43.9});
}

// Targets that were set for the extended model, from one recording.
TEST_F(RealRecordings, DiagnosisOfTheWristPredictsAnotherMotion) {
  const json out = diagnose("psm-wrist", {"--train", file("psm-wrist/one.csv"), "--test",
                                          file("psm-wrist/two.csv"), "--filter-cutoff", "5.4"});
  ASSERT_FALSE(out.is_null());
  expect_no_worse(percent(out["extended"]["test"]["relative_error"]),
                  {3.6, 12.2, 14.0, 9.9, 8.5, 9.6, 13.6});
}

// The MODEL lacks memories of friction, which delays of the wrist's torques imitate to first order; 205 g hang on the parallel link.
TEST_F(RealRecordings, ALoadOnTheWristIsFoundThoughTheModelHasNoHysteresis) {
  const std::string model = folder_.path("model.yaml");
  ASSERT_FALSE(identify("psm-wrist", {"--train", file("psm-wrist/two.csv"), "--filter-cutoff", "5.4", "--model-out",
                                      model}).is_null());
  const auto load_of = [&](const char* name) {
    const json out = diagnose(model, {"--train", file(name), "--test", file("psm-wrist/one-105g-parallel.csv"), "--filter-cutoff", "5.4"});
    // The extended model has moved with what was found; curves, which it does not hold, leave it a little worse.
    const std::vector<double> before = out["baseline"]["train"]["relative_error"], after = out["extended"]["train"]["relative_error"];
    for (std::size_t j = 0; j < after.size(); ++j) EXPECT_LT(after[j], 1.25 * before[j]) << "joint " << j + 1;
    double mass = 0.0;
    for (const json& f : out["findings"]) {
      EXPECT_NE(f["effect"], "time_delay") << f["sentence"];
      if (f["effect"] == "payload") mass = f["parameters"]["mass"]["value"];
    }
    return mass;
  };
  EXPECT_NEAR(load_of("psm-wrist/one-205g-parallel.csv"), 0.205, 0.06);
  EXPECT_EQ(load_of("psm-wrist/one-no-weight.csv"), 0.0);
}

TEST_F(RealRecordings, DiagnosisOfTheMasterArmPredictsAnotherMotion) {
  const json out = diagnose("mtm", {"--train", file("mtm/one.csv"), "--test", file("mtm/two.csv"),
                                    "--filter-cutoff", "5.65"});
  ASSERT_FALSE(out.is_null());
  expect_no_worse(percent(out["extended"]["test"]["relative_error"]),
                  {6.4, 12.7, 12.3, 13.2, 23, 18, 31.3});
}

TEST_F(RealRecordings, AnIndustrialArmIsIdentifiedFromMotorCurrents) {
  const json out =
      identify("ur10e", {"--train", file("ur10e/free-12harm30s-2020-02-10.csv"), "--rows",
                         "635:3510", "--test", file("ur10e/free-point-to-point-2020-01-17.csv"),
                         "--test-rows", "700:4200", "--filter-cutoff", "7", "--resample", "100"});
  ASSERT_FALSE(out.is_null());
  EXPECT_EQ(out["base_parameters"].size(), 58u);
  std::vector<double> all = percent(out["test"]["relative_error"]);
  all.resize(4);
  expect_no_worse(all, {11.5, 3.9, 4.5, 8.0});
  // Joints 5 and 6 rest for most of the file, where friction holds any torque; a model without
  // memory cannot know it.
  const std::vector<double> moving = percent(out["test"]["moving"]["relative_error"]);
  EXPECT_LE(moving[4], 8.8 + kMargin);
  EXPECT_LE(moving[5], 11.0 + kMargin);
}

// As recorded: numbers up to 1e305 in rows that are well formed.
TEST_F(RealRecordings, AFileWithNumbersUpTo1e305IsReported) {
  const ToolRun run = run_tool(
      {"check", file("ur10e/broken-file-2019-09-27.csv"), "--json", folder_.path("check.json")});
  ASSERT_EQ(run.status, 0) << run.err;
  bool absurd = false;
  const json out = json_of(folder_.path("check.json"));
  for (const json& finding : out["data_quality"]) {
    absurd = absurd || finding["finding"] == "absurd_numbers";
  }
  EXPECT_TRUE(absurd) << run.out;
}

// Section 5.6 of the thesis: constant speeds and ramps of the insertion alone.
TEST_F(RealRecordings, FrictionOfTheInsertionIsEstimatedWithTheOtherJointsAtRest) {
  const TemporaryFolder folder;
  const std::string path = folder.path("f.json");
  const auto part = [](const char* name) { return file(std::string("psm1-thesis/") + name + ".csv"); };
  const ToolRun done = run_tool({"friction", "psm-3dof", part("constant-velocity-positive"), part("constant-velocity-negative"),
                                 part("force-ramp"), "--json", path, "--quiet"});
  ASSERT_EQ(done.status, 0) << done.err;
  const json result = json_of(path);
  EXPECT_EQ(result["resting"], (json{"pitch", "yaw"}));
  ASSERT_EQ(result["joints"].size(), 1u);
  const json& joint = result["joints"][0];
  EXPECT_EQ(joint["joint"], 3);
  EXPECT_GE(joint["speeds"].size(), 20u);
  EXPECT_GE(joint["breakaways"].size(), 10u);
  EXPECT_LT(joint["held_out"]["confirmed"], 0.7 * joint["held_out"]["plain"].get<double>());
  std::map<std::string, std::string> states;
  for (const json& v : joint["verdicts"]) states[v["effect"]] = v["state"];
  EXPECT_EQ(states["presliding_hysteresis"], "confirmed") << done.out;
  EXPECT_EQ(states["position_dependent_friction"], "confirmed") << done.out;
  EXPECT_EQ(states["stribeck_friction"], "not_supported") << done.out;
}

// These real arms are mounted upright and their files are right: whatever error is left, gravity and DH convention are not blamed for it.
TEST_F(RealRecordings, OfUprightArmsAreNotReportedWithGravityOrDhErrors) {
  const std::vector<std::pair<std::string, std::string>> recordings = {
      {"psm-wrist", "psm-wrist/one.csv"}, {"psm-3dof", "psm1-thesis/fourier-1.csv"}, {"psm-3dof", "psm1-thesis/fourier-2.csv"}};
  for (const auto& [robot, name] : recordings) {
    const json found = result({"check", robot}, {file(name)});
    ASSERT_FALSE(found.is_null());
    for (const json& f : found["recordings"][0]["findings"]) {
      EXPECT_NE(f["finding"], "gravity") << f["sentence"];
      EXPECT_NE(f["finding"], "dh_convention") << f["sentence"];
    }
  }
}

// All joints of this arm follow two sines: exchanges of joints that are none explain its torques better.
TEST_F(RealRecordings, OfJointsThatMoveAsOneAreNotReportedAsExchanged) {
  const json found = result({"check", "kuka-lwr4"}, {file("lwr4/lwr-3.npz")});
  ASSERT_FALSE(found.is_null());
  for (const json& f : found["recordings"][0]["findings"]) {
    EXPECT_NE(f["severity"], "fault") << f["sentence"];
    EXPECT_NE(f["finding"], "torque_unit") << f["sentence"];
  }
}

// Torques leave single masses open: a prior of rods keeps them at a plausible size and the errors
// where they were.
TEST_F(RealRecordings, APriorOfRodsGivesPlausibleMasses) {
  const auto masses = [&](const Words& more, std::vector<double>& held_out) {
    const std::string model = folder_.path("model.yaml");
    const json out = identify("psm-3dof", Words{"--train", file("psm1-thesis/fourier-2.csv"),
                                                file("psm1-thesis/fourier-3.csv"), "--test",
                                                file("psm1-thesis/fourier-4.csv"), "--model-out",
                                                model} + more);
    held_out = percent(out["test"]["relative_error"]);
    const Model arm = read_model(model);
    std::vector<double> all;
    for (const Frame& frame : arm.frames())
      if (frame.body) all.push_back((*frame.body->phi)[0]);
    return all;
  };
  std::vector<double> free_errors;
  std::vector<double> errors;
  const std::vector<double> unbounded = masses({}, free_errors);
  const std::vector<double> plausible = masses({"--prior", "psm-3dof-rods"}, errors);
  ASSERT_EQ(plausible.size(), 6U);
  EXPECT_GT(unbounded[0], 5.0);  // [kg] yaw
  EXPECT_LT(plausible[0], 3.0);
  for (size_t j = 0; j < errors.size(); ++j) EXPECT_NEAR(errors[j], free_errors[j], 1.0);
}

}  // namespace
}  // namespace veridyn
