#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/json/json_value.hpp"
#include "report/pages/page.hpp"
#include "report/pages/page_series.hpp"
#include "report/json/cooperation_json.hpp"

namespace veridyn {
namespace {

std::string numbers(const VectorXd& values, Eigen::Index step, int digits) {
  std::string out = "[";
  for (Eigen::Index k = 0; k < values.size(); k += step) {
    if (out.size() > 1) out += ',';
    out += std::isfinite(values[k]) ? fmt::format("{:.{}f}", values[k], digits) : "null";
  }
  return out + "]";
}

std::string quoted(const std::string& word) {
  return Json(word).dump(-1, ' ', false, Json::error_handler_t::replace);
}

// One plot: its title, unit and curves {name, colour, width, values}.
class Plot {
 public:
  Plot(const std::string& title, const char* kind, const char* unit, Eigen::Index step)
      : head_(fmt::format("{{\"title\": {}, \"kind\": {}, \"unit\": {}, \"curves\": [",
                          quoted(title), quoted(kind), quoted(unit))),
        step_(step) {}

  Plot& curve(const char* name, const char* colour, double width, const VectorXd& values) {
    head_ += fmt::format("{}\n{{\"name\": {}, \"colour\": {}, \"width\": {}, \"values\": {}}}",
                         first_ ? "" : ",", quoted(name), quoted(colour), width,
                         numbers(values, step_, 4));
    first_ = false;
    return *this;
  }

  std::string text() const { return head_ + "]}"; }

 private:
  std::string head_;
  Eigen::Index step_;
  bool first_ = true;
};

std::string plots_of(const ScenarioRun& run) {
  const Eigen::Index step = std::max<Eigen::Index>(1, run.time.size() / kCurveSamples);
  std::vector<std::string> plots;
  for (std::size_t k = 0; k < run.member.size(); ++k) {
    const MemberTrace& m = run.member[k];
    plots.push_back(Plot("Force in " + run.members[k], "time", "N", step)
                        .curve("measured", "#c9c9c3", 5.0, m.measured)
                        .curve("wanted", "#cf5b13", 2.6, m.wanted)
                        .curve("true", "#0f6ab4", 1.2, m.force)
                        .text());
    plots.push_back(Plot("", "error", "N", step)
                        .curve("true minus wanted", "#0f6ab4", 1.2, m.force - m.wanted)
                        .text());
    plots.push_back(Plot("Correction x_f of " + run.members[k], "error", "mm", step)
                        .curve("x_f", "#0f6ab4", 1.2, 1e3 * m.x_f)
                        .text());
  }
  for (std::size_t k = 0; k < run.arm.size(); ++k) {
    const ArmTrace& a = run.arm[k];
    if (a.tip.rows() == 0) continue;
    const Eigen::RowVector3d from = a.motion.row(0);
    const auto along = [&](const MatrixXd& of, Eigen::Index axis) {
      return VectorXd(1e3 * (of.col(axis).array() - from[axis]));
    };
    const auto off = [&](Eigen::Index axis) {
      return VectorXd(1e3 * (a.tip.col(axis) - a.motion.col(axis)));
    };
    plots.push_back(Plot("Tip of " + run.arms[k] + " since the start", "time", "mm", step)
                        .curve("x wanted", "#e8b48f", 5.0, along(a.motion, 0))
                        .curve("y wanted", "#9fc6e6", 5.0, along(a.motion, 1))
                        .curve("z wanted", "#9fd4ce", 5.0, along(a.motion, 2))
                        .curve("x", "#cf5b13", 1.2, along(a.tip, 0))
                        .curve("y", "#0f6ab4", 1.2, along(a.tip, 1))
                        .curve("z", "#0d7a72", 1.2, along(a.tip, 2))
                        .text());
    plots.push_back(Plot("", "error", "mm", step)
                        .curve("x off its way", "#cf5b13", 1.2, off(0))
                        .curve("y off its way", "#0f6ab4", 1.2, off(1))
                        .curve("z off its way", "#0d7a72", 1.2, off(2))
                        .text());
  }
  std::string out = fmt::format("\"time\": {}, \"plots\": [", numbers(run.time, step, 4));
  for (std::size_t k = 0; k < plots.size(); ++k) out += (k > 0 ? ",\n" : "\n") + plots[k];
  return out + "]";
}

std::string series_of(const std::string& command, const std::string& plots) {
  return fmt::format("{{\"command\": {}, \"joints\": [], \"recordings\": [], {}}}\n",
                     quoted(command), plots);
}

}  // namespace

std::string to_page(const ScenarioRun& run, const Scenario& scenario, const std::string& command) {
  return html_page({run.name + ": cooperation", "cooperation.html", to_json(run, scenario),
                    series_of(command, plots_of(run)), run.report()});
}

std::string to_page(const ScenarioSweepResult& sweep, const Scenario& scenario,
                    const std::string& command) {
  return html_page({sweep.name + ": stable region", "cooperation.html", to_json(sweep, scenario),
                    series_of(command, "\"time\": [], \"plots\": []"), sweep.report()});
}

}  // namespace veridyn
