#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <sstream>

#include "cli/tool.hpp"
#include "veridyn/identification/base_parameters.hpp"
#include "veridyn/regressor/standard_parameters.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/recordings/recording.hpp"

// On a recording of planar-2r without noise the truth is known, and stands in the robot file.

namespace veridyn {
namespace {

using nlohmann::json;

class Identify : public testing::Test {
 protected:
  Identify() : train_(folder_.write("train.csv", planar_recording(20.0))) {
    test_ = folder_.write("test.csv", planar_recording(10.0, 0.8, 1.2));
  }

  ToolRun run(const Words& more) const {
    return run_tool(Words{"identify", "planar-2r", "--train", train_, "--test", test_, "--json",
                          folder_.path("out.json")} +
                    more);
  }

  json result(const Words& more) const {
    const ToolRun done = run(more);
    EXPECT_EQ(done.status, 0) << done.err;
    return json_of(folder_.path("out.json"));
  }

  TemporaryFolder folder_;
  std::string train_, test_;
};

TEST_F(Identify, JsonHasEveryDocumentedKey) {
  const json out = result({"--method", "feasible"});
  EXPECT_TRUE(out["veridyn"].is_string());
  EXPECT_EQ(out["command"], "identify");
  EXPECT_EQ(out["robot"], "planar-2r");
  EXPECT_EQ(out["method"], "feasible");
  for (const char* key : {"rows", "condition_number", "condition_number_unscaled", "objective",
                          "duality_gap", "effective_samples"}) {
    EXPECT_TRUE(out[key].is_number()) << key << ": " << out[key];
  }
  EXPECT_TRUE(out["rank_gap"].is_number() || out["rank_gap"].is_null());
  EXPECT_TRUE(out["feasible"].is_boolean());
  EXPECT_TRUE(out["active_constraints"].is_array());
  for (const json& b : out["base_parameters"]) {
    for (const char* key : {"name", "expression", "unit"}) EXPECT_TRUE(b[key].is_string()) << b;
    EXPECT_TRUE(b["value"].is_number()) << b;
    EXPECT_TRUE(b.contains("std")) << b;
  }
  for (const char* set : {"train", "test"}) {
    EXPECT_EQ(out[set]["relative_error"].size(), 2u);
    EXPECT_EQ(out[set]["max_error"].size(), 2u);
    EXPECT_EQ(out[set]["moving"]["relative_error"].size(), 2u);
    ASSERT_EQ(out[set]["recordings"].size(), 1u);
    for (const char* key : {"source", "relative_error", "max_error", "noise_floor"}) {
      EXPECT_TRUE(out[set]["recordings"][0].contains(key)) << key;
    }
  }
  EXPECT_EQ(out["test"]["recordings"][0]["source"], test_);
  EXPECT_TRUE(out["noise_floor"]["source"] == "none" || out["noise_floor"]["source"] == "repeats");
  for (const char* key : {"read", "compress", "solve"})
    EXPECT_TRUE(out["seconds"][key].is_number());
}

TEST_F(Identify, WithoutATestRecordingThereIsNoTestError) {
  const ToolRun done = run_tool(
      {"identify", "planar-2r", "--train", train_, "--json", folder_.path("out.json"), "--quiet"});
  EXPECT_EQ(done.status, 0);
  EXPECT_EQ(done.err, "");
  EXPECT_TRUE(json_of(folder_.path("out.json"))["test"].is_null());
}

// The low-pass at 20 Hz leaves of friction's steps what it leaves in the torque; the rest is
// differentiation of 100 Hz samples: (2 pi f / rate)^2 / 6 of the fastest sine, about 0.4 %.
TEST_F(Identify, EveryMethodRecoversTheSimulatedParameters) {
  const Model arm = read_model("planar-2r");
  const std::vector<StandardParameter> parameters = standard_parameters(arm);
  VectorXd truth(parameters.size());
  for (std::size_t j = 0; j < parameters.size(); ++j) {
    truth[static_cast<Eigen::Index>(j)] = parameters[j].value;
  }
  const VectorXd beta = base_parameters(arm).K * truth;
  for (const char* method : {"ols", "wls", "feasible"}) {
    const json out = result({"--method", method, "--filter-cutoff", "10", "--quiet"});
    ASSERT_EQ(out["base_parameters"].size(), static_cast<std::size_t>(beta.size()));
    for (Eigen::Index j = 0; j < beta.size(); ++j) {
      const json& b = out["base_parameters"][j];
      EXPECT_NEAR(b["value"].get<double>(), beta[j], 0.01 * beta.cwiseAbs().maxCoeff())
          << method << " " << b["expression"];
    }
    for (const json& e : out["test"]["relative_error"]) EXPECT_LT(e.get<double>(), 0.01) << method;
  }
}

TEST_F(Identify, EveryNumberOfTheTextIsInTheJson) {
  const ToolRun brief = run({});
  EXPECT_LE(std::count(brief.out.begin(), brief.out.end(), '\n'), 10) << brief.out;
  EXPECT_EQ(brief.out.find("base parameter\n"), std::string::npos) << brief.out;
  const ToolRun done = run({"--parameters"});
  const json out = json_of(folder_.path("out.json"));
  for (const json& b : out["base_parameters"]) {
    char value[32];
    std::snprintf(value, sizeof value, "%.6g", b["value"].get<double>());
    EXPECT_NE(done.out.find(value), std::string::npos) << value;
    EXPECT_NE(done.out.find(b["expression"].get<std::string>()), std::string::npos) << b;
  }
  for (const char* set : {"train", "test"}) {
    std::string line;
    for (const json& e : out[set]["relative_error"]) {
      char value[32];
      std::snprintf(value, sizeof value, "%8.2f", 100.0 * e.get<double>());
      line += value;
    }
    EXPECT_NE(done.out.find(line), std::string::npos) << line << "\n" << done.out;
  }
}

TEST_F(Identify, ProgressGoesToStandardErrorAndOnlyThere) {
  const ToolRun loud = run({});
  const ToolRun quiet = run({"--quiet"});
  EXPECT_NE(loud.err.find("veridyn: "), std::string::npos);
  EXPECT_EQ(loud.err.find('\r'), std::string::npos);
  EXPECT_EQ(quiet.err, "");
  EXPECT_EQ(loud.out, quiet.out);
}

TEST_F(Identify, TheModelIsARobotWithTheIdentifiedValues) {
  const std::string path = folder_.path("model.yaml");
  const json out = result({"--model-out", path});
  const Model model = read_model(path);
  const std::vector<StandardParameter> parameters = standard_parameters(model);
  ASSERT_EQ(out["standard_parameters"].size(), parameters.size());
  for (std::size_t j = 0; j < parameters.size(); ++j) {
    const double value = out["standard_parameters"][j]["value"];
    EXPECT_NEAR(parameters[j].value, value, 1e-9 * (1.0 + std::abs(value))) << parameters[j].name;
  }
  EXPECT_EQ(run_tool({"info", path}).status, 0);
}

TEST_F(Identify, TheFeasibleObjectiveIsNotBelowTheUnconstrainedOne) {
  const json free = result({"--method", "wls"});
  const json feasible = result({"--method", "feasible"});
  EXPECT_TRUE(feasible["feasible"].get<bool>());
  const double objective = free["objective"];
  EXPECT_GE(feasible["objective"].get<double>(), objective * (1.0 - 1e-9));
}

TEST_F(Identify, SettingsListTheOptionsOfTheRun) {
  const json s = result({"--method",        "wls",     "--weights",      "residual",
                         "--filter-cutoff", "7.5",     "--filter-order", "3",
                         "--filtering",     "signals", "--velocity",     "derived",
                         "--resample",      "90",      "--drop-start",   "1.5",
                         "--drop-end",      "0.25",    "--rows",         "100:1800",
                         "--test-rows",     "50:",     "--decimation",   "2"})["settings"];
  EXPECT_EQ(s["method"], "wls");
  EXPECT_EQ(s["weights"], "residual");
  EXPECT_EQ(s["filter_cutoff"], 7.5);
  EXPECT_EQ(s["filter_order"], 3);
  EXPECT_EQ(s["filtering"], "signals");
  EXPECT_EQ(s["velocity"], "derived");
  EXPECT_EQ(s["velocity_derived_of"], json::array());
  EXPECT_EQ(s["resample"], 90.0);
  EXPECT_EQ(s["drop_start"], 1.5);
  EXPECT_EQ(s["drop_end"], 0.25);
  EXPECT_EQ(s["decimation"], 2);
  EXPECT_EQ(s["rows"], json::array({100, 1800}));
  EXPECT_EQ(s["test_rows"], json::array({50, nullptr}));
  EXPECT_EQ(s["train"], json::array({train_}));
  EXPECT_EQ(s["test"], json::array({test_}));
}

TEST_F(Identify, TestRowsDefaultToTheRowsOfTraining) {
  const json s = result({"--rows", "100:1800"})["settings"];
  EXPECT_EQ(s["test_rows"], json::array({100, 1800}));
}

TEST_F(Identify, AHeaderlessFileGivesTheSameNumbers) {
  std::string bare;
  std::istringstream lines(content_of(train_));
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) bare += line.substr(line.find(',') + 1) + "\n";
  const std::string path = folder_.write("bare.csv", bare);
  const std::string json_path = folder_.path("bare.json");
  const ToolRun done = run_tool({"identify", "planar-2r", "--train", path, "--columns", "q,dq,tau",
                                 "--rate", "100", "--json", json_path});
  ASSERT_EQ(done.status, 0) << done.err;
  const json a = json_of(json_path)["base_parameters"];
  const json b = result({})["base_parameters"];
  for (std::size_t j = 0; j < a.size(); ++j) {
    EXPECT_NEAR(a[j]["value"].get<double>(), b[j]["value"].get<double>(), 1e-6) << a[j];
  }
}

TEST_F(Identify, TheNumberOfThreadsDoesNotChangeTheParameters) {
  const json one = result({"--threads", "1"});
  const json two = result({"--threads", "2"});
  EXPECT_EQ(one["base_parameters"], two["base_parameters"]);
  const ToolRun done = run_tool({"identify", "planar-2r", "--train", train_, test_, "--test", test_,
                                 train_, "--json", folder_.path("both.json"), "--threads", "2"});
  ASSERT_EQ(done.status, 0) << done.err;
  const json both = json_of(folder_.path("both.json"));
  EXPECT_EQ(both["train"]["recordings"].size(), 2u);
  EXPECT_EQ(both["test"]["recordings"][1]["source"], train_);
  EXPECT_GT(both["rows"].get<double>(), one["rows"].get<double>());
}

TEST_F(Identify, APriorOfTheSameRobotIsAccepted) {
  const json out = result({"--prior", "planar-2r"});
  EXPECT_EQ(out["settings"]["prior"], "planar-2r");
}

// A held-out recording of which nothing is left has no error; 0 % would be a lie.
TEST_F(Identify, AnEmptyHeldOutRecordingIsRefused) {
  const ToolRun done = run({"--test-rows", "5000:6000", "--quiet"});
  EXPECT_EQ(done.status, 3);
  EXPECT_EQ(done.error_lines(), 1) << done.err;
  EXPECT_NE(done.err.find("test.csv: found no usable samples"), std::string::npos) << done.err;
  EXPECT_EQ(done.out, "");
}

// Units are looked at wherever a recording is learned from.
TEST_F(Identify, ARecordingInDegreesIsWarnedOf) {
  EXPECT_EQ(run({"--quiet"}).err, "");
  std::istringstream rad(content_of(train_));
  std::ostringstream deg;
  std::string line;
  std::getline(rad, line);
  deg << line << "\n";
  while (std::getline(rad, line)) {
    double t = 0.0, q1 = 0.0, q2 = 0.0, dq1 = 0.0, dq2 = 0.0, tau1 = 0.0, tau2 = 0.0;
    std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf,%lf", &t, &q1, &q2, &dq1, &dq2, &tau1,
                &tau2);
    const double k = 180.0 / M_PI;
    deg << t << "," << k * q1 << "," << k * q2 << "," << k * dq1 << "," << k * dq2 << "," << tau1
        << "," << tau2 << "\n";
  }
  const std::string train = folder_.write("degrees.csv", deg.str());
  const ToolRun done = run_tool({"identify", "planar-2r", "--train", train, "--quiet"});
  EXPECT_EQ(done.status, 0) << done.err;
  EXPECT_EQ(done.error_lines(), 1) << done.err;
  EXPECT_NE(done.err.find("warning: " + train + ": The position of joint 1"), std::string::npos)
      << done.err;
  EXPECT_NE(done.err.find("degrees or millimetres"), std::string::npos) << done.err;
}

