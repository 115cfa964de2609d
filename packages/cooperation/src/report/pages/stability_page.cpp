#include "report/json/stability_json.hpp"

#include <fmt/format.h>

#include <cmath>

#include "report/pages/cooperation_files.hpp"
#include "veridyn/report/json/json_value.hpp"
#include "veridyn/report/pages/page.hpp"
#include "veridyn/report/pages/page_series.hpp"

namespace veridyn {
namespace {

Json flags_json(const std::vector<char>& values) {
  return json_each(values, [&](const char value) -> Json { return value != 0; });
}

Json point_json(const StabilityPoint& p) {
  return {{"phase", p.phase}, {"time", p.time}, {"radius", p.radius}, {"stable", p.stable}};
}

Json margins_json(const StabilityMargins& m) {
  return {{"gain", m.gain}, {"phase_deg", m.phase_deg}, {"delay_s", m.delay}};
}

std::string unit_of(const std::string& name) {
  for (const StabilityParameter& p : stability_parameters()) {
    if (p.name == name) return p.unit;
  }
  return "";
}

Json map_json(const StabilityMap& map) {
  const std::size_t columns = map.a_values.size();
  Json radius = Json::array(), stable = Json::array();
  for (std::size_t j = 0; j < map.b_values.size(); ++j) {
    Json radii = Json::array(), row = Json::array();
    for (std::size_t i = 0; i < columns; ++i) {
      radii.push_back(map.radius[i + columns * j]);
      row.push_back(map.stable[i + columns * j] != 0);
    }
    radius.push_back(radii);
    stable.push_back(row);
  }
  return {{"a", map.a.name},
          {"b", map.b.name},
          {"a_unit", unit_of(map.a.name)},
          {"b_unit", unit_of(map.b.name)},
          {"a_values", map.a_values},
          {"b_values", map.b_values},
          {"stable", stable},   // rows by b, columns by a
          {"radius", radius},
          {"seconds", map.seconds}};
}

Json law_json(const ForceLaw& law) {
  return {{"gain", law.gain},
          {"proportional", law.proportional},
          {"damping", law.damping},
          {"feed_forward", law.feed_forward}};
}

Json settings(const Scenario& s) {
  Json out = Json::object();
  for (const StabilityParameter& p : stability_parameters())
    out[p.name + (p.unit.empty() || p.unit == "1" ? "" : " [" + p.unit + "]")] =
        parameter(s, p.name);
  return out;
}

Json study_json(const StabilityStudy& study) {
  const StabilityAnalysis& a = study.analysis;
  Json out = json_head("stability");
  out["scenario"] = a.name;
  out["source"] = study.scenario.source;
  out["stable"] = a.stable;
  out["eigenvalues"] = a.eigenvalues;
  out["eigenvalue_cycles"] = a.cycles;
  out["period"] = a.period;
  out["replaced_rates"] = Json::array();
  for (const ReplacedRate& r : a.replaced_rates)
    out["replaced_rates"].push_back({{"sensor", r.sensor}, {"rate", r.rate}, {"analysed", r.analysed}});
  out["radius"] = a.radius;
  out["worst"] = point_json(a.worst);
  out["margins"] = margins_json(a.margins);
  const bool coupled = std::isfinite(a.largest_stable_stiffness);
  out["largest_stable_stiffness"] = coupled ? Json(a.largest_stable_stiffness) : Json();
  out["smallest_stable_stiffness"] = coupled ? Json(a.smallest_stable_stiffness) : Json();
  out["stiffness_bounded"] = a.stiffness_bounded;
  out["linear_stable_stiffness"] = coupled ? Json(a.linear_stable_stiffness) : Json();
  out["simulated_runs"] = a.simulated_runs;
  out["points"] = json_each(a.points, point_json);
  out["deadbands"] = json_each(a.deadbands, [&](const DeadbandSwing& d) -> Json {
    return {{"member", d.member}, {"largest_gain", d.largest_gain}, {"critical_gain", d.critical_gain},
            {"describing_function_swings", d.describing_function_swings}, {"swings", d.swings}, {"amplitude", d.amplitude},
            {"frequency", d.frequency}};
  });
  if (study.map) out["map"] = map_json(*study.map);
  if (study.locus) {
    out["locus"] = {{"parameter", study.locus->range.name},
                    {"values", study.locus->values},
                    {"stable", flags_json(study.locus->stable)},
                    {"eigenvalues", study.locus->eigenvalues}};
  }
  if (study.recommendation) {
    const GainRecommendation& r = *study.recommendation;
    out["recommendation"] = {{"phase_deg", r.phase_deg},
                             {"found", r.found},
                             {"crossover", r.crossover},
                             {"impedance_damping", r.impedance_damping},
                             {"law", law_json(r.law)},
                             {"radius", r.radius},
                             {"margins", margins_json(r.margins)},
                             {"tried", r.tried}};
  }
  if (study.bounds) {
    const StabilityBounds& b = *study.bounds;
    out["bounds"] = {{"samples", b.samples},
                     {"share", b.share},
                     {"unstable", b.unstable},
                     {"worst_radius", b.worst_radius},
                     {"factor", b.factor},
                     {"factor_bounded", b.factor_bounded},
                     {"guaranteed_mass_error", b.guaranteed_mass_error}};
  }
  out["settings"] = settings(study.scenario);
  out["seconds"] = a.seconds;
  return out;
}

}  // namespace

std::string to_json(const StabilityStudy& study) {
  return json_text(study_json(study));
}

std::string to_page(const StabilityStudy& study, const std::string& command) {
  Json series = series_of(command);
  if (study.steps) {
    Json forces = Json::array();
    for (std::size_t k = 0; k < study.steps->members.size(); ++k)
      forces.push_back({{"member", study.steps->members[k]}, {"force", study.steps->force[k]}});
    series["steps"] = {{"time", study.steps->time}, {"forces", forces}};
  }
  return html_page(study.analysis.name + ": stability", to_json(study), series, study.report(),
                   cooperation_file("script.js"));
}

}  // namespace veridyn
