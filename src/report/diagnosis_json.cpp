#include "veridyn/report/diagnosis_json.hpp"
#include "json_value.hpp"
#include "settings_json.hpp"

namespace veridyn {
namespace {

Json error_pair(const Identification& id) {
  Json out = {{"train", {{"relative_error", json_list(id.train_error.relative)}}}};
  out["test"] = {{"relative_error", json_list(id.test_error.relative)},
                 {"moving", {{"relative_error", json_list(id.test_error.moving_relative)}}}};
  const VectorXd& as_recorded = id.test_as_recorded.relative;
  if (as_recorded.size() > 0)
    out["test"]["as_recorded"] = {{"relative_error", json_list(as_recorded)}};
  out["recordings"] = Json::array();
  for (const RecordingError& r : id.test) {
    Json one = {{"source", r.source}, {"relative_error", json_list(r.error.relative)}};
    if (r.filled.count > 0)
      one["as_recorded"] = {{"relative_error", json_list(r.as_recorded.relative)}};
    out["recordings"].push_back(std::move(one));
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

const RecordingError* with_filled_rows(const Identification& id, const std::string& file) {
  for (const auto* list : {&id.train, &id.test}) {
    for (const RecordingError& r : *list) {
      if (r.source == file && r.filled.count > 0) return &r;
    }
  }
  return nullptr;
}

Json quality_json(const Diagnosis& d) {
  Json out = Json::array();
  for (const RecordingQuality& r : d.data_quality) {
    for (const QualityFinding& f : r.findings) {
      if (f.severity == Severity::kInfo) continue;
      out.push_back({{"file", f.file},
                     {"finding", f.finding},
                     {"joint", f.joint},
                     {"share", f.share},
                     {"sentence", f.sentence}});
      if (f.finding != "stale_rows") continue;
      const RecordingError* filled = with_filled_rows(d.baseline, f.file);
      if (filled != nullptr) out.back()["filled_rows"] = filled_json(*filled);
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
  out["data_quality"] = quality_json(d);
  out["settings"] = settings_json(d.baseline);
  out["seconds"] = d.seconds;
  return written(out);
}

}  // namespace veridyn