// What is mended in a row is reported where a recording is learned from, too.
TEST_F(Identify, ASingleAbsurdTorqueIsReportedInOneLine) {
  std::string spoilt = content_of(train_);
  const size_t row = spoilt.find("\n4.00,") + 1;
  ASSERT_NE(row, 0U);
  const size_t torque = spoilt.rfind(',', spoilt.find('\n', row)) + 1;
  spoilt.replace(torque, spoilt.find('\n', row) - torque, "3e9");
  const std::string train = folder_.write("spoilt.csv", spoilt);
  for (const Words& command : {Words{"identify", "planar-2r", "--train"}, Words{"payload", "planar-2r", "--recording"}}) {
    const ToolRun done = run_tool(command + Words{train, "--quiet"});
    EXPECT_EQ(done.status, 0) << done.err;
    EXPECT_EQ(done.error_lines(), 1) << done.err;
    EXPECT_EQ(done.err.find("veridyn: " + train + ": tau2 (elbow) jumps out of its range in 1 row"), 0U) << done.err;
  }
}

// Zeros that nobody measured are no torques: the other joints tell the bodies, and nothing the friction of this one.
TEST_F(Identify, AJointWithoutTorqueIsLeftOut) {
  std::istringstream lines(content_of(train_));
  std::string line, silent;
  for (int k = 0; std::getline(lines, line); ++k) silent += (k == 0 ? line : line.substr(0, line.rfind(',')) + ",0") + "\n";
  const std::string train = folder_.write("silent.csv", silent);
  const ToolRun done = run_tool({"identify", "planar-2r", "--train", train, "--json", folder_.path("silent.json"), "--quiet"});
  const std::string told = done.out + done.err;
  EXPECT_NE(told.find("elbow is zero throughout"), std::string::npos) << told;
  if (done.status == 4) return;  // where one joint alone does not determine the arm
  ASSERT_EQ(done.status, 0) << told;
  for (const json& b : json_of(folder_.path("silent.json"))["base_parameters"])
    EXPECT_EQ(b["expression"].get<std::string>().find("friction(elbow)"), std::string::npos) << b;
}

