#include "report/json/json_value.hpp"
#include "veridyn/report/json.hpp"

namespace veridyn {
namespace {

Json finding_json(const QualityFinding& finding) {
  return {{"file", finding.file},        {"finding", name_of(finding.kind)},
          {"signal", finding.signal},    {"joint", finding.joint ? finding.joint->value + 1 : 0},
          {"share", finding.share},      {"value", finding.value},
          {"unit", finding.unit},        {"severity", name_of(finding.severity)},
          {"sentence", finding.sentence}};
}

Json topics_json(const RecordingFacts& facts) {
  return json_each(facts.topics, [&](const TopicFacts& topic) -> Json {
    return {{"name", topic.name}, {"type", topic.type}, {"messages", topic.messages}, {"rate", topic.rate},
            {"joints", topic.joints}, {"used", topic.used}, {"undecoded", topic.undecoded}};
  });
}

Json matched_json(const RecordingFacts& facts) {
  Json matched = Json::object();
  for (const JointMatch& one : facts.matched) matched[one.joint] = one.recorded;
  return matched;
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
                                 {"joints", recording.facts.joints},
                                 {"joint_count", recording.joints},
                                 {"format", recording.facts.format},
                                 {"start", recording.facts.start},
                                 {"matched", matched_json(recording.facts)},
                                 {"topics", topics_json(recording.facts)},
                                 {"remarks", recording.facts.remarks},
                                 {"duration", recording.duration},
                                 {"rate", recording.rate},
                                 {"period", period},
                                 {"repeats", recording.period.repeats},
                                 {"severity", name_of(recording.severity())},
                                 {"findings", std::move(findings)}});
  }
  // The result of a single recording repeats the most used keys at the top level.
  if (recordings.size() == 1) {
    for (const char* key : {"rate", "joints", "rows", "topics"}) out[key] = out["recordings"][0][key];
  }
  return json_text(out);
}

}  // namespace veridyn
