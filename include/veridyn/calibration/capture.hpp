#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "veridyn/math/types.hpp"

namespace veridyn {

/// How to read what a motion-capture program exported.
struct CaptureOptions {
  std::string unit;   ///< "m", "cm" or "mm" of positions; empty: as the file states, else metres
  std::string body;   ///< Body of a file with several bodies, the one whose pose is wanted
  double rate = 0.0;  ///< [Hz] of files without time; 0: as the file states, else rows count seconds
};

/// The path of one marker.
struct CapturedMarker {
  std::string body;
  std::string name;
  MatrixXd position;  ///< (3 x frames) [m] in the frame of the cameras; NaN where hidden
};

/// Markers over time.
struct MarkerCapture {
  std::string source;
  VectorXd time;  ///< (frames) [s]
  std::vector<CapturedMarker> markers;
  bool from_poses = false;  ///< markers stand for rigid poses, four of each

  /// Names of the bodies, in the order of the file.
  std::vector<std::string> bodies() const;
};

/// The pose of one rigid body over time, with the joints of an arm where the file has them.
struct PoseCapture {
  std::string source;
  std::string body;
  VectorXd time;  ///< (frames) [s]
  MatrixXd q;     ///< (frames x joints) [rad] or [m] as recorded; no columns where there are none
  std::vector<Eigen::Isometry3d> poses;  ///< T_camera_body; [m]
  bool has_orientation = true;           ///< false: only positions were recorded
  std::vector<long> rows;                ///< Rows of the file, from 0, that the frames come from
  long file_rows = 0;                    ///< in the file, frames with gaps included
  std::string fault;                     ///< why markers show no pose, in words; empty: none

  int frames() const { return static_cast<int>(poses.size()); }
};

/// Reads markers. Layouts, comma, semicolon, tab or blanks between fields:
///
///   wide    t,BODY/MARKER/x,BODY/MARKER/y,BODY/MARKER/z,...    also BODY:MARKER, BODY.MARKER
///   long    t,body,marker,x,y,z    or    t,marker,x,y,z with BODY/MARKER as the marker's name
///   poses   t,BODY/x,BODY/y,BODY/z,BODY/qw,...    each pose becomes four markers
///   exports of Motive (CSV), Nexus (trajectories as CSV) and Track Manager (TSV)
///
/// Empty fields and `nan` are hidden markers. The unit may stand behind a column's name, `x [mm]`,
/// in a comment, `# unit: mm`, or in the options.
/// @throws InvalidInput  "file:line:column: found ..., expected ...".
MarkerCapture read_markers(const std::string& path, const CaptureOptions& options = {});

/// Reads the pose of one body: t,q1..qn,x,y,z,qw,qx,qy,qz, joints and orientation optional; or one
/// body of any layout of read_markers(), its pose fitted to its markers (three or more, the body's
/// frame in their mean, turned as the cameras' at the first frame). Frames with gaps are left out.
/// @throws InvalidInput  likewise, or several bodies and none named.
PoseCapture read_poses(const std::string& path, const CaptureOptions& options = {});

}  // namespace veridyn
