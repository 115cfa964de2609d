#include "report/pages/simulation_page.hpp"

#include <cmath>

#include "report/json/json_value.hpp"
#include "report/pages/page.hpp"
#include "report/pages/page_series.hpp"
#include "veridyn/report/motion_json.hpp"

namespace veridyn {
namespace {

constexpr Eigen::Index kRampSamples = 250;  // samples of one ramp
constexpr double kLeap = 5e-3;              // [rad], [m] between rows: a new start
constexpr double kMilli = 1e3;

// One curve of a plot, a row for every row of the run.
struct Curve {
  const char* name;
  const char* style;  // "recorded", "simulated" or "model"
  VectorXd values;
};

struct Plot {
  const char* kind;  // "time" or "error": high or low
  std::string title, unit;
  std::vector<Curve> curves;
};

Json thinned(const VectorXd& values, Eigen::Index step) {
  Json out = Json::array();
  for (Eigen::Index k = 0; k < values.size(); k += step) out.push_back(values[k]);
  return out;
}

Json joints_json(const Model& arm) {
  Json joints = Json::array();
  for (const Coordinate& c : arm.coordinates()) {
    joints.push_back({{"name", c.name},
                      {"unit", c.prismatic ? "m" : "rad"},
                      {"torque_unit", c.prismatic ? "N" : "N m"}});
  }
  return joints;
}

std::string series_of(const Model& arm, const SimulationRun& run, const VectorXd& time,
                      const std::vector<std::vector<Plot>>& plots) {
  const Eigen::Index step = std::max<Eigen::Index>(1, time.size() / kCurveSamples);
  std::string joints;
  for (const std::vector<Plot>& of_joint : plots) {
    std::string list;
    for (const Plot& plot : of_joint) {
      std::string curves;
      for (const Curve& c : plot.curves) {
        std::vector<double> values;
        for (Eigen::Index k = 0; k < c.values.size(); k += step) values.push_back(c.values[k]);
        curves += (curves.empty() ? "" : ",\n") + std::string("{\"name\": \"") + c.name +
                  "\", \"style\": \"" + c.style + "\", \"values\": " + number_list(values) + "}";
      }
      list += (list.empty() ? "" : ",\n") + std::string("{\"kind\": \"") + plot.kind +
              "\", \"title\": \"" + plot.title + "\", \"unit\": \"" + plot.unit +
              "\", \"curves\": [" + curves + "]}";
    }
    joints += (joints.empty() ? "" : ",\n") + std::string("{\"plots\": [") + list + "]}";
  }
  const Json head = {{"command", run.command}, {"joints", joints_json(arm)}, {"left_out", 0}};
  std::string out = head.dump(-1, ' ', false, Json::error_handler_t::replace);
  out.pop_back();
  Json recording = {{"source", run.source}, {"role", "replay"}, {"time", thinned(time, step)}};
  std::string one = recording.dump(-1, ' ', false, Json::error_handler_t::replace);
  one.pop_back();
  return out + ",\n\"recordings\": [" + one + ", \"joints\": [\n" + joints + "]}]}\n";
}

std::string unit_of(const Coordinate& c) {
  return c.prismatic ? "mm" : "mrad";
}

std::string effort_of(const Coordinate& c) {
  return c.prismatic ? "N" : "N m";
}

// NaN where a row is left out, so that no line is drawn there.
VectorXd in_use(VectorXd values, const std::vector<char>& use) {
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    if (use[static_cast<size_t>(k)] == 0) values[k] = NAN;
  }
  return values;
}

std::vector<Plot> replay_plots(const Replay& r, const ReplayInput& input, const Coordinate& c,
                               Eigen::Index i) {
  const Eigen::Index rows = r.run.motion.rows();
  const VectorXd q = r.run.motion.q.col(i);
  const VectorXd recorded_q = input.motion.q.col(i).head(rows);
  const VectorXd recorded = r.recorded_tau.col(i);
  return {{"time",
           "Position",
           c.prismatic ? "m" : "rad",
           {{"recorded", "recorded", recorded_q}, {"simulated", "simulated", q}}},
          {"error",
           "Simulated minus recorded position",
           unit_of(c),
           {{"simulated", "simulated", kMilli * (q - recorded_q)}}},
          {"time",
           "Torque",
           effort_of(c),
           {{"recorded", "recorded", in_use(recorded, r.use)},
            {"model alone", "model", in_use(r.predicted_tau.col(i), r.use)},
            {"simulated", "simulated", in_use(r.simulated_tau.col(i), r.use)}}},
          {"error",
           "Recorded minus simulated torque",
           effort_of(c),
           {{"model alone", "model", in_use(recorded - r.predicted_tau.col(i), r.use)},
            {"simulated", "simulated", in_use(recorded - r.simulated_tau.col(i), r.use)}}}};
}

// The way over the effort of one ramp, from its rest until it slid. Efforts are means
// of a tenth of a second, so that the noise of the current does not hide the curve.
Json way_over_effort(const VectorXd& time, const VectorXd& q, const VectorXd& tau, double from,
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
  std::vector<std::vector<Plot>> plots;
  for (int i = 0; i < arm.joints(); ++i)
    plots.push_back(replay_plots(replay, input, arm.coordinates()[static_cast<size_t>(i)], i));
  return html_page({arm.name() + ": replayed", "simulation.html", to_json(replay, arm),
                    series_of(arm, run, replay.run.motion.time, plots), run.report});
}

std::string to_page(const ControlledRecording& controlled, const MotionSamples& wanted,
                    const SimulationRun& run) {
  const Model& arm = controlled.recording.truth;
  const MatrixXd& q = controlled.run.motion.q;
  std::vector<std::vector<Plot>> plots;
  for (int i = 0; i < arm.joints(); ++i) {
    const Coordinate& c = arm.coordinates()[static_cast<size_t>(i)];
    const VectorXd asked = wanted.q.col(i).head(q.rows());
    plots.push_back({{"time",
                      "Position",
                      c.prismatic ? "m" : "rad",
                      {{"set point", "recorded", asked}, {"simulated", "simulated", q.col(i)}}},
                     {"error",
                      "Simulated position minus set point",
                      unit_of(c),
                      {{"simulated", "simulated", kMilli * (q.col(i) - asked)}}},
                     {"time",
                      "Torque",
                      effort_of(c),
                      {{"as measured", "recorded", controlled.recording.tau.col(i)},
                       {"simulated", "simulated", controlled.run.tau.col(i)}}}});
  }
  return html_page({arm.name() + ": simulated", "simulation.html", to_json(controlled, wanted),
                    series_of(arm, run, controlled.run.motion.time, plots), run.report});
}

std::string to_page(const Breakaway& found, const Model& arm, const ReplayInput& input,
                    const SimulationRun& run) {
  const VectorXd tau = input.tau.col(found.joint);
  const VectorXd q = input.motion.q.col(found.joint);
  const VectorXd& time = input.motion.time;
  Json ramps = Json::array();
  for (const BreakawayEvent& e : found.events) {
    const double slid = std::isfinite(e.simulated) ? e.simulated_at : e.recorded_at;
    ramps.push_back(
        {{"recorded", way_over_effort(time, q, tau, e.rest_from, e.recorded_at)},
         {"simulated", way_over_effort(time, found.simulated_q, tau, e.rest_from, slid)}});
  }
  const Coordinate& c = arm.coordinates()[static_cast<size_t>(found.joint)];
  const Json series = {{"command", run.command}, {"joints", joints_json(arm)},
                       {"left_out", 0},          {"recordings", Json::array()},
                       {"source", run.source},   {"way_unit", unit_of(c)},
                       {"ramps", ramps}};
  return html_page({arm.name() + ": breakaway", "simulation.html", to_json(found, arm),
                    series.dump(-1, ' ', false, Json::error_handler_t::replace), run.report});
}

}  // namespace veridyn