// Hardly a row between gaps: whoever reads it in earnest says so, once.
TEST_F(Identify, ARecordingOfGapsIsRefusedInOneLine) {
  std::istringstream lines(content_of(train_));
  std::string line, sparse;
  for (int k = 0; std::getline(lines, line); ++k)
    sparse += (k == 0 || k % 400 < 12 ? line : line.substr(0, line.rfind(',')) + ",nan") + "\n";
  const std::string train = folder_.write("sparse.csv", sparse);
  const ToolRun done = run_tool({"identify", "planar-2r", "--train", train, "--quiet"});
  EXPECT_EQ(done.status, 4) << done.err;
  EXPECT_EQ(done.error_lines(), 1) << done.err;
  EXPECT_NE(done.err.find("no usable samples are left after gaps"), std::string::npos) << done.err;
}

// A piece of the training recording as test, with times and a name of its own, in identify and diagnose alike.
TEST_F(Identify, APieceOfATrainingRecordingAsTestIsWarnedOf) {
  Recording piece = rows_of(read_recording(train_), 500, 1400);
  const double begin = piece.time[0];
  piece.time.array() -= begin;
  write_recording(piece, folder_.path("piece.csv"));
  const std::string said = folder_.path("piece.csv") + ": its rows are rows of " + train_ + ", which is learned from: its error is not held out";
  for (const char* command : {"identify", "diagnose"}) {
    const ToolRun done = run_tool({command, "planar-2r", "--train", train_, "--test", folder_.path("piece.csv"), "--json", folder_.path("out.json"), "--quiet"});
    EXPECT_EQ(done.status, 0) << done.err;
    EXPECT_NE(done.out.find("warning: " + said), std::string::npos) << done.out;
    EXPECT_EQ(json_of(folder_.path("out.json"))["warnings"].size(), 1U);
  }
  EXPECT_EQ(run({}).out.find("warning"), std::string::npos);
  const ToolRun same = run_tool({"identify", "planar-2r", "--train", train_, "--test", train_, "--quiet"});
  EXPECT_NE(same.out.find("warning: " + train_ + ": it is learned from, too: its error is not held out"), std::string::npos) << same.out;
}

// Zero velocities of two joints in two recordings are four findings of one kind.
TEST(VelocitiesOfZero, OfSeveralJointsGiveOneWarning) {
  const TemporaryFolder folder;
  const std::string train = folder.path("train.csv"), test = folder.path("test.csv");
  for (const auto& [path, size] : {std::pair{train, 1.0}, std::pair{test, 0.8}}) {
    Recording r = read_recording(folder.write("motion.csv", planar_recording(15.0, size, size)));
    r.dq.setZero();
    write_recording(r, path);
  }
  const ToolRun run = run_tool({"identify", "planar-2r", "--train", train, "--test", test, "--quiet"});
  EXPECT_EQ(run.status, 0) << run.err;
  const std::size_t first = run.err.find("warning: ");
  ASSERT_NE(first, std::string::npos) << run.err;
  EXPECT_NE(run.err.find("is zero while its position moves: take it from the position. (And 3 more of this kind: `veridyn check` lists them.)"), std::string::npos) << run.err;
  EXPECT_EQ(run.err.find("warning: ", first + 1), std::string::npos) << run.err;
}

}  // namespace
}  // namespace veridyn
