#include "veridyn/report/motion_json.hpp"

#include <cmath>

#include "report/json/json_value.hpp"

namespace veridyn {
namespace {

// Root mean square of each column.
VectorXd rms(const MatrixXd& columns) {
  return (columns.colwise().squaredNorm() / static_cast<double>(columns.rows()))
      .cwiseSqrt()
      .transpose();
}

// Bounds, file's limits and Fourier coefficients of joint i, from 0.
Json bounds_json(const Excitation& e, Eigen::Index i) {
  const auto joint = static_cast<std::size_t>(i);
  return {{"name", e.joints[joint]},
          {"unit", e.units[joint]},
          {"position", {e.bounds.lower[i], e.bounds.upper[i]}},
          {"velocity", e.bounds.velocity[i]},
          {"acceleration", e.bounds.acceleration[i]},
          {"limits",
           {{"position", {e.limits.lower[i], e.limits.upper[i]}},
            {"velocity", e.limits.velocity[i]},
            {"acceleration", e.limits.acceleration[i]}}},
          {"a", json_list(e.trajectory.a().row(i).transpose())},
          {"b", json_list(e.trajectory.b().row(i).transpose())},
          {"q0", e.trajectory.q0()[i]}};
}

Json prediction_json(const Prediction& p) {
  Json out = {{"values", p.values},
              {"noise",
               {{"share_of_rms_torque", json_list(p.noise.deviation.cwiseQuotient(p.rms_torque))},
                {"std", json_list(p.noise.deviation)},
                {"source", p.noise.source},
                {"seconds_between_independent_samples", p.noise.seconds}}},
              {"rms_torque", json_list(p.rms_torque)},
              {"mean_relative_std", p.mean_relative},
              {"median_relative_std", p.median_relative}};
  out["base_parameters"] = json_each(p.parameters, [&](const PredictedParameter& one) -> Json {
    return {{"name", one.name}, {"unit", one.unit}, {"value", one.value}, {"std", one.deviation},
            {"relative_std", one.relative}};
  });
  return out;
}

Json essential_json(const EssentialParameters& p) {
  Json out = {{"share", p.share},
              {"count", p.count},
              {"condition_number", p.condition_number},
              {"plain_condition_number", p.plain_condition_number},
              {"range_condition_number", p.range_condition_number}};
  out["left_out"] = Json::array();
  for (const auto& [name, share] : p.non_essential)
    out["left_out"].push_back({{"parameter", name}, {"share", share}});
  return out;
}

const char* status_name(ExcitationStatus status) {
  if (status == ExcitationStatus::kLimitsNotMet) return "limits-not-met";
  return status == ExcitationStatus::kDone ? "done" : "rank-deficient";
}

}  // namespace

std::string to_json(const Excitation& e) {
  Json out = json_head("excite");
  out["robot"] = e.robot;
  out["status"] = status_name(e.status);
  out["solver"] = name_of(e.solver);
  out["converged"] = e.converged;
  out["interrupted"] = e.interrupted;
  out["seconds"] = e.seconds;
  out["criterion"] = name_of(e.criterion);
  out["condition_number"] = e.condition_number;
  out["plain_condition_number"] = e.plain_condition_number;
  out["range_condition_number"] = e.range_condition_number;
  out["orthogonal_condition_number"] = e.orthogonal_condition_number;
  out["condition_number_with_given"] = e.condition_number_with_given;
  out["start_condition_number"] = e.start_condition_number;
  out["log_determinant"] = e.log_determinant;
  out["base_parameters"] = e.base_parameters;
  out["base"] = e.base;
  if (e.essential) out["essential"] = essential_json(*e.essential);
  out["evaluations"] = e.evaluations;
  out["frequency"] = e.trajectory.frequency();
  out["harmonics"] = e.trajectory.harmonics();
  out["periods"] = e.periods;
  out["duration"] = e.periods * e.trajectory.period();
  out["slow_seconds"] = e.slow_seconds;
  if (e.discrimination) {
    const Discrimination& d = *e.discrimination;
    out["discrimination"] = {{"between", {d.first, d.second}},
                             {"left", {d.first_left, d.second_left}},
                             {"share_left", {d.first_share, d.second_share}},
                             {"bodies_known", d.bodies_known}};
  }
  out["weakest"] = Json::array();
  for (const auto& [name, part] : e.weakest)
    out["weakest"].push_back({{"parameter", name}, {"part", part}});
  if (e.prediction) out["prediction"] = prediction_json(*e.prediction);
  out["limit_share"] = e.limit_share > 0.0 ? Json(e.limit_share) : Json();
  out["used"] = Json::array();
  for (std::size_t i = 0; i < e.used.size(); ++i) {
    const UsedLimits& u = e.used[i];
    out["used"].push_back({{"joint", i + 1},
                           {"coordinate", e.joints[i]},
                           {"range", u.range},
                           {"velocity", u.velocity},
                           {"effort", u.effort},
                           {"held_by", u.held_by}});
  }
  out["warnings"] = e.warnings();
  out["remarks"] = Json::array();
  if (!e.friction_remark.empty()) out["remarks"].push_back(e.friction_remark);
  if (!e.touching.empty()) out["touching"] = e.touching;
  out["cautions"] = e.cautions;
  out["lowest_point"] = {{"z", e.lowest.z}, {"frame", e.lowest.frame}};
  out["speed"] = e.speed;
  out["margins"] = json_each(e.margins, [&](const LimitMargin& m) -> Json {
    return {{"limit", m.name}, {"unit", m.unit}, {"motion", {m.lowest, m.highest}}, {"bounds", {m.lower, m.upper}},
            {"margin", m.margin}};
  });
  out["joints"] = Json::array();
  for (Eigen::Index i = 0; i < e.trajectory.joints(); ++i)
    out["joints"].push_back(bounds_json(e, i));
  return json_text(out);
}

namespace {

Json recording_json(const SimulatedRecording& simulated) {
  Json out = json_head("simulate");
  out["robot"] = simulated.truth.name();
  out["rows"] = simulated.tau.rows();
  out["hidden"] = json_each(simulated.injected, [&](const InjectedEffect& injected) -> Json {
    return {{"effect", injected.effect}, {"place", injected.place},
            {"joint", injected.joint ? Json(injected.joint->value + 1) : Json()}, {"parameters", injected.values}};
  });
  out["rms_effort"] = json_list(rms(simulated.actual_tau));
  out["rms_effort_error"] = json_list(rms(simulated.tau - simulated.actual_tau));
  return out;
}

void add_run(const EngineRun& run, const PidGains& gains, const Model& arm, Json& out) {
  out["complete"] = run.complete();
  if (!run.complete()) {
    out["stopped"] = {{"time", run.stopped_at},
                      {"joint", run.joint ? Json(run.joint->value + 1) : Json()},
                      {"why", run.stop_reason(arm)}};
  }
  out["gains"] = {{"p", json_list(gains.p)}, {"i", json_list(gains.i)}, {"d", json_list(gains.d)}};
}

}  // namespace

std::string to_json(const SimulatedRecording& simulated) {
  return json_text(recording_json(simulated));
}

std::string to_json(const ControlledRecording& controlled, const MotionSamples& wanted) {
  Json out = recording_json(controlled.recording);
  add_run(controlled.run, controlled.gains, controlled.recording.truth, out);
  const MatrixXd& q = controlled.run.motion.q;
  out["largest_deviation"] =
      json_list((q - wanted.q.topRows(q.rows())).cwiseAbs().colwise().maxCoeff().transpose());
  out["left_out"] = controlled.left_out;
  return json_text(out);
}

std::string to_json(const Replay& replay, const Model& arm) {
  Json out = json_head("simulate");
  out["robot"] = arm.name();
  out["rows"] = replay.run.motion.rows();
  add_run(replay.run, replay.gains, arm, out);
  out["torque"] = {{"relative_error", json_list(replay.torque_error)},
                   {"prediction_relative_error", json_list(replay.inverse_error)}};
  out["motion"] = {{"rms_error", json_list(replay.motion_rms)},
                   {"max_error", json_list(replay.motion_max)}};
  return json_text(out);
}

std::string to_json(const Breakaway& found, const Model& arm) {
  Json out = json_head("simulate");
  out["robot"] = arm.name();
  const Coordinate& c = arm.coordinates()[found.joint.value];
  out["joint"] = found.joint.value + 1;
  out["coordinate"] = c.name;
  out["unit"] = c.prismatic ? "N" : "N m";
  out["sliding_speed"] = found.speed;
  out["ramps"] = json_each(found.events, [&](const BreakawayEvent& e) -> Json {
    return {{"rest_from", e.rest_from}, {"direction", e.direction}, {"recorded", {{"time", e.recorded_at},
            {"effort", e.recorded}}}, {"simulated", {{"time", e.simulated_at}, {"effort", e.simulated}}}};
  });
  out["forward"] = {{"recorded", found.recorded_forward},
                    {"simulated", found.simulated_forward}};
  out["backward"] = {{"recorded", found.recorded_backward},
                     {"simulated", found.simulated_backward}};
  return json_text(out);
}

}  // namespace veridyn
