#include "veridyn/calibration/capture.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "calibration/rigid_bodies.hpp"
#include "capture_table.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/suggestion.hpp"

namespace veridyn {
namespace {

using internal::CapturedObject;
using internal::CaptureTable;

constexpr double kArm = 0.1;  // [m] distance of the markers on the axes from a pose's origin

// Pose from x y z [m] qw qx qy qz; the identity rotation if not oriented.
Eigen::Isometry3d pose_of(const VectorXd& v, bool oriented) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  if (oriented) T.linear() = Eigen::Quaterniond(v[3], v[4], v[5], v[6]).normalized().matrix();
  T.translation() = v.head<3>();
  return T;
}

// Adds a rigid pose as four markers attached to it.
void add_pose(const CapturedObject& object, MarkerCapture& out) {
  const std::array<const char*, 4> names = {"origin", "x", "y", "z"};
  for (int m = 0; m < 4; ++m) {
    CapturedMarker marker{object.name, names[m],
                          object.values.topRows<3>()};
    for (Eigen::Index k = 0; k < object.values.cols(); ++k) {
      const VectorXd v = object.values.col(k);
      if (!v.allFinite())
        marker.position.col(k).setConstant(std::numeric_limits<double>::quiet_NaN());
      else if (m > 0)
        marker.position.col(k) += kArm * pose_of(v, true).linear().col(m - 1);
    }
    out.markers.push_back(std::move(marker));
  }
}

MarkerCapture capture_of_markers(const CaptureTable& table) {
  MarkerCapture out;
  out.source = table.source;
  out.time = table.time;
  const bool any_marker =
      std::any_of(table.objects.begin(), table.objects.end(), [](const CapturedObject& o) {
        return !o.has_orientation && o.name.find('/') != std::string::npos;
      });
  for (const CapturedObject& object : table.objects) {
    const std::size_t slash = object.name.find('/');
    if (object.has_orientation) {
      // Poses are redundant if the file has markers.
      if (!any_marker) add_pose(object, out);
      out.from_poses = out.from_poses || !any_marker;
      continue;
    }
    require(slash != std::string::npos && slash > 0 && slash + 1 < object.name.size(), table.source,
            ": found a position '", object.name,
            "', expected BODY/MARKER, so that markers of one rigid body are known as such.");
    out.markers.push_back({object.name.substr(0, slash), object.name.substr(slash + 1),
                           object.values.topRows<3>()});
  }
  return out;
}

bool is_marker(const CapturedObject& object) {
  return !object.has_orientation && object.name.find('/') != std::string::npos;
}

// "BODY" of an object "BODY/MARKER" or "BODY".
std::string body_of(const CapturedObject& object) {
  return is_marker(object) ? object.name.substr(0, object.name.find('/')) : object.name;
}

// The wanted body, or the only one; throws InvalidInput if there are several or no such body.
std::string chosen_body(const CaptureTable& table, const std::string& wanted) {
  std::vector<std::string> names;
  for (const CapturedObject& o : table.objects) {
    if (std::find(names.begin(), names.end(), body_of(o)) == names.end())
      names.push_back(body_of(o));
  }
  if (wanted.empty()) {
    require(names.size() == 1, table.source, ": found ", names.size(), " bodies (", listed(names),
            "), expected one, or --body with the one to take.");
    return names.front();
  }
  require(names != std::vector<std::string>{""}, table.source,
          ": found one body without a name, expected none after --body.");
  require(std::find(names.begin(), names.end(), wanted) != names.end(), table.source,
          ": found no body '", wanted, "', expected one of ", listed(names), ".");
  return wanted;
}

// Appends row k of the table with its pose, unless a joint position is missing.
void add_frame(const CaptureTable& table, Eigen::Index k, const Eigen::Isometry3d& T,
               PoseCapture& out, std::vector<double>& time) {
  if (table.q.cols() > 0 && !table.q.row(k).allFinite()) return;
  out.poses.push_back(T);
  out.rows.push_back(static_cast<long>(k));
  time.push_back(table.time[k]);
}

}  // namespace

std::vector<std::string> MarkerCapture::bodies() const {
  std::vector<std::string> names;
  for (const CapturedMarker& m : markers) {
    if (std::find(names.begin(), names.end(), m.body) == names.end()) names.push_back(m.body);
  }
  return names;
}

MarkerCapture read_markers(const std::string& path, const CaptureOptions& options) {
  return capture_of_markers(internal::read_capture(path, options));
}

PoseCapture read_poses(const std::string& path, const CaptureOptions& options) {
  const CaptureTable table = internal::read_capture(path, options);
  PoseCapture out;
  out.source = path;
  out.body = chosen_body(table, options.body);
  out.file_rows = table.time.size();
  std::vector<double> time;
  const auto object = std::find_if(
      table.objects.begin(), table.objects.end(),
      [&](const CapturedObject& o) { return o.name == out.body && !is_marker(o); });
  if (object != table.objects.end()) {
    out.has_orientation = object->has_orientation;
    for (Eigen::Index k = 0; k < table.time.size(); ++k) {
      const VectorXd v = object->values.col(k).head(out.has_orientation ? 7 : 3);
      if (v.allFinite()) add_frame(table, k, pose_of(v, out.has_orientation), out, time);
    }
  } else {
    MarkerCapture capture = capture_of_markers(table);
    for (const internal::RigidBody& body : internal::rigid_bodies(capture)) {
      if (body.name != out.body) continue;
      out.fault = body.fault;
      if (!body.fault.empty()) break;
      for (Eigen::Index k = 0; k < table.time.size(); ++k) {
        const auto at = static_cast<std::size_t>(k);
        if (body.seen[at] != 0) add_frame(table, k, body.pose[at], out, time);
      }
    }
  }
  out.time = Eigen::Map<const VectorXd>(time.data(), static_cast<Eigen::Index>(time.size()));
  out.q.resize(out.frames(), table.q.cols());
  for (int k = 0; k < out.frames() && out.q.cols() > 0; ++k)
    out.q.row(k) = table.q.row(out.rows[k]);
  return out;
}

}  // namespace veridyn
