#include "nodes/looks.hpp"

#include <unistd.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <fstream>

#include "veridyn/kinematics/kinematics.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/urdf.hpp"

namespace veridyn_ros {
namespace {

using namespace veridyn;
using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kShortest = 1e-3;  // [m] length below which no rod is drawn
constexpr double kSame = 1e-6;      // [m] distance below which two points are the same

// Joint positions at `share` of their ranges; `share` itself [rad], [m] for joints without limits.
VectorXd joints_at_share(const Model& arm, double share) {
  VectorXd q(arm.joints());
  for (int i = 0; i < arm.joints(); ++i) {
    const Limits& l = arm.coordinates()[i].limits;
    const double range = l.upper - l.lower;
    q[i] = std::isfinite(range) ? l.lower + share * range : share;
  }
  return q;
}

// URDF of a rod from the origin to `end` [m].
std::string rod_urdf(const Vector3d& end, const char* colour, double radius) {
  const Vector3d middle = 0.5 * end;
  const Vector3d z = end.normalized();
  // Fixed angles that turn z to the rod: none about x, then about y, then about z.
  const double pitch = std::acos(std::min(1.0, std::max(-1.0, z.z()))), yaw = std::atan2(z.y(), z.x());
  char out[700];
  std::snprintf(out, sizeof out,
                "<visual><origin xyz=\"%.9g %.9g %.9g\" rpy=\"0 %.9g %.9g\"/><geometry><cylinder radius=\"%g\" length=\"%.9g\"/>"
                "</geometry><material name=\"%s\"/></visual>",
                middle.x(), middle.y(), middle.z(), pitch, yaw, radius, end.norm(), colour);
  return out;
}

// Rods on the parent's link if a frame is fixed in it, else on the frame's own.
UrdfAppearance rod_appearance(const Model& arm) {
  UrdfAppearance out;
  out[""] = "<material name=\"steel\"><color rgba=\"0.62 0.66 0.70 1\"/></material>"
            "<material name=\"shaft\"><color rgba=\"0.25 0.27 0.30 1\"/></material>";
  const VectorXd low = joints_at_share(arm, 0.1), high = joints_at_share(arm, 1.0);
  for (std::size_t f = 0; f < arm.frames().size(); ++f) {
    const std::optional<FrameIndex> own = FrameIndex{static_cast<int>(f)}, parent = arm.frames()[f].parent;
    const auto at = [&](const VectorXd& q, std::optional<FrameIndex> frame) { return frame ? frame_pose(arm, q, *frame) : Isometry3d::Identity(); };
    const Vector3d there = (at(low, parent).inverse() * at(low, own)).translation();
    const Vector3d later = (at(high, parent).inverse() * at(high, own)).translation();
    if ((there - later).norm() < kSame) {
      const std::string link = parent ? arm.frames()[parent->value].name : "world";
      if (there.norm() > kShortest) out[link] += rod_urdf(there, "steel", 0.012);
      continue;
    }
    const Vector3d back = (at(high, own).inverse() * at(high, parent)).translation();
    const bool slides = (back - (at(low, own).inverse() * at(low, parent)).translation()).norm() > kSame;
    if (back.norm() > kShortest) out[arm.frames()[f].name] += rod_urdf(back, slides ? "shaft" : "steel", slides ? 0.005 : 0.012);
  }
  return out;
}

// The links of the URDF as frames; those of the model if this library was built without a URDF reader.
Model read_links(const std::string& urdf, const Model& model) {
  const std::string path = "/tmp/veridyn_show_" + std::to_string(::getpid()) + ".urdf";
  std::ofstream(path) << urdf;
  try {
    Model links = read_urdf(path);
    std::remove(path.c_str());
    return links;
  } catch (const InvalidInput&) {
    std::remove(path.c_str());
    return model;
  }
}

}  // namespace

Looks appearance_of(const Model& model) {
  UrdfExtras extras;
  extras.appearance = rod_appearance(model);
  const std::string urdf = to_urdf(model, extras);
  return {urdf, read_links(urdf, model)};
}

}  // namespace veridyn_ros
