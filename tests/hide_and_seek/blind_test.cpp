#include "hide_and_seek/blind.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "hide_and_seek/detection_limit.hpp"
#include "support/near.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::seek {
namespace {

namespace fs = std::filesystem;

class Blind : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = testing::TempDir() + "/blind-" +
              testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder_);
    BoardRequest request;
    request.arms = {"pick-scara"};
    request.effects = {"backlash", "none"};
    request.seeds = {3};
    export_cases(request, folder_, folder_ + ".truth.json");
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::vector<Outcome> score_of(const Json& answers) const {
    const std::string path = folder_ + "/answers.json";
    std::ofstream(path) << answers;
    return score(folder_, path, folder_ + ".truth.json");
  }

  Json truth() const { return Json::parse(std::ifstream(folder_ + ".truth.json")); }

  std::string folder_;
};

TEST_F(Blind, CasesHoldRecordingsAndNoTruth) {
  const Json list = Json::parse(std::ifstream(folder_ + "/cases.json"));
  ASSERT_EQ(list["cases"].size(), 2U);
  for (const Json& one : list["cases"]) {
    const std::string here = folder_ + "/" + one["id"].get<std::string>() + "/";
    EXPECT_TRUE(fs::exists(here + one["robot"].get<std::string>()));
    EXPECT_EQ(one["train"].size(), 4U);
    for (const Json& name : one["train"]) EXPECT_TRUE(fs::exists(here + name.get<std::string>()));
    EXPECT_FALSE(one.contains("effect"));
  }
  EXPECT_THROW(export_cases({}, folder_, folder_ + ".truth.json"), InvalidInput);
}

TEST_F(Blind, OnlyTheTruthScoresAsRight) {
  Json right = {{"answers", Json::object()}};
  const Json sealed = truth();
  for (const auto& [id, one] : sealed["cases"].items()) {
    Json findings = Json::array();
    for (const Json& c : one["causes"])
      findings.push_back({{"effect", c["effect"]}, {"joint", c["joint"]}, {"frame", c["frame"]}});
    right["answers"][id] = {{"findings", findings}};
  }
  Totals t = totals(score_of(right));
  EXPECT_EQ(t.cases, 2);
  EXPECT_EQ(t.first, 1);  // nothing is hidden in the other
  EXPECT_EQ(t.named, t.hidden);
  EXPECT_EQ(t.extras, 0);
  t = totals(score_of({{"answers", Json::object()}}));
  EXPECT_EQ(t.named, 0);
  EXPECT_EQ(t.extras, 0);
  Json wrong = right;
  for (auto& [id, one] : wrong["answers"].items())
    one["findings"] = Json::array({{{"effect", "quadratic_drag"}, {"joint", 1}}});
  t = totals(score_of(wrong));
  EXPECT_EQ(t.named, 0);
  EXPECT_EQ(t.extras, 2);
}

// From exported files alone to the score of the answers.
TEST_F(Blind, DiagnoseAnswersExportedCases) {
  DiagnosisOptions options;
  options.identification.threads = 2;
  const Json answers = answer_cases(folder_, options);
  ASSERT_EQ(answers["answers"].size(), 2U);
  const Totals t = totals(score_of(answers));
  EXPECT_EQ(t.cases, 2);
  EXPECT_EQ(t.first, 1);
  EXPECT_EQ(t.extras, 0);
}

// The answers have the same format and are scored by the same code; one finding is on the joint of the hidden cause.
TEST_F(Blind, TheBaselineAnswersExportedCases) {
  const Json sealed = truth();
  Json list = Json::parse(std::ifstream(folder_ + "/cases.json"));
  Json hidden = Json::array();  // one case is enough
  for (const Json& one : list["cases"]) {
    if (!sealed["cases"][one["id"].get<std::string>()]["causes"].empty()) hidden.push_back(one);
  }
  list["cases"] = hidden;
  std::ofstream(folder_ + "/cases.json") << list;
  const Json answers = answer_cases_by_least_squares(folder_, 2);
  ASSERT_EQ(answers["answers"].size(), 1U);
  EXPECT_EQ(answers["tool"], "plain least squares");
  EXPECT_EQ(totals(score_of(answers)).cases, 1);
  for (const auto& [id, one] : sealed["cases"].items()) {
    if (one["causes"].empty()) continue;
    const Json& found = answers["answers"][id]["findings"];
    ASSERT_FALSE(found.empty()) << id;
    EXPECT_EQ(found[0]["joint"], one["causes"][0]["joint"]) << answers.dump(1);
    for (const auto& [name, p] : found[0]["parameters"].items())
      EXPECT_LT(p["ci95"][0].get<double>(), p["ci95"][1].get<double>()) << name;
  }
}

