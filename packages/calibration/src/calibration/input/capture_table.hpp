#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "veridyn/calibration/capture.hpp"

namespace veridyn::internal {

/// Content of a column of a motion-capture file.
struct CaptureColumn {
  enum class Kind { kIgnored, kTime, kJoint, kBodyName, kObjectName, kComponent };
  Kind kind = Kind::kIgnored;
  int index = 0;            ///< joint from 0; component: x y z qw qx qy qz, rx ry rz of a rotation vector
  std::string object;       ///< "BODY/MARKER", "BODY" or ""
  std::string unit;         ///< as the column states it; "": none
  std::string name;         ///< name in the file
};

/// Header of a motion-capture file.
struct CaptureHeader {
  char separator = ',';
  std::vector<CaptureColumn> columns;
  std::string unit;     ///< as the file states it; "": none
  double rate = 0.0;    ///< [Hz]; 0: not stated
  bool padded = false;  ///< rows may be short, as exports omit trailing gaps
};

/// Metres per unit of "mm", "millimeters", ...; 0 if it is no unit of length.
double metres_of(std::string unit);

/// Content of a column by its name; kIgnored if the name is unknown.
CaptureColumn parsed_column(const std::string& name);

/// One marker or one rigid body over time.
struct CapturedObject {
  std::string name;
  MatrixXd values;  ///< (7 x frames): x y z [m], qw qx qy qz; NaN where missing
  bool has_orientation = false;
};

/// A motion-capture file in memory.
struct CaptureTable {
  std::string source;
  VectorXd time;               ///< (frames) [s]
  MatrixXd q;                  ///< (frames x joints) [rad] or [m]; NaN where missing
  std::vector<long> lines;     ///< line numbers of the file, by frame
  std::vector<CapturedObject> objects;
};

/// Reads a file of any layout that read_markers() accepts, in SI units.
/// @throws InvalidInput  "file:line:column: found ..., expected ...".
CaptureTable read_capture(const std::string& path, const CaptureOptions& options);

}  // namespace veridyn::internal
