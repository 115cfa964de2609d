#include "report/json/cooperation_json.hpp"
#include "report/pages/cooperation_files.hpp"
#include "veridyn/report/pages/page.hpp"
#include "veridyn/report/pages/page_series.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

Json member_plots(const ScenarioRun& run, std::size_t k, Eigen::Index step) {
  const MemberTrace& m = run.member[k];
  const VectorXd off = m.force - m.wanted;
  return {plot_json("time", "Force in " + run.members[k], "N",
                    {curve_json("measured", "measured", packed_values(m.measured, step)),
                     curve_json("wanted", "wanted", packed_values(m.wanted, step)),
                     curve_json("true", "simulated", packed_values(m.force, step))}),
          plot_json("error", "", "N",
                    Json::array({curve_json("true minus wanted", "simulated", packed_values(off, step))})),
          plot_json("error", "Correction x_f of " + run.members[k], "mm",
                    Json::array({curve_json("x_f", "simulated", packed_values(1e3 * m.x_f, step))}))};
}

Json tip_plots(const ScenarioRun& run, std::size_t k, Eigen::Index step) {
  const ArmTrace& a = run.arm[k];
  const char* const axes[] = {"x", "y", "z"};
  Json way = Json::array(), off = Json::array();
  for (const bool wanted : {true, false}) {
    for (int c = 0; c < 3; ++c) {
      const VectorXd values = 1e3 * ((wanted ? a.motion : a.tip).col(c).array() - a.motion(0, c));
      const std::string name = std::string(axes[c]) + (wanted ? " wanted" : "");
      way.push_back(curve_json(name, name, packed_values(values, step)));
    }
  }
  for (int c = 0; c < 3; ++c) {
    const VectorXd values = 1e3 * (a.tip.col(c) - a.motion.col(c));
    off.push_back(curve_json(std::string(axes[c]) + " off its way", axes[c], packed_values(values, step)));
  }
  return {plot_json("time", "Tip of " + run.arms[k] + " since the start", "mm", way),
          plot_json("error", "", "mm", off)};
}

Json columns(const MatrixXd& of, Eigen::Index step) {
  Json out = Json::array();
  for (Eigen::Index c = 0; c < of.cols(); ++c) out.push_back(packed_values(of.col(c), step));
  return out;
}

Eigen::Isometry3d base_of(const ScenarioArm& arm) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translate(arm.position);
  T.rotate(Eigen::AngleAxisd(arm.turn.z(), Eigen::Vector3d::UnitZ()) *
           Eigen::AngleAxisd(arm.turn.y(), Eigen::Vector3d::UnitY()) *
           Eigen::AngleAxisd(arm.turn.x(), Eigen::Vector3d::UnitX()));
  return T;
}

// Connections that exert forces: members between tips, then walls, in the order of the run's
// traces.
Json held_json(const ScenarioRun& run, const Scenario& scenario, Eigen::Index step) {
  Json out = Json::array();
  for (std::size_t k = 0; k < run.member.size(); ++k) {
    Json one = {{"force", packed_values(run.member[k].force, step)}};
    const std::size_t wall = k - std::min(k, scenario.members.size());
    if (k < scenario.members.size()) {
      one["from"] = scenario.members[k].from;
      one["to"] = scenario.members[k].to;
    } else if (wall < scenario.walls.size()) {
      one["from"] = scenario.walls[wall].arm;
      one["to"] = -1;
      one["normal"] = json_list(scenario.walls[wall].normal);
    } else {
      continue;
    }
    out.push_back(one);
  }
  return out;
}

Json bodies_json(const ScenarioRun& run, const Scenario& scenario, Eigen::Index step) {
  Json out = Json::array();
  for (std::size_t k = 0; k < run.body.size() && k < scenario.bodies.size(); ++k) {
    Json arms = json_each(scenario.bodies[k].grasps, [&](const ScenarioBody::Grasp& grasp) -> Json { return grasp.arm; });
    out.push_back({{"at", columns(run.body[k].position, step)}, {"arms", arms}});
  }
  return out;
}

void add_arms(const ScenarioRun& run, const Scenario& scenario, Eigen::Index step, Json& series,
              Json& recording) {
  for (std::size_t k = 0; k < scenario.arms.size() && k < run.arm.size(); ++k) {
    if (run.arm[k].q.rows() == 0 || run.arm[k].tip.rows() == 0) return series["arms"].clear();
    const Model arm = read_model(scenario.arms[k].model);
    series["arms"].push_back(arm_json(arm, base_of(scenario.arms[k])));
    if (const auto tip = arm.find_frame(scenario.arms[k].frame)) series["arms"].back()["tip"] = tip->value;
    for (const Json& column : columns(run.arm[k].q, step)) recording["q"].push_back(column);
    recording["tips"].push_back(columns(run.arm[k].tip, step));
  }
  recording["members"] = held_json(run, scenario, step);
  recording["bodies"] = bodies_json(run, scenario, step);
}

}  // namespace

std::string to_page(const ScenarioRun& run, const Scenario& scenario, const std::string& command) {
  const Eigen::Index step = curve_step(run.time.size());
  Json series = series_of(command);
  Json plots = Json::array();
  const auto add = [&plots](const Json& list) { plots.insert(plots.end(), list.begin(), list.end()); };
  for (std::size_t k = 0; k < run.member.size(); ++k) add(member_plots(run, k, step));
  for (std::size_t k = 0; k < run.arm.size(); ++k)
    if (run.arm[k].tip.rows() > 0) add(tip_plots(run, k, step));
  Json recording = {{"source", scenario.source}, {"role", "run"}, {"time", times(run.time, step)},
                    {"plots", plots},            {"q", Json::array()}, {"tips", Json::array()}};
  add_arms(run, scenario, step, series, recording);
  series["recordings"].push_back(recording);
  return html_page(run.name + ": cooperation", to_json(run, scenario), series, run.report(),
                   cooperation_file("script.js"));
}

std::string to_page(const ScenarioSweepResult& sweep, const Scenario& scenario,
                    const std::string& command) {
  return html_page(sweep.name + ": stable region", to_json(sweep, scenario), series_of(command),
                   sweep.report(), cooperation_file("script.js"));
}

}  // namespace veridyn