TEST_F(Blind, MalformedAnswersAreRefusedWithTheirPlace) {
  try {
    score_of({{"answers", {{"case-001", {{"findings", Json::array({{{"joint", 1}}})}}}}}});
    FAIL() << "an answer without an effect was judged";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("case-001, finding 1"), std::string::npos)
        << error.what();
  }
}

// Cases sampled finely from a logistic curve with known parameters.
TEST(DetectionLimit, RecoversTheParametersOfALogisticCurve) {
  std::vector<SizedCase> cases;
  Draw draw(5, "detection limit");
  for (int k = 0; k < 4000; ++k) {
    const double share = draw.log_in(0.005, 0.2);
    const double p = 1.0 / (1.0 + std::pow(0.03 / share, 3.0));
    cases.push_back({share, draw.in(0.0, 1.0) < p});
  }
  const DetectionLimit found = detection_limit(cases);
  EXPECT_NEAR(found.half, 0.03, 0.002);
  EXPECT_NEAR(found.nine_tenths, 0.03 * std::pow(9.0, 1.0 / 3.0), 0.006);
  for (SizedCase& c : cases) c.named = true;
  EXPECT_TRUE(std::isnan(detection_limit(cases).half));
}

// At rest the base gives way by a constant angle, against the moment that holds the arm up. The torque that it
// adds is the difference of two static torques, and the lean lowers the arm's centre of mass.
TEST(Trouble, AnElasticBaseAddsTheTorqueOfALeaningArm) {
  const Bench bench = make_bench("bench-6r", 4);
  const Motion::Rows rows{VectorXd::LinSpaced(11, 0.0, 0.05), MatrixXd::Constant(11, bench.arm.joints, 0.3),
                          MatrixXd::Zero(11, bench.arm.joints), MatrixXd::Zero(11, bench.arm.joints)};
  const VectorXd q = rows.q.row(0).transpose();
  const VectorXd rest = VectorXd::Zero(bench.arm.joints);
  const auto turned = [&](double x, double y) {
    LagrangeArm out = bench.arm;
    out.gravity = -Vector3d(x, y, 0.0).cross(bench.arm.gravity) + bench.arm.gravity;
    return out;
  };
  // The moment about x or y is the slope of the potential energy sum of m (-g)' r against that turn.
  const auto moment = [&](const Vector3d& axis) {
    const std::vector<Matrix4d> poses = bench.arm.poses(q);
    double out = 0.0;
    for (size_t k = 0; k < poses.size(); ++k) {
      const Vector3d first_moment = (poses[k] * bench.arm.links[k].moments.col(3)).head<3>();
      out += -bench.arm.gravity.dot(axis.cross(first_moment));
    }
    return out;
  };
  const double about_x = moment(Vector3d::UnitX());
  const double about_y = moment(Vector3d::UnitY());
  const double peak = std::max(std::abs(about_x), std::abs(about_y));
  Draw draw(4, "elastic base");
  const double x = -draw.in(3e-3, 8e-3) * about_x / peak;
  const double y = -draw.in(3e-3, 8e-3) * about_y / peak;
  const VectorXd expected = turned(x, y).torque(q, rest, rest) - bench.arm.torque(q, rest, rest);
  const MatrixXd added = elastic_base_torque(bench.arm, 4, rows);
  EXPECT_GT(expected.norm(), 1e-3 * bench.arm.torque(q, rest, rest).norm());
  EXPECT_TRUE(near(added.row(5).transpose(), expected, 0.02 * expected.norm()));
}

TEST(Trouble, LateRowsRepeatATenthOfTheRows) {
  MatrixXd q(4000, 2);
  for (Eigen::Index r = 0; r < q.rows(); ++r) q.row(r).setConstant(static_cast<double>(r));
  MatrixXd dq = q;
  MatrixXd tau = q;
  trouble_rows(Trouble::kLateRows, 1, 1, VectorXd::LinSpaced(4000, 0.0, 20.0), q, dq, tau);
  int repeated = 0;
  for (Eigen::Index r = 1; r < q.rows(); ++r) repeated += static_cast<int>(q(r, 0) == q(r - 1, 0));
  EXPECT_NEAR(repeated / 4000.0, 0.1, 0.02);
  EXPECT_EQ(q, tau);
}

}  // namespace
}  // namespace veridyn::seek
