#include <algorithm>

#include "report/json/json_value.hpp"
#include "report/pages/page.hpp"
#include "report/pages/page_series.hpp"
#include "veridyn/report/watch_json.hpp"

namespace veridyn {
namespace {

std::string curve(const char* name, const char* style, const std::vector<double>& values) {
  return std::string("{\"name\": \"") + name + "\", \"style\": \"" + style +
         "\", \"values\": " + number_list(values) + "}";
}

// Torque, and what the model leaves of it, joint by joint.
std::string plots_of(const WatchedSource& source, size_t step, Eigen::Index joint,
                     const std::string& unit) {
  std::vector<double> torque, modelled, rest;
  for (size_t k = 0; k < source.states.size(); k += step) {
    const WatchState& s = source.states[k];
    torque.push_back(s.torque[joint]);
    modelled.push_back(s.torque[joint] - s.residual[joint]);
    rest.push_back(s.residual[joint]);
  }
  return "{\"plots\": [{\"kind\": \"time\", \"title\": \"Torque\", \"unit\": \"" + unit +
         "\", \"curves\": [" + curve("measured", "recorded", torque) + ", " +
         curve("model with known changes", "model", modelled) +
         "]}, {\"kind\": \"error\", \"title\": \"Not explained\", \"unit\": \"" + unit +
         "\", \"curves\": [" + curve("not explained", "simulated", rest) + "]}]}";
}

std::string series_of(const WatchedSource& source, const Model& arm, const std::string& command) {
  const size_t step = std::max<size_t>(1, source.states.size() / static_cast<size_t>(kCurveSamples));
  Json joints = Json::array();
  std::string plots;
  for (int j = 0; j < arm.joints(); ++j) {
    const Coordinate& c = arm.coordinates()[static_cast<size_t>(j)];
    joints.push_back({{"name", c.name}, {"unit", position_unit(c)}, {"torque_unit", effort_unit(c)}});
    plots += (j == 0 ? "" : ",\n") + plots_of(source, step, j, effort_unit(c));
  }
  std::vector<double> time;
  for (size_t k = 0; k < source.states.size(); k += step) time.push_back(source.states[k].time);
  const Json head = {{"command", command}, {"joints", joints}, {"left_out", 0}};
  std::string out = head.dump(-1, ' ', false, Json::error_handler_t::replace);
  out.pop_back();
  if (time.empty()) return out + ", \"recordings\": []}\n";
  const Json name = {{"source", source.source}};
  std::string one = name.dump(-1, ' ', false, Json::error_handler_t::replace);
  one.pop_back();
  return out + ",\n\"recordings\": [" + one + ", \"role\": \"watched\", \"time\": " +
         number_list(time) + ", \"joints\": [\n" + plots + "]}]}\n";
}

}  // namespace

std::string to_page(const std::vector<WatchedSource>& sources, const Model& arm,
                    const std::string& command, bool running) {
  std::string report;
  for (const WatchedSource& s : sources)
    for (const WatchEvent& e : s.events) report += s.source + ": " + e.sentence + "\n";
  const WatchedSource none;
  return html_page({arm.name() + ": watched", "watch.html", to_json(sources, arm, running),
                    series_of(sources.empty() ? none : sources.back(), arm, command), report});
}

}  // namespace veridyn
