#include <cmath>

#include "report/pages/page.hpp"
#include "report/pages/page_series.hpp"
#include "veridyn/report/watch_json.hpp"

namespace veridyn {
namespace {

// Torque and residual of one joint.
Json watched_joint(const WatchedSource& source, Eigen::Index joint, const std::string& unit) {
  const auto rows = static_cast<Eigen::Index>(source.states.size());
  VectorXd torque(rows), rest(rows), q(rows);
  for (Eigen::Index k = 0; k < rows; ++k) {
    torque[k] = source.states[k].torque[joint];
    rest[k] = source.states[k].residual[joint];
    const VectorXd& position = source.states[k].position;
    q[k] = joint < position.size() ? position[joint] : NAN;
  }
  const Eigen::Index step = curve_step(rows);
  return {{"q", packed_values(q, step)},
          {"plots",
           {plot_json("time", "Torque", unit,
                      {curve_json("measured", "recorded", packed_values(torque, step)),
                       curve_json("model with known changes", "model", packed_values(torque - rest, step))}),
            plot_json("error", "Not explained", unit,
                      Json::array({curve_json("not explained", "simulated", packed_values(rest, step))}))}}};
}

}  // namespace

std::string to_page(const std::vector<WatchedSource>& sources, const Model& arm,
                    const std::string& command, bool running) {
  std::string report;
  for (const WatchedSource& s : sources)
    for (const WatchEvent& e : s.events) report += s.source + ": " + e.sentence + "\n";
  Json series = series_of(command, arm);
  if (!sources.empty() && !sources.back().states.empty()) {
    const WatchedSource& source = sources.back();
    VectorXd time(source.states.size());
    for (std::size_t k = 0; k < source.states.size(); ++k)  // times of the first clock, so that they increase
      time[static_cast<Eigen::Index>(k)] = source.states[k].time + source.states[k].set_back;
    Json joints = Json::array();
    for (int j = 0; j < arm.joints(); ++j)
      joints.push_back(
          watched_joint(source, j, effort_unit(arm.coordinates()[j])));
    series["recordings"].push_back({{"source", source.source},
                                    {"role", "watched"},
                                    {"time", times(time, curve_step(time.size()))},
                                    {"joints", joints}});
  }
  return html_page(arm.name() + ": watched", to_json(sources, arm, running), series, report);
}

}  // namespace veridyn
