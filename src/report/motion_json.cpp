#include "veridyn/report/motion_json.hpp"

#include <cmath>

#include "json_value.hpp"

namespace veridyn {
namespace {

VectorXd rms(const MatrixXd& columns) {
  return (columns.colwise().squaredNorm() / static_cast<double>(columns.rows()))
      .cwiseSqrt()
      .transpose();
}

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
  out["evaluations"] = e.evaluations;
  out["frequency"] = e.trajectory.frequency();
  out["harmonics"] = e.trajectory.harmonics();
  out["periods"] = e.periods;
  out["duration"] = e.periods * e.trajectory.period();
  if (e.discrimination) {
    const Discrimination& d = *e.discrimination;
    out["discrimination"] = {{"between", {d.first, d.second}},
                             {"left", {d.first_left, d.second_left}},
                             {"share_left", {d.first_share, d.second_share}},
                             {"bodies_known", d.bodies_known}};
  }
  out["margins"] = Json::array();
  for (const LimitMargin& m : e.margins) {
    out["margins"].push_back({{"limit", m.name},
                              {"unit", m.unit},
                              {"motion", {m.lowest, m.highest}},
                              {"bounds", {m.lower, m.upper}},
                              {"margin", m.margin}});
  }
  out["joints"] = Json::array();
  for (Eigen::Index i = 0; i < e.trajectory.joints(); ++i)
    out["joints"].push_back(bounds_json(e, i));
  return written(out);
}

std::string to_json(const SimulatedRecording& simulated) {
  Json out = json_head("simulate");
  out["robot"] = simulated.truth.name();
  out["rows"] = simulated.tau.rows();
  out["hidden"] = Json::array();
  for (const PlantedEffect& planted : simulated.planted) {
    out["hidden"].push_back({{"effect", planted.effect},
                             {"place", planted.place},
                             {"joint", planted.joint > 0 ? Json(planted.joint) : Json()},
                             {"parameters", planted.values}});
  }
  out["rms_effort"] = json_list(rms(simulated.actual_tau));
  out["rms_effort_error"] = json_list(rms(simulated.tau - simulated.actual_tau));
  return written(out);
}

}  // namespace veridyn
