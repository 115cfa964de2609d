#include "veridyn/report/diagnosis_json.hpp"

#include <algorithm>
#include <cmath>

#include "report/json/json_value.hpp"
#include "report/json/settings_json.hpp"

namespace veridyn {
namespace {

// Errors over all training and all test recordings, and those of each test recording.
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

Json numbers_json(const std::vector<JointIndex>& joints) {
  return json_each(joints, [](JointIndex joint) -> Json { return joint.value + 1; });
}

Json summary_json(const DiagnosisSummary& s) {
  return {{"main_findings", s.main},
          {"explained_by_main", s.explained_by_main},
          {"explained_by_all", s.explained_by_all},
          {"worse_joints", numbers_json(s.worse_joints)},
          {"held_out_untouched", true}};
}

// Name and joint of a cause; the joint is omitted without an arm.
Json cause_json(const Diagnosis& d, const Cause& cause) {
  if (!d.baseline.model) return {{"effect", effect_of(cause)}};
  const CauseWords w = words_of(*d.baseline.model, cause);
  return {{"effect", w.effect}, {"joint", w.joint ? w.joint->value + 1 : 0}};
}

// Adds the other terms for a cause's place: coordinate, frame, constant, text form.
void add_place(const Diagnosis& d, const Cause& cause, Json& out) {
  if (!d.baseline.model) return;
  const CauseWords w = words_of(*d.baseline.model, cause);
  out["coordinate"] = w.coordinate;
  if (!w.frame.empty()) out["frame"] = w.frame;
  if (!w.constant.empty()) out["constant"] = w.constant;
  out["cause"] = to_text(*d.baseline.model, cause);
}

Json next_json(const Diagnosis& d, const std::string& command) {
  const NextExperiment& next = d.next_experiment;
  Json out = {{"separates", Json::array()}, {"trajectory", command}};
  if (!next.shows.empty()) out["shows"] = next.shows;
  if (next.between.empty() || !d.baseline.model) return out;
  out["between"] = Json::array();
  for (size_t k = 0; k < next.between.size(); ++k) {
    out["separates"].push_back(next.words(*d.baseline.model, k));
    out["between"].push_back(to_text(*d.baseline.model, next.between[k]));
  }
  return out;
}

Json verdict_json(const Diagnosis& d, const JointVerdict& v) {
  Json out = {{"joint", v.joint.value + 1},
              {"held_out", v.held_out},
              {"floor", v.floor},
              {"removable", v.removable},
              {"state", name_of(v.state)},
              {"floor_source", name_of(v.source)},
              {"named", v.held_out - v.extended},
              {"unnamed", v.extended - v.left},
              {"left", v.left - v.floor}};
  if (d.baseline.model)
    out["coordinate"] = d.baseline.model->coordinates()[v.joint.value].name;
  if (!v.why.empty()) out["why"] = v.why;
  return out;
}

// Adds signals, words and curve of an unnamed effect to its finding.
void add_shape(const UnnamedShape& shape, Json& out) {
  out["signals"] = shape.signals;
  out["shape"] = shape.words;
  out["share"] = shape.share;
  out["kept"] = shape.kept;
  out["curve"] = Json::array();
  for (const CurvePoint& p : shape.curve)
    out["curve"].push_back({{"at", p.at}, {"value", p.value}, {"band", Json::array({p.low, p.high})}});
  out["curve_units"] = shape.units;
}

// Adds the three components of a direction of gravity as one vector.
void add_gravity(const Finding& f, Json& parameters) {
  Json value = Json::array(), low = value, high = value;
  for (const FoundParameter& p : f.parameters) {
    if (p.name.rfind("gravity_", 0) != 0) continue;
    value.push_back(p.value);
    low.push_back(p.low);
    high.push_back(p.high);
  }
  if (value.size() == 3) parameters["gravity"] = {{"value", value}, {"unit", "m/s^2"}, {"ci95", Json::array({low, high})}};
}

Json finding_json(const Diagnosis& d, const Finding& f) {
  Json out = {{"rank", f.rank}};
  out.update(cause_json(d, f.cause));
  add_place(d, f.cause, out);
  out["unit"] = f.unit;
  out["status"] = name_of(f.status);
  out["held_out"] = name_of(f.held_out());
  out["main"] = f.main;
  if (f.from && d.baseline.model) out["from"] = d.baseline.model->coordinates()[f.from->value].name;
  if (!f.source.empty()) out["recording"] = f.source;
  out["parameters"] = Json::object();
  for (const FoundParameter& p : f.parameters) {
    out["parameters"][p.name] = {
        {"value", p.value}, {"unit", p.unit}, {"ci95", Json::array({p.low, p.high})}};
  }
  add_gravity(f, out["parameters"]);
  out["p_value"] = f.p_value;
  out["gain"] = {{"test_relative_error",
                  {{"before", json_list(f.test_before)}, {"after", json_list(f.test_after)}}},
                 {"log_mean_square", f.gain}};
  if (f.test_before.size() > 0 && f.test_after.size() == f.test_before.size())
    out["gain"]["largest_fall"] = std::max(0.0, (f.test_before - f.test_after).maxCoeff());
  if (f.test_outside.size() > 0)
    out["outside"] = {{"relative_error", json_list(f.test_outside)}};
  out["explains"] = f.explains;
  out["rivals"] = Json::array();
  for (const Rival& r : f.rivals) {
    Json rival = cause_json(d, r.cause);
    add_place(d, r.cause, rival);
    rival["why"] = r.why;
    out["rivals"].push_back(std::move(rival));
  }
  if (f.shape) add_shape(*f.shape, out);
  out["phrase"] = f.phrase;
  if (!f.remark.empty()) out["remark"] = f.remark;
  out["sentence"] = d.sentence(f);
  return out;
}

// The recording of this file, if rows of it were filled; else null.
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
                     {"finding", name_of(f.kind)},
                     {"severity", name_of(f.severity)},
                     {"joint", f.joint ? f.joint->value + 1 : 0},
                     {"share", f.share},
                     {"sentence", f.sentence}});
      if (f.kind != QualityKind::kStaleRows) continue;
      const RecordingError* filled = with_filled_rows(d.baseline, f.file);
      if (filled != nullptr) out.back()["filled_rows"] = filled_json(*filled);
    }
  }
  return out;
}

}  // namespace

