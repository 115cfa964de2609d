#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "veridyn/calibration/capture.hpp"
#include "veridyn/calibration/status.hpp"

namespace veridyn {

struct AxesOptions {
  /// Pairs of bodies to find axes between; empty: every pair that turns about one axis, bodies that
  /// follow each other in the file first. "world" is the frame of the cameras.
  std::vector<std::pair<std::string, std::string>> between;
  int fewest_frames = 10;       ///< Frames that show both bodies; fewer are refused
  int most_frames = 1500;       ///< used; a longer recording is thinned evenly
  double smallest_swing = 1.5;  ///< [deg] rms turn about the axis; less is refused
  double outlier = 4.5;         ///< standard deviations beyond which a position does not count
  int threads = 1;
};

/// An axis of rotation between two bodies. It is written in the frame of the cameras as it is while
/// `a` rests and the pair turns; where `a` never rests, as at the first frame that shows all.
struct CalibratedAxis {
  std::string a, b;
  Eigen::Vector3d direction{0, 0, 1};
  Eigen::Vector3d point{0, 0, 0};  ///< [m] of the axis, nearest to the markers of `b`
  double radius_angle = 0.0;       ///< [rad] within which the direction is, 95 %
  double radius = 0.0;             ///< [m] within which the axis passes the point, 95 %
  double range = 0.0;              ///< [rad] from least to greatest angle
  double wobble = 0.0;             ///< [rad] rms, of the relative poses alone (closed form)
  double play = 0.0;               ///< [m] likewise
  int frames = 0;                  ///< at which `a` rested and the pair turned; 0: none
};

/// What lies between two successive axes, which one body carries.
struct CalibratedLink {
  int first = 0, second = 0;  ///< First of the list of axes
  std::string body;           ///< Body that carries both
  /// [m] along the common normal. Where the axes are parallel as far as the data tell, no common
  /// normal is singled out, and it is plane_parallel_distance.
  double distance = 0.0;
  /// [m] in the plane across the mean direction of both, level with the body's markers: the distance
  /// of thesis Table 4.1. Axes more than 10 deg apart share no such plane: `distance`.
  double plane_parallel_distance = 0.0;
  double twist = 0.0;  ///< [rad] angle between the directions, 0 to pi/2
  double distance_half_width = 0.0, plane_half_width = 0.0, twist_half_width = 0.0;  ///< 95 %
};

struct CapturedBody {
  std::string name;
  int markers = 0, outliers = 0, relabelled = 0;
  double seen = 0.0;   ///< share of frames with a pose
  double noise = 0.0;  ///< [m] of one coordinate, from the distances of its markers
  std::string fault;   ///< why it has no pose; empty: it has
};

/// Axes of a chain of bodies from their markers: all markers, all axes and the angles of every frame
/// are one least-squares problem (a bundle of hinges), with Huber's loss first and without outliers
/// at the end. Starts are closed forms. Thesis A.1 and section 4.1.1.
struct AxesCalibration {
  CalibrationStatus status = CalibrationStatus::kCannotAnswer;
  std::string reason;
  std::string source;
  int frames = 0, used_frames = 0, outliers = 0;
  std::vector<CapturedBody> bodies;
  std::vector<CalibratedAxis> axes;
  std::vector<CalibratedLink> links;
  std::vector<std::string> cannot_tell;  ///< pairs without an axis, and why
  double rms = 0.0;                      ///< [m] of one coordinate of a marker
  double correlation = 1.0;              ///< frames per independent frame
  std::vector<double> residuals;         ///< [m] every coordinate, outliers left out
  /// For drawings: markers of all bodies at the reference, (3 x markers), by body.
  std::vector<std::pair<std::string, MatrixXd>> shapes;

  std::string report() const;
};

AxesCalibration calibrate_axes(const MarkerCapture& capture, const AxesOptions& options = {});

}  // namespace veridyn
