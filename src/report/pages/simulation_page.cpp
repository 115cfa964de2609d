#include "report/pages/simulation_page.hpp"

#include <cmath>

#include "recordings/breakaway_ramps.hpp"
#include "report/json/json_value.hpp"
#include "report/pages/page.hpp"
#include "report/pages/page_series.hpp"
#include "veridyn/report/motion_json.hpp"

namespace veridyn {
namespace {

constexpr Eigen::Index kRampSamples = 250;  // largest number of samples of one ramp
constexpr double kLeap = 5e-3;              // [rad], [m] step between rows that indicates a new start
constexpr double kMilli = 1e3;

std::string unit_of(const Coordinate& c) {
  return c.prismatic ? "mm" : "mrad";
}

// Replaces the values of excluded rows by NaN, so that no line is drawn there.
VectorXd with_gaps(VectorXd values, const std::vector<char>& use) {
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    if (use[k] == 0) values[k] = NAN;
  }
  return values;
}

Json plots_of(const Coordinate& c, const char* leader, const VectorXd& led, const VectorXd& q,
              Eigen::Index step) {
  return {plot_json("time", "Position", position_unit(c),
                    {curve_json(leader, "recorded", packed_values(led, step)),
                     curve_json("simulated", "simulated", packed_values(q, step))}),
          plot_json("error", std::string("Simulated minus ") + leader + " position", unit_of(c),
                    Json::array({curve_json("simulated", "simulated", packed_values(kMilli * (q - led), step))}))};
}

Json replay_joint(const Replay& r, const ReplayInput& input, const Coordinate& c, Eigen::Index i,
                  Eigen::Index step) {
  const VectorXd q = r.run.motion.q.col(i);
  const VectorXd recorded = r.recorded_tau.col(i);
  const auto curve = [&](const char* name, const char* style, const VectorXd& values) {
    return curve_json(name, style, packed_values(with_gaps(values, r.use), step));
  };
  Json plots = plots_of(c, "recorded", input.motion.q.col(i).head(q.size()), q, step);
  plots.push_back(plot_json("time", "Torque", effort_unit(c),
                            {curve("recorded", "recorded", recorded),
                             curve("model alone", "model", r.predicted_tau.col(i)),
                             curve("simulated", "simulated", r.simulated_tau.col(i))}));
  plots.push_back(plot_json("error", "Recorded minus simulated torque", effort_unit(c),
                            {curve("model alone", "model", recorded - r.predicted_tau.col(i)),
                             curve("simulated", "simulated", recorded - r.simulated_tau.col(i))}));
  return {{"q", packed_values(q, step)}, {"plots", plots}};
}

std::string run_page(const Model& arm, const SimulationRun& run, const VectorXd& time,
                     const std::string& title, const std::string& result, Json joints) {
  Json series = series_of(run.command, arm);
  series["recordings"].push_back({{"source", run.source},
                                  {"role", "replay"},
                                  {"time", times(time, curve_step(time.size()))},
                                  {"joints", std::move(joints)}});
  return html_page(arm.name() + title, result, series, run.report);
}

// Displacement over effort of one ramp, from its rest to the onset of sliding. Efforts are means
// over a tenth of a second, because noise of the current would hide the curve.
Json displacement_over_effort(const VectorXd& time, const VectorXd& q, const VectorXd& tau, double from,
                     double to) {
  Json points = Json::array();
  Eigen::Index first = 0;
  while (first < time.size() && time[first] - time[0] < from - 1e-9) ++first;
  Eigen::Index end = first;
  const auto leaps = [&](Eigen::Index k) { return k > first && std::abs(q[k] - q[k - 1]) > kLeap; };
  while (end < time.size() && time[end] - time[0] <= to && !leaps(end)) ++end;
  const Eigen::Index step = std::max<Eigen::Index>(1, (end - first) / kRampSamples);
  for (Eigen::Index k = first; k < end; k += step) {
    if (std::isfinite(q[k]))
      points.push_back({effort_at(time, tau, k), kMilli * (q[k] - q[first])});
  }
  return points;
}

}  // namespace

std::string to_page(const Replay& replay, const Model& arm, const ReplayInput& input,
                    const SimulationRun& run) {
  const Eigen::Index step = curve_step(replay.run.motion.rows());
  Json joints = Json::array();
  for (int i = 0; i < arm.joints(); ++i)
    joints.push_back(
        replay_joint(replay, input, arm.coordinates()[i], i, step));
  return run_page(arm, run, replay.run.motion.time, ": replayed", to_json(replay, arm), joints);
}

std::string to_page(const ControlledRecording& controlled, const MotionSamples& wanted,
                    const SimulationRun& run) {
  const Model& arm = controlled.recording.truth;
  const MatrixXd& q = controlled.run.motion.q;
  const Eigen::Index step = curve_step(q.rows());
  Json joints = Json::array();
  for (int i = 0; i < arm.joints(); ++i) {
    const Coordinate& c = arm.coordinates()[i];
    Json plots = plots_of(c, "wanted", wanted.q.col(i).head(q.rows()), q.col(i), step);
    plots.push_back(
        plot_json("time", "Torque", effort_unit(c),
                  {curve_json("as measured", "recorded", packed_values(controlled.recording.tau.col(i), step)),
                   curve_json("simulated", "simulated", packed_values(controlled.run.tau.col(i), step))}));
    joints.push_back({{"q", packed_values(q.col(i), step)}, {"plots", plots}});
  }
  return run_page(arm, run, controlled.run.motion.time, ": simulated", to_json(controlled, wanted), joints);
}

std::string to_page(const Breakaway& found, const Model& arm, const ReplayInput& input,
                    const SimulationRun& run) {
  const VectorXd tau = input.tau.col(found.joint.value);
  const VectorXd q = input.motion.q.col(found.joint.value);
  const VectorXd& time = input.motion.time;
  Json ramps = Json::array();
  for (const BreakawayEvent& e : found.events) {
    const double slid = std::isfinite(e.simulated) ? e.simulated_at : e.recorded_at;
    ramps.push_back(
        {{"recorded", displacement_over_effort(time, q, tau, e.rest_from, e.recorded_at)},
         {"simulated", displacement_over_effort(time, found.simulated_q, tau, e.rest_from, slid)}});
  }
  const Coordinate& c = arm.coordinates()[found.joint.value];
  Json series = series_of(run.command, arm);
  series["source"] = run.source;
  series["way_unit"] = unit_of(c);
  series["ramps"] = ramps;
  return html_page(arm.name() + ": breakaway", to_json(found, arm), series, run.report);
}

}  // namespace veridyn
