#pragma once

#include <vector>

#include "closed_forms.hpp"

namespace veridyn::internal {

/// The line `start` displaced by four unknowns x: x[0], x[1] rotate its direction, x[2], x[3] [m] shift its
/// point, along the columns of `plane`, two unit vectors across it.
Line moved_line(const Line& start, const Eigen::Matrix<double, 3, 2>& plane, const double* x);

/// A point rotated about a line by an angle [rad].
Eigen::Vector3d rotated_about(const Line& line, double angle, const Eigen::Vector3d& point);

/// One marker at one frame, seen through the hinges between the root and its body.
struct HingePath {
  std::vector<int> hinges;  ///< Hinges of the tree, from the root on
  std::vector<Line> start;
  std::vector<Eigen::Matrix<double, 3, 2>> plane;
  Eigen::Isometry3d root;
  bool root_rests = true;
  bool is_reference = false;  ///< True at the reference instant: all hinge angles are zero, and it has no unknowns of its own
  int local_size = 0;  ///< number of unknowns of the frame
  Eigen::Vector3d measured{0, 0, 0};

  /// (model - measured) / noise, with derivatives.
  /// @param x  the marker (3), each hinge of the path (4), then the frame: rotation and translation
  /// of a moving root (6), and the angles of all hinges of the tree.
  void evaluate(const double* const* x, double noise, double* r, double* const* J) const;
};

/// A hinge that closes a loop: its line has to be the same through either of the two bodies that it joins.
/// Hinges above both bodies move the two lines together and are in neither path.
struct HingeClosure {
  HingePath a, b;
  Line start;
  Eigen::Matrix<double, 3, 2> plane;
  double half = 0.05;  ///< [m] distance of the two compared points of the line from its own point

  /// (point through a - point through b) / deviation at both points: 6 rows.
  /// @param x  the line (4), the hinges of a and of b (4 each), the frame.
  void evaluate(const double* const* x, double deviation, double* r, double* const* J) const;
};

}  // namespace veridyn::internal
