#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "veridyn/calibration/links.hpp"

namespace veridyn {
namespace {

constexpr double kDegrees = 180.0 / M_PI;

std::string constant_title(const LinkConstant& c) {
  return c.frame.empty() ? c.name : c.name + " of frame " + c.frame;
}

// A value in mm, deg or as a plain number; "open" if it is infinite.
std::string value_text(double value, const std::string& unit) {
  if (!std::isfinite(value)) return "open";
  if (unit == "m") return fmt::format("{:.3f} mm", 1e3 * value);
  if (unit == "rad") return fmt::format("{:.4f} deg", kDegrees * value);
  return fmt::format("{:.5f}", value);
}

std::string verdict_text(const LinksCalibration& r) {
  if (r.explained && r.named.empty())
    return "No constant differs from the file: the poses are explained as well with it.\n";
  if (!r.explained)
    return "Many constants differ from the file: no few of them explain the poses.\n";
  std::string text = r.named.size() == 1 ? "One constant differs from the file and explains all:\n"
                                         : fmt::format("{} constants differ from the file and "
                                                       "explain all:\n", r.named.size());
  for (const int k : r.named) {
    const LinkConstant& c = r.constants[k];
    text += fmt::format("  {} is {} there; the poses ask for {} ({} to {}).{}\n", constant_title(c),
                        value_text(c.file, c.unit), value_text(c.found, c.unit), value_text(c.low, c.unit),
                        value_text(c.high, c.unit), c.why.empty() ? "" : " It " + c.why + ".");
  }
  return text;
}

}  // namespace

std::string LinksCalibration::report() const {
  if (status != CalibrationStatus::kDone) return "Links: " + reason + ".\n";
  std::string text = fmt::format(
      "Constants of {} from {} poses of frame {}, {} of them left out; pose of the base {}, of the "
      "body on the frame {}\n", robot, frames, frame, outliers, base_free ? "found too" : "known",
      tool_free ? "found too" : "known");
  text += verdict_text(*this);
  text += fmt::format("Error of positions: {:.3f} mm rms with the file, {:.3f} mm now; held out "
                      "{:.3f} mm (file {:.3f} mm), orientations {:.4f} deg.\n",
                      1e3 * rms_file, 1e3 * rms, 1e3 * held_out_rms, 1e3 * held_out_rms_file,
                      kDegrees * held_out_angle);
  text += fmt::format("  {:<28}{:>16}{:>16}  {}\n", "constant", "file", "found", "95 %");
  for (const LinkConstant& c : constants) {
    const std::string range = c.identifiable || c.changed
                                  ? value_text(c.low, c.unit) + " to " + value_text(c.high, c.unit)
                                  : c.why;
    text += fmt::format("{} {:<28}{:>16}{:>16}  {}\n", c.changed ? '*' : ' ', constant_title(c),
                        value_text(c.file, c.unit), value_text(c.found, c.unit), range);
  }
  return text;
}

std::string compare_wrong_constant(const LinksCalibration& links, const std::string& frame,
                                   const std::string& name, double found, double low, double high) {
  const auto same = std::find_if(
      links.constants.begin(), links.constants.end(),
      [&](const LinkConstant& c) { return c.name == name && c.frame == frame; });
  const std::string what = name + (frame.empty() ? "" : " of frame " + frame);
  if (same == links.constants.end())
    return fmt::format("Torques ask for {}; the poses are of frame {}, which it does not move.",
                       what, links.frame);
  const std::string torques =
      fmt::format("Torques ask for {} = {} ({} to {}); ", what, value_text(found, same->unit),
                  value_text(low, same->unit), value_text(high, same->unit));
  if (!same->identifiable && !same->changed)
    return torques + fmt::format("poses cannot tell: it {}.", same->why);
  const std::string poses = fmt::format("poses for {} ({} to {}): ", value_text(same->found, same->unit),
                                        value_text(same->low, same->unit), value_text(same->high, same->unit));
  if (!same->changed) {
    const bool apart = same->high < low || same->low > high;
    return torques + poses +
           (apart ? "they contradict the torques." : "nothing wrong as far as they tell.");
  }
  const bool agree = same->low <= high && same->high >= low;
  return torques + poses + (agree ? "they agree." : "the same constant, by another amount.");
}

}  // namespace veridyn
