#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "veridyn/math/types.hpp"

namespace veridyn {

/// Options for reading the export of a motion-capture program.
struct CaptureOptions {
  /// Unit of positions: "m", "cm" or "mm"; empty: as stated in the file, else metres.
  std::string unit;
  std::string body;   ///< the body whose pose is wanted, for files with several
  /// [Hz] of files without time; 0: as stated in the file, else rows count seconds
  double rate = 0.0;
};

/// Path of one marker.
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
  bool from_poses = false;  ///< each rigid pose is represented by four markers

  /// Names of the bodies, in the order of the file.
  std::vector<std::string> bodies() const;
};

/// The pose of one rigid body over time, with the joints of an arm where the file has them.
struct PoseCapture {
  std::string source;
  std::string body;
  VectorXd time;  ///< (frames) [s]
  MatrixXd q;     ///< (frames x joints) [rad] or [m] as recorded; no columns without joints
  std::vector<Eigen::Isometry3d> poses;  ///< T_camera_body, translation in [m]
  bool has_orientation = true;           ///< false: only positions were recorded
  std::vector<long> rows;                ///< row numbers of these frames in the file, from 0
  long file_rows = 0;                    ///< rows of the file, including frames with gaps
  std::string fault;                     ///< reason if the markers give no pose; empty if they do

  int frames() const { return static_cast<int>(poses.size()); }
};

/// Reads markers. Layouts, separated by comma, semicolon, tab or blanks:
///
///   wide    t,BODY/MARKER/x,BODY/MARKER/y,BODY/MARKER/z,...    also BODY:MARKER, BODY.MARKER
///   long    t,body,marker,x,y,z    or    t,marker,x,y,z with BODY/MARKER as the marker's name
///   poses   t,BODY/x,BODY/y,BODY/z,BODY/qw,...    each pose becomes four markers
///   exports of Motive (CSV), Nexus (trajectories as CSV) and Track Manager (TSV)
///
/// Empty fields and `nan` mark hidden markers. The unit is given after a column's name, `x [mm]`,
/// in a comment, `# unit: mm`, or in the options.
/// @throws InvalidInput  "file:line:column: found ..., expected ...".
MarkerCapture read_markers(const std::string& path, const CaptureOptions& options = {});

/// Reads the pose of one body: t,q1..qn,x,y,z,qw,qx,qy,qz, where joints and orientation are optional; or of
/// one body in any layout of read_markers(), fitted to its markers (three or more; the body's frame is at
/// their mean, with the axes of the cameras at the first frame). Frames with gaps are dropped.
/// @throws InvalidInput  as read_markers(), or several bodies of which none is chosen.
PoseCapture read_poses(const std::string& path, const CaptureOptions& options = {});

}  // namespace veridyn
