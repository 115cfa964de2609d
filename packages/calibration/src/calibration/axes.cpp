#include "veridyn/calibration/axes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "axis_results.hpp"
#include "deviations.hpp"
#include "hinges.hpp"

namespace veridyn {
namespace {

using internal::HingeBundle;
using internal::HingeTree;
using internal::RigidBody;

// Appends the result of every rigid body to out.bodies.
void append_captured_bodies(const std::vector<RigidBody>& bodies, AxesCalibration& out) {
  for (const RigidBody& b : bodies) {
    CapturedBody body;
    body.name = b.name;
    body.markers = static_cast<int>(b.markers.size());
    body.outliers = b.outliers;
    body.relabelled = b.relabelled;
    body.noise = b.noise;
    body.fault = b.fault;
    const auto seen = static_cast<double>(std::count(b.seen.begin(), b.seen.end(), 1));
    body.seen = b.seen.empty() ? 0.0 : seen / static_cast<double>(b.seen.size());
    out.outliers += b.outliers;
    out.bodies.push_back(std::move(body));
  }
}

struct LinkOfBundle {
  int first, second, body;  // hinges of the bundle; the body that carries both
};

// Pairs of successive hinges on one body: along the tree, then around every loop.
std::vector<LinkOfBundle> adjacent_hinge_pairs(const HingeBundle& bundle) {
  std::vector<LinkOfBundle> out;
  const auto add = [&](int first, int second, int body) {
    const bool there = std::any_of(out.begin(), out.end(), [&](const LinkOfBundle& l) {
      return std::min(l.first, l.second) == std::min(first, second) &&
             std::max(l.first, l.second) == std::max(first, second);
    });
    if (!there) out.push_back({first, second, body});
  };
  for (int j = 0; j < bundle.hinges(); ++j) {
    if (bundle.closes_loop(j)) continue;
    const std::vector<int> above = bundle.path_from_root(j);
    if (!above.empty()) add(above.back(), j, bundle.hinge(j).a);
  }
  for (int j = 0; j < bundle.hinges(); ++j) {
    if (!bundle.closes_loop(j)) continue;
    const std::vector<int> a = bundle.path(bundle.hinge(j).a);
    const std::vector<int> b = bundle.path(bundle.hinge(j).b);
    std::size_t common = 0;  // number of hinges above both bodies
    while (common < std::min(a.size(), b.size()) && a[common] == b[common]) ++common;
    const bool from_a = a.size() > common;
    const bool from_b = b.size() > common;
    if (from_a && from_b) add(a[common], b[common], bundle.hinge(a[common]).a);
    if (from_a) add(a.back(), j, bundle.hinge(j).a);
    else if (from_b) add(b[common], j, bundle.hinge(j).a);
    if (from_b) add(b.back(), j, bundle.hinge(j).b);
    else if (from_a) add(a[common], j, bundle.hinge(j).b);
  }
  return out;
}

// Appends axes, links, shapes and residuals of one chain to `out`, with the axes in the order of its hinges.
void append_chain(const HingeBundle& bundle, const std::vector<RigidBody>& bodies, AxesCalibration& out) {
  const int first = static_cast<int>(out.axes.size());
  const HingeTree& tree = bundle.tree();
  for (int j = 0; j < bundle.hinges(); ++j) out.axes.push_back(axis_result(bundle, bodies, j));
  for (const LinkOfBundle& l : adjacent_hinge_pairs(bundle)) {
    CalibratedLink link = link_result(bundle, l.first, l.second, l.body);
    link.first = first + l.first;
    link.second = first + l.second;
    link.body = l.body < 0 ? "world" : bodies[l.body].name;
    out.links.push_back(link);
  }
  for (const int b : tree.bodies)
    out.shapes.emplace_back(bodies[b].name, bundle.shape(b));
  out.used_frames = std::max(out.used_frames, bundle.frames());
  out.outliers += bundle.outliers();
  out.correlation = std::max(out.correlation, bundle.correlation());
  const std::vector<double> residuals = bundle.residuals();
  out.residuals.insert(out.residuals.end(), residuals.begin(), residuals.end());
}

}  // namespace

AxesCalibration calibrate_axes(const MarkerCapture& recorded, const AxesOptions& options) {
  AxesCalibration out;
  out.source = recorded.source;
  out.frames = static_cast<int>(recorded.time.size());
  MarkerCapture capture = recorded;
  const std::vector<RigidBody> bodies = internal::rigid_bodies(capture);
  append_captured_bodies(bodies, out);
  if (out.frames < options.fewest_frames) {
    out.reason = fmt::format("too few frames: {}, and {} or more are needed", out.frames,
                             options.fewest_frames);
    return out;
  }
  for (const HingeTree& tree : find_hinge_trees(bodies, options, out.cannot_tell)) {
    HingeBundle bundle(capture, bodies, tree, options);
    if (!bundle.ready()) {
      out.cannot_tell.push_back(bundle.reason());
      continue;
    }
    bundle.fit();
    append_chain(bundle, bodies, out);
  }
  if (out.axes.empty()) {
    for (const std::string& why : out.cannot_tell) out.reason += (out.reason.empty() ? "" : "; ") + why;
    if (out.reason.empty()) out.reason = "no two bodies turn about a common axis";
    return out;
  }
  out.status = CalibrationStatus::kDone;
  double square = 0.0;
  for (const double r : out.residuals) square += r * r;
  out.rms = std::sqrt(square / static_cast<double>(std::max<std::size_t>(1, out.residuals.size())));
  return out;
}

std::string AxesCalibration::report() const {
  if (status != CalibrationStatus::kDone) return "Axes: " + reason + ".\n";
  std::string text = fmt::format(
      "Axes of rotation from {} of {} frames; {} positions left out; {:.3f} mm rms per coordinate\n",
      used_frames, frames, outliers, 1e3 * rms);
  text += fmt::format("  {:<3}{:<28}{:>27}{:>10}{:>30}{:>10}{:>9}\n", "", "between", "direction",
                      "+- deg", "point [mm]", "+- mm", "range");
  for (std::size_t k = 0; k < axes.size(); ++k) {
    const CalibratedAxis& a = axes[k];
    text += fmt::format(
        "  {:<3}{:<28}{:9.5f}{:9.5f}{:9.5f}{:10.4f}{:10.3f}{:10.3f}{:10.3f}{:10.4f}{:6.1f} deg\n",
        k + 1, a.a + ", " + a.b, a.direction.x(), a.direction.y(), a.direction.z(),
        a.radius_angle / kDegree, 1e3 * a.point.x(), 1e3 * a.point.y(), 1e3 * a.point.z(),
        1e3 * a.radius, a.range / kDegree);
  }
  if (!links.empty())
    text += fmt::format("Links between successive axes\n  {:<10}{:<18}{:>14}{:>9}{:>22}{:>9}{:>13}{:>9}\n",
                        "axes", "body", "distance [mm]", "+-", "plane-parallel [mm]", "+-",
                        "twist [deg]", "+-");
  for (const CalibratedLink& l : links) {
    text += fmt::format("  {:<10}{:<18}{:14.3f}{:9.3f}{:22.3f}{:9.3f}{:13.4f}{:9.4f}\n",
                        fmt::format("{}, {}", l.first + 1, l.second + 1), l.body, 1e3 * l.distance,
                        1e3 * l.distance_half_width, 1e3 * l.plane_parallel_distance,
                        1e3 * l.plane_half_width, l.twist / kDegree, l.twist_half_width / kDegree);
  }
  for (std::size_t k = 0; k < axes.size(); ++k) {
    if (!axes[k].closes_loop) continue;
    text += fmt::format("  Axis {} closes a loop: {}.\n", k + 1,
                        axes[k].loop_play > 0.0
                            ? fmt::format("it misses itself there by {:.2g} mm rms beyond the noise, "
                                          "which counts as play", 1e3 * axes[k].loop_play)
                            : "it fits within the noise, and all axes of the loop use that");
  }
  for (const CapturedBody& b : bodies) {
    if (b.relabelled > 0)
      text += fmt::format("  Body '{}': markers had changed names in {} frames.\n", b.name,
                          b.relabelled);
  }
  for (const std::string& why : cannot_tell) text += "  No axis: " + why + ".\n";
  return text;
}

}  // namespace veridyn
