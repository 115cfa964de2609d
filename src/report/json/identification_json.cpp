#include <cmath>

#include "veridyn/identification/verdict.hpp"
#include "report/json/json_value.hpp"
#include "report/json/settings_json.hpp"
#include "veridyn/report/json.hpp"
#include "veridyn/report/setting_names.hpp"

namespace veridyn {
namespace {

Json standard_json(const Identification& id) {
  Json out = Json::array();
  if (!id.model) return out;
  const std::vector<StandardParameter> parameters = standard_parameters(*id.model);
  for (std::size_t j = 0; j < parameters.size(); ++j) {
    const auto at = static_cast<Eigen::Index>(j);
    out.push_back({{"name", parameters[j].name},
                   {"value", id.parameters[at]},
                   {"std", at < id.parameter_deviations.size() ? Json(id.parameter_deviations[at]) : Json()},
                   {"unit", parameters[j].unit}});
  }
  return out;
}

Json errors_json(const PredictionError& total, const PredictionError& repaired,
                 const PredictionError& without_excluded,
                 const std::vector<RecordingError>& recordings) {
  if (recordings.empty()) return nullptr;
  Json out = error_json(total, repaired, without_excluded);
  out["recordings"] = Json::array();
  for (const RecordingError& recording : recordings) {
    Json one = error_json(recording.error, recording.repaired, recording.without_excluded);
    one["source"] = recording.source;
    one["noise_floor"] = json_list(recording.noise_floor);
    if (recording.filled.count > 0) one["filled_rows"] = filled_json(recording);
    out["recordings"].push_back(std::move(one));
  }
  return out;
}

Json drive_gains_json(const std::vector<DriveGain>& joints) {
  Json out = Json::array();
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const DriveGain& g = joints[j];
    out.push_back({{"joint", j + 1},
                   {"coordinate", g.coordinate},
                   {"value", g.value},
                   {"std", g.deviation},
                   {"ci95", {g.low, g.high}},
                   {"unit", g.unit},
                   {"identifiable", g.identifiable},
                   {"why", g.identifiable ? Json() : Json(g.reason)},
                   {"share", g.share}});
  }
  return out;
}

Json known_masses_json(const std::vector<MountedLoad>& loads) {
  return json_each(loads, [&](const MountedLoad& load) -> Json {
    return {{"mass", load.known.mass}, {"frame", load.known.frame}, {"recordings", load.known.recordings},
            {"identified", load.identified}, {"centre", load.centre ? json_list(*load.centre) : Json()},
            {"centre_std", load.centre ? json_list(load.centre_deviation) : Json()}};
  });
}

Json identification_verdict_json(const IdentificationVerdict& verdict) {
  Json joints = Json::array();
  for (size_t i = 0; i < verdict.joints.size(); ++i) {
    const IdentifiedJoint& j = verdict.joints[i];
    joints.push_back({{"joint", i + 1},
                      {"coordinate", j.joint},
                      {"state", name_of(j.state)},
                      {"error", j.error},
                      {"error_percent", 100.0 * j.error},
                      {"floor", j.floor},
                      {"times_floor", j.error / j.floor},
                      {"range", j.range},
                      {"velocity", j.speed}});
  }
  return {{"sentence", verdict.sentence}, {"held_out", verdict.held_out}, {"joints", joints}};
}

Json endogeneity_json(const Identification& id) {
  if (id.endogeneity.empty()) return nullptr;
  Json out = Json::array();
  for (size_t i = 0; i < id.endogeneity.size(); ++i) {
    const EndogeneityTest& t = id.endogeneity[i];
    out.push_back({{"joint", i + 1},
                   {"coordinate", id.model->coordinates()[i].name},
                   {"statistic", t.statistic},
                   {"numerator_freedom", t.numerator_freedom},
                   {"denominator_freedom", t.denominator_freedom},
                   {"p_value", t.p_value}});
  }
  return out;
}

}  // namespace

std::string to_json(const Identification& id) {
  Json out = json_head("identify");
  out["robot"] = id.robot;
  out["method"] = name_of(id.method);
  out["status"] = name_of(id.status);
  out["reason"] = id.reason;
  out["verdict"] = identification_verdict_json(verdict_of(id));
  out["warnings"] = id.warnings;
  out["remarks"] = id.remarks;
  out["rows"] = id.rows;
  out["base_parameters"] = base_json(id.base);
  out["condition_number"] = id.condition_number_scaled;
  out["condition_number_unscaled"] = id.condition_number;
  out["rank_gap"] = id.rank_gap;
  out["feasible"] = id.feasible;
  out["objective"] = id.objective;
  out["unconstrained_objective"] = id.unconstrained_objective;
  out["duality_gap"] = id.duality_gap;
  out["certified"] = id.certified;
  out["effective_samples"] = id.effective_samples;
  out["active_constraints"] = id.active_constraints;
  out["durbin_wu_hausman"] = endogeneity_json(id);
  out["train"] =
      errors_json(id.train_error, id.train_repaired, id.train_without_excluded, id.train);
  out["test"] = errors_json(id.test_error, id.test_repaired, id.test_without_excluded, id.test);
  out["noise_floor"] = {{"relative_error", json_list(id.noise_floor)},
                        {"source", id.noise_floor.size() > 0 ? "repeats" : "none"}};
  out["left_out_recordings"] = unused_json(id.unusable_recordings);
  if (id.drive_gains) {
    out["drive_gains"] = drive_gains_json(id.drive_gains->joints);
    out["known_masses"] = known_masses_json(id.drive_gains->loads);
  }
  out["seconds"] = {{"read", id.seconds.read},
                    {"compress", id.seconds.compress},
                    {"solve", id.seconds.solve},
                    {"validate", id.seconds.validate}};
  out["standard_parameters"] = standard_json(id);
  out["settings"] = settings_json(id);
  return json_text(out);
}

}  // namespace veridyn
