#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "cli/tool.hpp"
#include "veridyn/files/model_file.hpp"

// Drive gains of arms that report currents.

namespace veridyn {
namespace {

using nlohmann::json;

class KnownMass : public testing::Test {
 protected:
  static void run(const Words& words) {
    const ToolRun done = run_tool(words);
    ASSERT_EQ(done.status, 0) << done.err;
  }

  // A simulated UR10e that reports currents instead of torques.
  std::string recording(int motion, const std::string& hidden) const {
    const std::string m = std::to_string(motion);
    const std::string trajectory = folder_.path("motion" + m + ".csv");
    const std::string torques = folder_.path("torques.csv");
    run({"excite", "ur10e", "-o", trajectory, "--frequency", "0.1" + m, "--seed", m,
         "--evaluations", "40", "--quiet"});
    run({"simulate", "ur10e", "--trajectory", trajectory, "-o", torques, "--noise", "low", "--seed",
         m, "--effect", hidden, "--quiet"});
    std::istringstream lines(content_of(torques));
    std::string out, line;
    for (bool header = true; std::getline(lines, line); header = false)
      out += (header ? "t,q1,q2,q3,q4,q5,q6,dq1,dq2,dq3,dq4,dq5,dq6,i1,i2,i3,i4,i5,i6"
                     : in_amperes(line)) +
             "\n";
    return folder_.write("recording" + m + ".csv", out);
  }

  // The last six fields divided by the gains.
  static std::string in_amperes(const std::string& line) {
    std::istringstream fields(line);
    std::string out, field;
    for (int at = 0; std::getline(fields, field, ','); ++at) {
      if (at > 0) out += ",";
      if (at < 13 || field.empty()) {
        out += field;
        continue;
      }
      char text[32];
      std::snprintf(text, sizeof text, "%.10g", std::stod(field) / kGains[at - 13]);
      out += text;
    }
    return out;
  }

  static constexpr double kGains[6] = {14.0, 13.0, 9.0, 7.0, 6.5, 6.0};
  TemporaryFolder folder_;
};

TEST_F(KnownMass, GivesTheGainsInTextJsonAndModel) {
  const std::string load = recording(1, "payload:flange:mass=2.5,x=0.02,y=0.08,z=0.04");
  const std::string a = recording(2, "none");
  const std::string b = recording(3, "none");
  const std::string model = folder_.path("model.yaml");
  const ToolRun done =
      run_tool({"identify", "ur10e", "--train", a, load, b, "--known-mass", "2.5@flange", "--json",
                folder_.path("out.json"), "--model-out", model, "--quiet"});
  ASSERT_EQ(done.status, 0) << done.err;
  const json out = json_of(folder_.path("out.json"));
  ASSERT_EQ(out["drive_gains"].size(), 6u);
  const Model arm = read_model(model);
  for (std::size_t j = 0; j < 6; ++j) {
    const json& g = out["drive_gains"][j];
    EXPECT_EQ(g["joint"], j + 1);
    EXPECT_EQ(g["unit"], "N m/A");
    EXPECT_TRUE(g["identifiable"].get<bool>());
    EXPECT_NEAR(g["value"].get<double>() / kGains[j], 1.0, 0.01);
    EXPECT_LT(g["ci95"][0].get<double>(), g["value"].get<double>());
    EXPECT_GT(g["ci95"][1].get<double>(), g["value"].get<double>());
    EXPECT_NEAR(arm.coordinates()[j].drive_gain, g["value"].get<double>(), 1e-9);
    EXPECT_NEAR(arm.coordinates()[j].drive_gain_deviation, g["std"].get<double>(), 1e-9);
    EXPECT_NE(done.out.find(g["coordinate"].get<std::string>()), std::string::npos);
  }
  const json& known = out["known_masses"][0];
  EXPECT_EQ(known["recordings"], json::array({load}));
  EXPECT_TRUE(known["identified"].get<bool>());
  EXPECT_NEAR(known["centre"][1].get<double>(), 0.08, 2e-3);
  EXPECT_EQ(out["settings"]["train"], json::array({a, b}));
  // The model reads currents: its errors are those of newton metres.
  for (const json& e : out["train"]["relative_error"]) EXPECT_LT(e.get<double>(), 0.05);
}

TEST_F(KnownMass, OptionInTheWrongFormatIsRefusedInOneLine) {
  const std::string any = folder_.write("any.csv", "t,q1\n0,0\n");
  for (const auto& [asked, words] :
       {std::pair("2.8", "expected KG@FRAME"), std::pair("2.8@flnge", "did you mean 'flange'?"),
        std::pair("2.8@flange=other.csv", "'other.csv'")}) {
    const ToolRun run =
        run_tool({"identify", "ur10e", "--train", any, any, "--known-mass", asked, "--quiet"});
    EXPECT_EQ(run.status, 2);
    EXPECT_EQ(run.error_lines(), 1) << run.err;
    EXPECT_NE(run.err.find(words), std::string::npos) << run.err;
  }
}

// The controller's own targets have 12.0, 12.0, 9.82, 10.68, 10.9 and 11.0 N m/A.
TEST(KnownMassOfARealArm, GivesGainsNearThoseOfItsController) {
  const char* named = std::getenv("VERIDYN_REAL_DATA");
  const std::string data =
      named != nullptr ? named : std::string(VERIDYN_SOURCE_DIR) + "/../shared/data";
  if (!std::filesystem::is_directory(data))
    GTEST_SKIP() << "no real recordings: " << data << " is not there";
  const TemporaryFolder folder;
  // The robot without the gains of its file.
  ModelDescription bare = read_model("ur10e").description();
  for (Coordinate& c : bare.coordinates) c.drive_gain = 0.0;
  save_model(Model(bare), folder.path("bare.yaml"));
  const std::string load = data + "/ur10e/load-2805g-14harm50s-2020-02-19.csv";
  const ToolRun run = run_tool({"identify", folder.path("bare.yaml"), "--train",
                                data + "/ur10e/free-12harm30s-2020-02-10.csv",
                                data + "/ur10e/free-14harm50s-2020-02-19.csv", load, "--known-mass",
                                "2.805@flange", "--filter-cutoff", "7", "--resample", "100",
                                "--quiet", "--json", folder.path("out.json")});
  ASSERT_EQ(run.status, 0) << run.err;
  const json out = json_of(folder.path("out.json"));
  EXPECT_EQ(out["known_masses"][0]["recordings"], json::array({load}));
  const double controller[6] = {12.0, 12.0, 9.82, 10.68, 10.9, 11.0};
  int covered = 0;
  for (std::size_t j = 0; j < 6; ++j) {
    const json& g = out["drive_gains"][j];
    EXPECT_TRUE(g["identifiable"].get<bool>()) << g["why"];
    EXPECT_NEAR(g["value"].get<double>() / controller[j], 1.0, 0.07) << g["coordinate"];
    covered += static_cast<int>(g["ci95"][0].get<double>() < controller[j] &&
                                g["ci95"][1].get<double>() > controller[j]);
  }
  EXPECT_GE(covered, 5);
}

}  // namespace
}  // namespace veridyn
