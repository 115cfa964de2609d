#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "support/simulated.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/identification/joint_score.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"

// diagnose() of an identification reads and fits nothing twice.

namespace veridyn {
namespace {

// Two rods without values.
Model unknown_arm() {
  ModelDescription d = read_model("planar-2r").description();
  for (Frame& frame : d.frames) {
    if (frame.body) frame.body->phi.reset();
  }
  for (EffectTerm& term : d.effects) {
    for (const EffectParameter& p : find_effect(term.effect).parameters()) term.values.erase(p.name);
  }
  return Model(std::move(d));
}

// Recordings of the arm with a spring at its elbow, as files.
std::vector<std::string> recorded(int count) {
  std::vector<std::string> out;
  for (int k = 1; k <= count; ++k) {
    SimulationOptions options;
    options.hidden = {parse_hidden_effect("joint_spring:elbow:stiffness=3")};
    options.noise.torque_white = 0.01;
    options.seed = static_cast<unsigned>(k);
    Recording one = recording_of(simulate_recording(read_model("planar-2r"), waves_of(static_cast<unsigned>(k)), options));
    out.push_back((std::filesystem::temp_directory_path() / text("way-", k, ".csv")).string());
    write_recording(one, out.back());
  }
  return out;
}

TEST(OfIdentification, ReadsEveryFileOnceFromRecordingsToASavedModel) {
  const std::vector<std::string> files = recorded(3);
  const Model robot = unknown_arm();
  const Recordings train = read_recordings(robot, {files[0], files[1]});
  const Recordings test = read_recordings(robot, {files[2]});
  for (const std::string& file : files) std::filesystem::remove(file);
  const Identification fit = identify(robot, train);
  ASSERT_TRUE(fit.model) << fit.reason;
  EXPECT_NE(fit.verdict(), "");
  // The same errors as of test recordings given to identify().
  const VectorXd held_out = identify(robot, train, test).test_error.relative;
  const std::vector<JointScore> scores = validate(fit, test);
  ASSERT_EQ(scores.size(), 2U);
  for (int i = 0; i < 2; ++i) EXPECT_NEAR(scores[static_cast<size_t>(i)].error, held_out[i], 1e-9) << scores[static_cast<size_t>(i)];

  DiagnosisOptions options;
  options.effects = {"joint_spring", "quadratic_drag"};
  const Diagnosis why = diagnose(fit, test, options);
  ASSERT_EQ(why.findings.size(), 1U);
  std::ostringstream words;
  words << why.findings[0];
  EXPECT_EQ(words.str(), why.sentence(why.findings[0]));
  EXPECT_NE(words.str().find("spring"), std::string::npos) << words.str();
  const auto& effects = why.model.effects();
  EXPECT_TRUE(std::any_of(effects.begin(), effects.end(), [](const EffectTerm& e) { return e.effect == "joint_spring"; }));
  EXPECT_LT(validate(why.model, test)[1].error, 0.5 * scores[1].error);

  // The baseline equals that of a diagnosis of the robot file.
  const Diagnosis direct = diagnose(robot, train, test, options);
  ASSERT_EQ(direct.baseline.parameters.size(), why.baseline.parameters.size());
  EXPECT_LT((direct.baseline.parameters - why.baseline.parameters).cwiseAbs().maxCoeff(), 1e-6);

  const std::string path = (std::filesystem::temp_directory_path() / "why.yaml").string();
  save(why, path);
  EXPECT_EQ(read_model(path).effects().size(), effects.size());
  save(why.model, path);
  EXPECT_EQ(read_model(path).effects().size(), effects.size());
}

TEST(OfIdentification, WithoutAModelTheIdentificationIsTheBaseline) {
  Identification none;
  none.reason = "no data";
  const Diagnosis why = diagnose(none, {});
  EXPECT_EQ(why.baseline.reason, "no data");
  EXPECT_TRUE(why.findings.empty());
  EXPECT_EQ(why.model.joints(), 0);
  EXPECT_THROW(save(why, "nowhere.yaml"), InvalidInput);
  EXPECT_THROW(validate(none, {}), InvalidInput);
}

}  // namespace
}  // namespace veridyn
