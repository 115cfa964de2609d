#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "veridyn/calibration/capture.hpp"
#include "veridyn/calibration/status.hpp"

namespace veridyn {

struct AxesOptions {
  /// Pairs of bodies between which axes are sought. Empty: all pairs that turn about one axis, neighbours in
  /// the file first, without loops. Requested pairs may close loops, which then have to fit as well. "world"
  /// is the frame of the cameras.
  std::vector<std::pair<std::string, std::string>> between;
  int fewest_frames = 10;       ///< frames in which both bodies are seen; fewer are refused
  int most_frames = 1500;       ///< frames used at most; a longer recording is thinned evenly
  double smallest_swing = 1.5;  ///< [deg] rms turn about the axis; less is refused
  double outlier = 4.5;         ///< standard deviations beyond which a position is an outlier
  int threads = 1;
};

/// An axis of rotation between two bodies, in the frame of the cameras while `a` rests and the pair turns; if
/// `a` never rests, at the first frame that shows all bodies.
struct CalibratedAxis {
  std::string a, b;
  Eigen::Vector3d direction{0, 0, 1};
  Eigen::Vector3d point{0, 0, 0};  ///< [m] point of the axis nearest to the markers of `b`
  double radius_angle = 0.0;       ///< [rad] 95 % bound on the error of the direction
  double radius = 0.0;  ///< [m] 95 % bound on the distance of the true axis from the point
  double range = 0.0;   ///< [rad] difference of the largest and the smallest angle
  /// [rad] rms rotation about other axes, from the relative poses alone (closed form)
  double wobble = 0.0;
  double play = 0.0;  ///< [m] rms translation across the axis, likewise
  int frames = 0;     ///< frames in which `a` rested and the pair turned; 0: none
  /// The pair is already connected by other axes, so that this one closes a loop with them.
  bool closes_loop = false;
  /// [m] rms gap at this axis of the loop that it closes, beyond the noise of the markers
  double loop_play = 0.0;
};

/// Geometry between two successive axes of one body, along a chain or around a loop.
struct CalibratedLink {
  int first = 0, second = 0;  ///< index of the first axis in the list
  std::string body;           ///< body that carries both
  /// [m] along the common normal. If the data cannot distinguish the axes from parallel ones, the common
  /// normal is not unique, and this equals plane_parallel_distance.
  double distance = 0.0;
  /// [m] in the plane perpendicular to the mean direction of both, level with the body's markers: the
  /// distance of thesis Table 4.1. For axes more than 10 deg apart there is no such plane: equals `distance`.
  double plane_parallel_distance = 0.0;
  double twist = 0.0;  ///< [rad] angle between the directions, 0 to pi/2
  double distance_half_width = 0.0, plane_half_width = 0.0, twist_half_width = 0.0;  ///< 95 %
};

struct CapturedBody {
  std::string name;
  int markers = 0, outliers = 0, relabelled = 0;
  double seen = 0.0;   ///< share of frames in which the pose is known
  double noise = 0.0;  ///< [m] standard deviation of a marker coordinate, from the distances of its markers
  std::string fault;   ///< reason for a missing pose; empty: the pose is known
};

/// Axes of a chain of bodies from their markers. All markers, all axes and the angles of every
/// frame are one least-squares problem (bundle adjustment with hinges), with Huber's loss first and
/// without outliers at the end; closed forms give the initial values. A loop of hinges is closed at
/// every frame, within its play. Thesis A.1 and section 4.1.1.
struct AxesCalibration {
  CalibrationStatus status = CalibrationStatus::kCannotAnswer;
  std::string reason;
  std::string source;
  int frames = 0, used_frames = 0, outliers = 0;
  std::vector<CapturedBody> bodies;
  std::vector<CalibratedAxis> axes;
  std::vector<CalibratedLink> links;
  std::vector<std::string> cannot_tell;  ///< pairs for which no axis was found, with the reason
  double rms = 0.0;                      ///< [m] rms residual of one coordinate of a marker
  double correlation = 1.0;              ///< number of successive frames that count as one independent frame
  std::vector<double> residuals;         ///< [m] residual of every coordinate, without outliers
  /// For drawings: markers of all bodies at the reference, (3 x markers), by body.
  std::vector<std::pair<std::string, MatrixXd>> shapes;

  std::string report() const;
};

/// Status kCannotAnswer, with the reason, if there are too few frames or no pair of bodies turns about one
/// axis.
/// @throws InvalidInput  `between` has a body that the recording has not.
AxesCalibration calibrate_axes(const MarkerCapture& capture, const AxesOptions& options = {});

}  // namespace veridyn