std::string to_json(const Diagnosis& d, const std::string& next_command) {
  Json out = json_head("diagnose");
  out["robot"] = d.baseline.robot;
  out["verdict"] = json_each(d.joints, [&](const JointVerdict& v) -> Json { return verdict_json(d, v); });
  out["verdict_sentence"] = d.verdict();
  out["mended"] = d.mended;
  out["summary"] = summary_json(d.summary);
  out["provisional"] = d.provisional;
  out["changes_since"] = d.changes;
  out["hypotheses"] = d.hypotheses;
  out["baseline"] = error_pair(d.baseline);
  out["moving_as_one"] = json_each(d.moving_as_one, numbers_json);
  out["findings"] = Json::array();
  if (d.small_apart) out["small"] = Json::array();
  for (const Finding& f : d.findings) out[d.small_apart && !f.main ? "small" : "findings"].push_back(finding_json(d, f));
  out["not_supported"] = Json::array();
  for (const NotSupported& n : d.not_supported) {
    out["not_supported"].push_back(cause_json(d, n.cause));
    out["not_supported"].back()["p_value"] = n.p_value;
    out["not_supported"].back()["why"] = n.why;
    add_place(d, n.cause, out["not_supported"].back());
  }
  out["cannot_tell"] = Json::array();
  for (const CannotTell& c : d.cannot_tell) {
    out["cannot_tell"].push_back(c.cause ? cause_json(d, *c.cause)
                                         : Json{{"effect", c.effect}, {"joint", 0}});
    out["cannot_tell"].back()["why"] = c.why;
    if (c.cause) add_place(d, *c.cause, out["cannot_tell"].back());
  }
  out["noise_floor"] = {{"relative_error", json_list(d.baseline.noise_floor)}};
  out["extended"] = error_pair(d.extended);
  out["next_experiment"] = next_json(d, next_command);
  out["warnings"] = d.baseline.warnings;
  out["remarks"] = d.remarks;
  if (!d.friction_remark.empty()) out["remarks"].insert(out["remarks"].begin(), d.friction_remark);
  out["friction"] = json_each(d.friction, [&](const JointNumber& n) -> Json {
    return {{"joint", n.joint.value + 1}, {"coordinate", d.extended.model->coordinates()[n.joint.value].name},
            {"effect", n.effect}, {"parameter", n.parameter}, {"unit", n.unit}, {"value", n.value}, {"std", n.deviation}};
  });
  out["excluded_intervals"] = json_each(d.excluded_intervals, [&](const ExcludedInterval& part) -> Json {
    return {{"file", part.source}, {"joint", part.joint ? part.joint->value + 1 : 0}, {"from", part.from}, {"to", part.to},
            {"why", part.why}};
  });
  out["data_quality"] = quality_json(d);
  out["settings"] = settings_json(d.baseline);
  out["seconds"] = d.seconds;
  return json_text(out);
}

}  // namespace veridyn
