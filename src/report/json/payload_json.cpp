#include "veridyn/report/payload_json.hpp"

#include "report/json/json_value.hpp"

namespace veridyn {
namespace {

// A value with its 95 % interval; both null if the motion did not show it (`seen`).
Json interval_json(double value, double low, double high, const char* unit, bool seen = true) {
  if (!seen) return {{"value", nullptr}, {"unit", unit}, {"ci95", nullptr}};

  return {{"value", value}, {"unit", unit}, {"ci95", Json::array({low, high})}};
}

Json link_json(const PayloadEstimate& p) {
  Json out = {{"frame", p.frame}, {"same_torques", p.others}};
  out["mass"] = interval_json(p.mass, p.mass_low, p.mass_high, "kg");
  const char* const axes[] = {"x", "y", "z"};
  for (int c = 0; c < 3; ++c) {
    const bool seen = p.seen[static_cast<std::size_t>(c)];
    out["com"][axes[c]] =
        interval_json(p.com[c], p.com[c] - p.com_half_width[c], p.com[c] + p.com_half_width[c], "m", seen && p.has_mass());
    out["moment"][axes[c]] = interval_json(p.moment[c], p.moment[c] - p.moment_half_width[c],
                                      p.moment[c] + p.moment_half_width[c], "kg m", seen);
  }
  const char* const entries[] = {"xx", "xy", "yy", "xz", "yz", "zz"};
  for (int c = 0; c < 6; ++c) {
    out["inertia"][entries[c]] = interval_json(p.inertia[c], p.inertia[c] - p.inertia_half_width[c],
                                          p.inertia[c] + p.inertia_half_width[c], "kg m^2");
  }
  out["explained"] = p.explained;
  out["at_bound"] = p.at_bound;
  out["unexplained"] = p.unexplained;
  out["gain"] = p.gain;
  return out;
}

}  // namespace

std::string to_json(const PayloadReport& report) {
  Json out = json_head("payload");
  out["robot"] = report.robot;
  out["verdict"] = report.found() ? "payload" : "none";
  out["headline"] = report.headline();
  out["remarks"] = report.remarks;
  out["links"] = json_each(report.links, link_json);
  out["relative_error"] = {{"before", json_list(report.error_before)},
                           {"with_drift", json_list(report.error_with_drift)},
                           {"after", json_list(report.error_after)}};
  out["reason"] = report.reason;
  out["seconds"] = report.seconds;
  return json_text(out);
}

}  // namespace veridyn
