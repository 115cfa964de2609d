#include "veridyn/report/diagnosis_json.hpp"
#include "error_json.hpp"
#include "json_value.hpp"
#include "settings_json.hpp"

namespace veridyn {
namespace {

Json error_pair(const Identification& id) {
  Json out;
  out["train"] = error_json(id.train_error, id.train_repaired, id.train_without_excluded);
  out["test"] = error_json(id.test_error, id.test_repaired, id.test_without_excluded);
  out["recordings"] = Json::array();
  for (const RecordingError& r : id.test) {
    Json one = error_json(r.error, r.repaired, r.without_excluded);
    one["source"] = r.source;
    out["recordings"].push_back(std::move(one));
  }
  return out;
}

Json summary_json(const DiagnosisSummary& s) {
  return {{"main_findings", s.main},
          {"explained_by_main", s.explained_by_main},
          {"explained_by_all", s.explained_by_all},
          {"worse_joints", s.worse_joints},
          {"held_out_untouched", s.held_out_untouched}};
}

Json finding_json(const Finding& f) {
  Json out = {{"rank", f.rank},
              {"effect", f.effect},
              {"joint", f.joint},
              {"coordinate", f.coordinate},
              {"unit", f.unit},
              {"status", name_of(f.status)},
              {"main", f.main}};
  if (!f.frame.empty()) out["frame"] = f.frame;
  if (!f.constant.empty()) out["constant"] = f.constant;
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
  if (f.test_outside.size() > 0)
    out["outside"] = {{"relative_error", json_list(f.test_outside)}};
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
                     {"severity", name_of(f.severity)},
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
  out["verdict"] = d.verdict();
  out["summary"] = summary_json(d.summary);
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
  out["remarks"] = d.remarks;
  out["excluded_intervals"] = Json::array();
  for (const LeftOut& part : d.left_out) {
    out["excluded_intervals"].push_back({{"file", part.source},
                                         {"joint", part.joint + 1},
                                         {"from", part.from},
                                         {"to", part.to},
                                         {"why", part.why}});
  }
  out["left_out"] = out["excluded_intervals"];  // the key of earlier versions
  out["data_quality"] = quality_json(d);
  out["settings"] = settings_json(d.baseline);
  out["seconds"] = d.seconds;
  return written(out);
}

}  // namespace veridyn
