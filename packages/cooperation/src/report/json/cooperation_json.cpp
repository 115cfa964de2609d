#include "report/json/cooperation_json.hpp"

#include "veridyn/report/json/json_value.hpp"

namespace veridyn {
namespace {

Json requested_or_null(double asked) {
  return asked > 0.0 ? Json(asked) : Json();
}

Json member_json(const MemberFigures& m) {
  return {{"member", m.member},
          {"wanted_force", m.wanted},
          {"tracked", m.tracked},
          {"largest_error", m.largest_error},
          {"rms_error", m.rms_error},
          {"steady_error", m.steady_error},
          {"mean_error", m.mean_error},
          {"overshoot", m.overshoot},
          {"oscillation", m.oscillation},
          {"corrections", m.corrections},
          {"generated_energy", m.generated}};
}

Json phase_json(const PhaseFigures& p) {
  Json members = json_each(p.members, member_json);
  return {{"phase", p.phase},
          {"from", p.from},
          {"to", p.to},
          {"force_error",
           {{"reached", p.largest_force_error()}, {"asked", requested_or_null(p.asked_force_error)}}},
          {"steady_error",
           {{"reached", p.largest_steady_error()}, {"asked", requested_or_null(p.asked_steady_error)}}},
          {"body_error", p.body_error},
          {"asked_position_error", requested_or_null(p.asked_position_error)},
          {"met", p.met()},
          {"position_error", p.position_error},
          {"final_position_error", p.final_position_error},
          {"members", members}};
}

Json settings_json(const Scenario& s) {
  const ScenarioControl& c = s.control;
  Json arms = json_each(s.arms, [&](const ScenarioArm& arm) -> Json {
    return arm.name + ": " + arm.model + (arm.control == ArmControl::kPosition ? ", position" : ", impedance");
  });
  Json out = {{"arms", arms},
              {"leader", s.arms[s.master].name},
              // The leader once more under its former key, for programs that read it.
              {"master", s.arms[s.master].name},
              {"seed", s.seed},
              {"model_error", s.model_error},
              {"encoder", s.encoder},
              {"rate", c.rate},
              {"position_frequency", c.position_frequency},
              {"mass", json_list(c.mass)},
              {"damping", json_list(c.damping)},
              {"stiffness", json_list(c.stiffness)},
              {"friction", c.friction},
              {"adaptive_friction", c.adaptive_friction},
              {"force_cutoff", c.force_cutoff},
              {"motor_lag", c.motor_lag},
              {"torque_delay", c.torque_delay},
              {"guard", c.guard},
              {"observer", c.observer}};
  for (const ScenarioMember& m : s.members) {
    out["member " + m.name] = {m.stiffness, m.damping};
    out["sensor " + m.name] = {m.sensor.rate, m.sensor.delay, m.sensor.noise};
  }
  return out;
}

}  // namespace

std::string to_json(const ScenarioRun& run, const Scenario& scenario) {
  Json out = json_head("cooperate");
  out["scenario"] = run.name;
  out["source"] = scenario.source;
  out["engine"] = run.engine;
  out["engine_left_out"] = run.left_out;
  out["arms"] = run.arms;
  out["members"] = run.members;
  out["status"] = !run.complete()                            ? "stopped"
                  : run.state != CooperativeState::kTracking ? "held"
                                                             : "done";
  out["reason"] = !run.complete() ? describe(run.status) : describe(run.state);
  out["held_at"] = run.state != CooperativeState::kTracking ? Json(run.held_at) : Json();
  out["stopped_at"] = run.complete() ? Json() : Json(run.stopped_at);
  out["largest_force"] = run.largest_force;
  out["phases"] = json_each(run.phases, phase_json);
  out["met"] = run.met();
  out["asked_largest_force"] = requested_or_null(run.asked_largest_force);
  out["settings"] = settings_json(scenario);
  out["seconds"] = run.seconds;
  return json_text(out);
}

std::string to_json(const ScenarioSweepResult& sweep, const Scenario& scenario) {
  Json out = json_head("cooperate");
  out["scenario"] = sweep.name;
  out["source"] = scenario.source;
  out["engine"] = sweep.engine;
  out["stable_error"] = sweep.stable_error;
  out["stiffness"] = sweep.stiffness;
  out["delay"] = sweep.delay;
  out["rate"] = sweep.rate;
  out["points"] = json_each(sweep.points, [&](const SweepPoint& p) -> Json {
    return {{"stiffness", p.stiffness}, {"delay", p.delay}, {"rate", p.rate}, {"stable", p.stable},
            {"force_error", p.force_error}, {"steady_error", p.steady_error}, {"oscillation", p.oscillation},
            {"largest_force", p.largest_force}, {"generated_energy", p.generated}, {"ended", p.ended}};
  });
  out["stable_region"] = Json::array();
  for (std::size_t r = 0; r < sweep.rate.size(); ++r) {
    for (std::size_t s = 0; s < sweep.stiffness.size(); ++s) {
      const double up_to = sweep.stable_delay(s, r);
      out["stable_region"].push_back({{"rate", sweep.rate[r]},
                                      {"stiffness", sweep.stiffness[s]},
                                      {"delay_up_to", up_to < 0.0 ? Json() : Json(up_to)}});
    }
  }
  out["generated_energy_where_stable"] = sweep.largest_generated_where_stable();
  out["settings"] = settings_json(scenario);
  out["seconds"] = sweep.seconds;
  return json_text(out);
}

}  // namespace veridyn
