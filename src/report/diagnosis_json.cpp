#include "veridyn/report/diagnosis_json.hpp"
#include "json_value.hpp"
#include "settings_json.hpp"

namespace veridyn {
namespace {

Json error_pair(const Identification& id) {
  Json out = {{"train", {{"relative_error", json_list(id.train_error.relative)}}}};
  out["test"] = {{"relative_error", json_list(id.test_error.relative)},
                 {"moving", {{"relative_error", json_list(id.test_error.moving_relative)}}}};
  out["recordings"] = Json::array();
  for (const RecordingError& r : id.test) {
    out["recordings"].push_back(
        {{"source", r.source}, {"relative_error", json_list(r.error.relative)}});
  }
  return out;
}

Json finding_json(const Finding& f) {
  Json out = {{"rank", f.rank},
              {"effect", f.effect},
              {"joint", f.joint},
              {"coordinate", f.coordinate},
              {"unit", f.unit}};
  if (!f.frame.empty()) out["frame"] = f.frame;
  if (!f.source.empty()) out["recording"] = f.source;
  out["parameters"] = Json::object();
  for (const FoundParameter& p : f.parameters) {
    out["parameters"][p.name] = {
        {"value", p.value}, {"unit", p.unit}, {"ci95", Json::array({p.low, p.high})}};
  }
  out["p_value"] = f.p_value;
  out["gain"] = {{"test_relative_error",
                  {{"before", json_list(f.test_before)}, {"after", json_list(f.test_after)}}},
                 {"log_mean_square", f.gain}};
  out["explains"] = f.explains;
  out["rivals"] = Json::array();
  for (const Rival& r : f.rivals) {
    out["rivals"].push_back(
        {{"effect", r.effect}, {"joint", r.joint}, {"coordinate", r.coordinate}, {"why", r.why}});
    if (!r.frame.empty()) out["rivals"].back()["frame"] = r.frame;
  }
  out["sentence"] = f.sentence;
  return out;
}

Json quality_json(const std::vector<RecordingQuality>& recordings) {
  Json out = Json::array();
  for (const RecordingQuality& r : recordings) {
    for (const QualityFinding& f : r.findings) {
      if (f.severity == Severity::kInfo) continue;
      out.push_back({{"file", f.file},
                     {"finding", f.finding},
                     {"joint", f.joint},
                     {"share", f.share},
                     {"sentence", f.sentence}});
    }
  }
  return out;
}

}  // namespace

std::string to_json(const Diagnosis& d) {
  Json out = json_head("diagnose");
  out["robot"] = d.baseline.robot;
  out["verdict"] = d.findings.empty() ? "none" : d.findings.front().sentence;
  out["provisional"] = d.provisional;
  out["changes_since"] = d.changes;
  out["hypotheses"] = d.hypotheses;
  out["baseline"] = error_pair(d.baseline);
  out["findings"] = Json::array();
  for (const Finding& f : d.findings) out["findings"].push_back(finding_json(f));
  out["not_supported"] = Json::array();
  for (const NotSupported& n : d.not_supported) {
    out["not_supported"].push_back(
        {{"effect", n.effect}, {"joint", n.joint}, {"p_value", n.p_value}, {"why", n.why}});
  }
  out["cannot_tell"] = Json::array();
  for (const CannotTell& c : d.cannot_tell) {
    out["cannot_tell"].push_back({{"effect", c.effect}, {"joint", c.joint}, {"why", c.why}});
  }
  out["noise_floor"] = {{"relative_error", json_list(d.baseline.noise_floor)}};
  out["extended"] = error_pair(d.extended);
  out["next_experiment"] = {{"separates", d.next_experiment.separates},
                            {"trajectory", d.next_experiment.trajectory}};
  out["left_out"] = Json::array();
  for (const LeftOut& part : d.left_out) {
    out["left_out"].push_back({{"file", part.source},
                               {"joint", part.joint + 1},
                               {"from", part.from},
                               {"to", part.to},
                               {"why", part.why}});
  }
  out["data_quality"] = quality_json(d.data_quality);
  out["settings"] = settings_json(d.baseline);
  out["seconds"] = d.seconds;
  return written(out);
}

}  // namespace veridyn
