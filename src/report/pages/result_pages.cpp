#include <algorithm>
#include <cmath>

#include "report/pages/page.hpp"
#include "report/pages/page_series.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/identification/parameters_text.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/regressor/standard_parameters.hpp"
#include "veridyn/report/comparison_json.hpp"
#include "veridyn/report/diagnosis_json.hpp"
#include "veridyn/report/json.hpp"
#include "veridyn/report/motion_json.hpp"
#include "veridyn/report/pages.hpp"
#include "veridyn/report/payload_json.hpp"

namespace veridyn {
namespace {

// The signal that a cause depends on, as findings name it: "q3", "dq1", "ddq2", "tau1", "t".
std::string signal_of(const Finding& f) {
  const std::string joint = std::to_string(f.joint ? f.joint->value + 1 : 1);
  const std::string effect = effect_of(f.cause);
  if (!has_effect(effect)) return "q" + joint;
  const EffectTraits traits = find_effect(effect).traits();
  if (traits.depends_on_time) return "t";
  const bool of_torque = traits.role == EffectRole::kSensor && traits.uses_source;
  if (of_torque && f.from) return "tau" + std::to_string(f.from->value + 1);
  if (traits.depends_on_position || traits.holds_at_rest) return "q" + joint;
  if (traits.role == EffectRole::kInertia || traits.uses_acceleration) return "ddq" + joint;
  if (traits.uses_load) return "tau" + joint;
  return traits.uses_velocity || !traits.uses_position ? "dq" + joint : "q" + joint;
}

void plot_errors(const char* role, const std::vector<RecordingError>& model,
                 const std::vector<RecordingError>* extended, std::vector<PlottedRecording>& out) {
  for (std::size_t k = 0; k < model.size(); ++k) {
    const bool both = extended != nullptr && k < extended->size();
    out.push_back({role, &model[k], both ? &(*extended)[k] : nullptr});
  }
}

// Value of each base parameter in the robot file; null where the file lacks a value; no entries without inertial values.
Json values_in_file(const Identification& id, const Model& robot) {
  Json out = Json::array();
  const auto& identified = id.model->description().identified;
  if (!identified || !robot.inertial_values()) return out;
  std::map<std::string, double> known;
  for (const StandardParameter& p : standard_parameters(robot))
    if (!p.effect || !robot.effects()[*p.effect].values.empty())
      known[p.name] = p.value;
  for (const IdentifiedParameter& one : identified->parameters) {
    double value = 0.0;
    bool all = true;
    for (const auto& [name, coefficient] : one.combination) {
      const auto at = known.find(name);
      all = all && at != known.end();
      value += all ? coefficient * at->second : 0.0;
    }
    out.push_back({{"name", one.name}, {"value", all ? Json(value) : Json()}});
  }
  return out;
}

constexpr std::size_t kWorst = 10;  // number of parameters whose correlations are shown

// The parameters with the largest relative standard deviations and their correlations, {names,
// relative, matrix}; empty where no covariance is known.
Json correlations_of_worst(const Identification& id) {
  const auto& identified = id.model->description().identified;
  if (!identified || !identified->has_scatter()) return Json::object();
  std::vector<const IdentifiedParameter*> worst;
  for (const IdentifiedParameter& one : identified->parameters)
    if (one.value != 0.0 && one.scatter.size() > 0 && one.scatter.norm() > 0.0) worst.push_back(&one);
  const auto relative = [](const IdentifiedParameter* p) { return p->scatter.norm() / std::abs(p->value); };
  std::stable_sort(worst.begin(), worst.end(), [&](const auto* a, const auto* b) { return relative(a) > relative(b); });
  if (worst.size() > kWorst) worst.resize(kWorst);
  Json out = {{"names", Json::array()}, {"relative", Json::array()}, {"matrix", Json::array()}};
  for (const IdentifiedParameter* a : worst) {
    out["names"].push_back(a->name);
    out["relative"].push_back(relative(a));
    Json row = Json::array();
    for (const IdentifiedParameter* b : worst)
      row.push_back(std::round(1e3 * a->scatter.dot(b->scatter) / (a->scatter.norm() * b->scatter.norm())) / 1e3);
    out["matrix"].push_back(std::move(row));
  }
  return out;
}

}  // namespace

std::string to_page(const Identification& id, const std::string& command, const Model* robot) {
  require(id.model.has_value(), "to_page: found an identification without a model: ", id.reason,
          ".");
  Json series = series_of(command, *id.model);
  std::vector<PlottedRecording> recordings;
  plot_errors("held out", id.test, nullptr, recordings);
  plot_errors("training", id.train, nullptr, recordings);
  add_recordings(series, recordings);
  add_friction(series, id);
  series["correlations"] = correlations_of_worst(id);
  if (robot != nullptr) series["file"] = values_in_file(id, *robot);
  series["arms"].clear();  // the page draws no arm
  return html_page(id.robot + ": identified", to_json(id), series, id.report() + parameters_text(id));
}

std::string to_page(const Diagnosis& d, const std::string& command,
                    const std::string& next_command) {
  require(d.baseline.model.has_value(),
          "to_page: found a diagnosis without a model: ", d.baseline.reason, ".");
  Json series = series_of(command, *d.baseline.model);
  std::vector<PlottedRecording> recordings;
  const bool found = !d.findings.empty();
  plot_errors("held out", d.baseline.test, found ? &d.extended.test : nullptr, recordings);
  plot_errors("training", d.baseline.train, found ? &d.extended.train : nullptr, recordings);
  add_recordings(series, recordings);
  add_friction(series, found && d.extended.model ? d.extended : d.baseline);
  series["causes"] = json_each(d.findings, signal_of);
  return html_page(d.baseline.robot + ": what the model lacks", to_json(d, next_command), series,
                   d.report(next_command));
}

std::string to_page(const Excitation& e, const std::string& command, const Model* arm) {
  require(e.motion.rows() > 1, "to_page: found an excitation without a motion.");
  const MotionSamples& m = e.motion;
  const Eigen::Index step = curve_step(m.rows());
  Json series = series_of(command);
  if (arm != nullptr) series["arms"].push_back(arm_json(*arm));
  Json joints = Json::array();
  for (Eigen::Index i = 0; i < m.joints(); ++i) {
    const auto joint = static_cast<std::size_t>(i);
    series["joints"].push_back({{"name", e.joints[joint]},
                                {"unit", e.units[joint]},
                                {"torque_unit", e.units[joint] == "m" ? "N" : "N m"}});
    joints.push_back({{"q", packed_values(m.q.col(i), step)},
                      {"dq", packed_values(m.dq.col(i), step)},
                      {"ddq", packed_values(m.ddq.col(i), step)},
                      {"limits",
                       {{"q", {e.limits.lower[i], e.limits.upper[i]}},
                        {"dq", {-e.limits.velocity[i], e.limits.velocity[i]}},
                        {"ddq", {-e.limits.acceleration[i], e.limits.acceleration[i]}}}}});
  }
  series["recordings"].push_back(
      {{"source", ""}, {"role", "motion"}, {"time", times(m.time, step)}, {"joints", joints}});
  return html_page(e.robot + ": a motion to record", to_json(e), series, e.report());
}

std::string result_page(const std::string& title, const std::string& result,
                        const std::string& report, const std::string& command, const Model* arm) {
  return html_page(title, result, arm != nullptr ? series_of(command, *arm) : series_of(command), report);
}

std::string to_page(const RobotInfo& info, const std::string& command) {
  return result_page(info.arm.name() + ": the robot", to_json(info), info.report(), command, &info.arm);
}

std::string to_page(const std::vector<RecordingQuality>& recordings, const std::string& command) {
  std::string report;
  for (const RecordingQuality& one : recordings) report += one.report();
  return result_page("Quality of recordings", to_json(recordings), report, command);
}

std::string to_page(const PayloadReport& report, const std::string& command) {
  return result_page(report.robot + ": payload", to_json(report), report.report(), command);
}

std::string to_page(const FrictionStudy& study, const std::string& command, const Model* arm) {
  const Model* joints = arm == nullptr && study.fitted.model ? &*study.fitted.model : arm;
  Json series = joints != nullptr ? series_of(command, *joints) : series_of(command);
  series["arms"] = Json::array();  // the page draws no arm, since nothing moves
  return html_page(study.robot + ": friction", to_json(study), series, study.report());
}

std::string to_page(const ModelComparison& found, const std::string& command) {
  return result_page(found.robot + ": compared", to_json(found), found.report(), command);
}

std::string to_page(const Fleet& fleet, const std::string& command) {
  return result_page(fleet.robot + ": fleet", to_json(fleet), fleet.report(), command);
}

}  // namespace veridyn
