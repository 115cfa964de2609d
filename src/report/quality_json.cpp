#include "json_value.hpp"
#include "veridyn/report/json.hpp"

namespace veridyn {
namespace {

Json finding_json(const QualityFinding& finding) {
  return {{"file", finding.file},        {"finding", finding.finding},
          {"signal", finding.signal},    {"joint", finding.joint},
          {"share", finding.share},      {"value", finding.value},
          {"unit", finding.unit},        {"severity", name_of(finding.severity)},
          {"sentence", finding.sentence}};
}

}  // namespace

std::string to_json(const std::vector<RecordingQuality>& recordings) {
  Json out = json_head("check");
  out["recordings"] = Json::array();
  out["data_quality"] = Json::array();
  for (const RecordingQuality& recording : recordings) {
    Json findings = Json::array();
    for (const QualityFinding& finding : recording.findings) {
      findings.push_back(finding_json(finding));
      out["data_quality"].push_back(findings.back());
    }
    const Json period = recording.period.found() ? Json(recording.period.seconds) : Json();
    out["recordings"].push_back({{"file", recording.file},
                                 {"rows", recording.rows},
                                 {"joints", recording.joints},
                                 {"duration", recording.duration},
                                 {"rate", recording.rate},
                                 {"period", period},
                                 {"repeats", recording.period.repeats},
                                 {"severity", name_of(recording.severity())},
                                 {"findings", std::move(findings)}});
  }
  return written(out);
}

}  // namespace veridyn
