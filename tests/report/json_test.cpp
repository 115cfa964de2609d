#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "veridyn/files/model_file.hpp"
#include "veridyn/report/watch_json.hpp"
#include "veridyn/report/json.hpp"

namespace veridyn {
namespace {

using nlohmann::json;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(InfoJson, CoefficientsEqualTheMatrixOfBaseParameters) {
  const RobotInfo info = robot_info(read_model("psm-3dof"));
  const json out = json::parse(to_json(info));
  for (int j = 0; j < info.base.size(); ++j) {
    const json& coefficients = out["base_parameters"][j]["coefficients"];
    std::size_t nonzero = 0;
    for (std::size_t p = 0; p < info.parameters.size(); ++p) {
      const double k = info.base.K(j, static_cast<Eigen::Index>(p));
      if (k == 0.0) continue;
      ++nonzero;
      EXPECT_EQ(coefficients[info.parameters[p].name].get<double>(), k);
    }
    EXPECT_EQ(coefficients.size(), nonzero);
  }
}

TEST(IdentificationJson, NumbersThatAreNotFiniteBecomeNull) {
  Identification id;
  id.rank_gap = kInfinity;
  id.base = {{"a", "a", "kg", 0.1, std::nan("")}};
  const json out = json::parse(to_json(id));
  EXPECT_TRUE(out["rank_gap"].is_null());
  EXPECT_TRUE(out["base_parameters"][0]["std"].is_null());
  EXPECT_TRUE(out["test"].is_null());
  EXPECT_EQ(out["noise_floor"]["source"], "none");
}

TEST(IdentificationJson, NumbersAreReadBackToTheLastBit) {
  Identification id;
  id.objective = 1.0 / 3.0;
  id.duality_gap = 1.2345678901234567e-301;
  id.condition_number_scaled = 43.123456789012345;
  id.condition_number = 1e7 / 3.0;
  const json out = json::parse(to_json(id));
  EXPECT_EQ(out["objective"].get<double>(), id.objective);
  EXPECT_EQ(out["duality_gap"].get<double>(), id.duality_gap);
  EXPECT_EQ(out["condition_number"].get<double>(), id.condition_number_scaled);
  EXPECT_EQ(out["condition_number_unscaled"].get<double>(), id.condition_number);
}

TEST(IdentificationJson, AnyFileNameGivesValidJson) {
  Identification id;
  id.test.resize(1);
  id.test[0].source = "quote \" backslash \\ line\nbreak and \xff, no UTF-8";
  EXPECT_TRUE(json::accept(to_json(id)));
}

TEST(QualityJson, EveryFindingIsListedPerRecordingAndInTotal) {
  RecordingQuality quality;
  quality.file = "a.csv";
  QualityFinding finding;
  finding.file = "a.csv";
  finding.kind = QualityKind::kStaleRows;
  finding.share = 0.13;
  finding.value = std::nan("");
  finding.severity = Severity::kWarning;
  quality.findings = {finding};
  const json out = json::parse(to_json(std::vector<RecordingQuality>{quality, quality}));
  EXPECT_EQ(out["recordings"].size(), 2u);
  EXPECT_EQ(out["data_quality"].size(), 2u);
  EXPECT_EQ(out["data_quality"][1], out["recordings"][1]["findings"][0]);
  EXPECT_EQ(out["data_quality"][0]["share"].get<double>(), 0.13);
  EXPECT_TRUE(out["data_quality"][0]["value"].is_null());
  EXPECT_TRUE(out["recordings"][0]["period"].is_null());
}

}  // namespace
TEST(WatchJson, StagesOfOneChangeCountAsOneAlarm) {
  WatchedSource watched;
  for (const auto& [id, stage] : std::vector<std::pair<int, WatchStage>>{{1, WatchStage::kPresent},
                                                                         {2, WatchStage::kSuspected},
                                                                         {2, WatchStage::kNamed},
                                                                         {3, WatchStage::kSuspected},
                                                                         {4, WatchStage::kSuspected},
                                                                         {4, WatchStage::kBlind},
                                                                         {0, WatchStage::kBlind}}) {
    WatchEvent event;
    event.id = id;
    event.stage = stage;
    watched.events.push_back(event);
  }
  EXPECT_EQ(watched.alarms(), 2);
}

}  // namespace veridyn
