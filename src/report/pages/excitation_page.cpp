#include "veridyn/report/excitation_page.hpp"

#include <cmath>

#include "report/json/json_value.hpp"
#include "report/pages/page.hpp"
#include "report/pages/page_series.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/report/motion_json.hpp"

namespace veridyn {
namespace {

constexpr double kDigits = 1e5;          // per range of a curve

// Every `step`-th value, with as many digits as a plot can show.
Json curve(const VectorXd& values, Eigen::Index step) {
  const double range = std::max(1e-12, values.maxCoeff() - values.minCoeff());
  const double unit = std::pow(10.0, std::floor(std::log10(range / kDigits)));
  Json out = Json::array();
  for (Eigen::Index k = 0; k < values.size(); k += step)
    out.push_back(std::round(values[k] / unit) * unit);
  return out;
}

// The motion, and no recordings: nothing is recorded yet.
std::string series_json(const Excitation& e, const std::string& command) {
  const MotionSamples& m = e.motion;
  const Eigen::Index step = std::max<Eigen::Index>(1, m.rows() / kCurveSamples);
  Json out = {{"command", command}, {"recordings", Json::array()}, {"left_out", 0}};
  out["joints"] = Json::array();
  Json joints = Json::array();
  for (Eigen::Index i = 0; i < m.joints(); ++i) {
    const auto joint = static_cast<std::size_t>(i);
    const bool slides = e.units[joint] == "m";
    out["joints"].push_back({{"name", e.joints[joint]},
                             {"unit", e.units[joint]},
                             {"torque_unit", slides ? "N" : "N m"}});
    joints.push_back({{"q", curve(m.q.col(i), step)},
                      {"dq", curve(m.dq.col(i), step)},
                      {"ddq", curve(m.ddq.col(i), step)},
                      {"limits",
                       {{"q", {e.limits.lower[i], e.limits.upper[i]}},
                        {"dq", {-e.limits.velocity[i], e.limits.velocity[i]}},
                        {"ddq", {-e.limits.acceleration[i], e.limits.acceleration[i]}}}}});
  }
  out["motion"] = {{"source", ""}, {"time", curve(m.time, step)}, {"joints", joints}};
  return out.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

std::string to_page(const Excitation& e, const std::string& command) {
  require(e.motion.rows() > 1, "to_page: found an excitation without a motion.");
  return html_page({e.robot + ": a motion to record", "excitation.html", to_json(e),
                    series_json(e, command), e.report()});
}

}  // namespace veridyn
