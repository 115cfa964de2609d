#pragma once

#include <array>
#include <string>
#include <vector>

#include "veridyn/diagnosis/thresholds.hpp"
#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// A load that a model does not have, as if it sat on one link.
struct PayloadEstimate {
  std::string frame;                ///< Frame of the link; what follows is written in it
  std::vector<std::string> others;  ///< frames of links that move so alike that the torques cannot
                                    ///< tell which one carries it
  double mass = 0.0;                ///< [kg] of a point mass
  double mass_low = 0.0;            ///< 95 % interval
  double mass_high = 0.0;
  Eigen::Vector3d com = Eigen::Vector3d::Zero();  ///< [m]
  /// Of a direction that the torques see nothing of (along parallel axes without gravity), the reach
  /// of the link: nothing else bounds it.
  Eigen::Vector3d com_half_width = Eigen::Vector3d::Zero();
  std::array<bool, 3> seen = {true, true, true};  ///< directions that the torques see
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();  ///< mass times centre [kg m]
  Eigen::Vector3d moment_half_width = Eigen::Vector3d::Zero();
  /// About the centre of mass (xx, xy, yy, xz, yz, zz) [kg m^2]: what the torques ask for beyond a
  /// point mass; small loads leave it undetermined, see the half widths.
  Eigen::Matrix<double, 6, 1> inertia = Eigen::Matrix<double, 6, 1>::Zero();
  Eigen::Matrix<double, 6, 1> inertia_half_width = Eigen::Matrix<double, 6, 1>::Zero();
  InertialParameters phi = InertialParameters::Zero();  ///< Parameters of the point mass
  double gain = 0.0;       ///< fall of the sum over joints of ln(held-out mean square residual)
  double explained = 0.0;  ///< share of what the model leaves unexplained, over all joints
  /// Residual per joint as a share of what the model leaves as it stands, (n): with friction and
  /// offsets of the joints that carry the load fitted anew, and with the load beside them.
  VectorXd error_with_drift, error_with_load;
};

struct PayloadReport {
  std::string robot;
  std::vector<PayloadEstimate> links;  ///< one for every class of links that move alike, best first
  /// Relative errors, (n): of the model as it stands; with today's friction and offsets of the
  /// joints that carry the best load; with that load beside them. Fitted to these recordings.
  VectorXd error_before, error_with_drift, error_after;
  std::string reason;  ///< why there is no answer; empty otherwise
  double smallest_gain = 0.0;  ///< Thresholds::smallest_change, that found() compares the gain with
  double seconds = 0.0;

  /// The best one predicts held-out torque better, by more than a model's own errors explain, and
  /// its mass or its moment is surely there.
  bool found() const;

  std::string report() const;
};

/// Mass, centre and inertia of an added load for every link that might carry it.
///
/// The load is taken for small: a point mass. Nothing else pins the mass on a link that turns about
/// a fixed point, where torques know only mass times lever and the inertia. Friction and offsets of
/// the joints that carry it may have changed with the load; that drift is fitted beside it and is
/// in the intervals, together with the scatter between phases of the motion (jackknife).
///
/// @param model       an arm with values.
/// @param recordings  with the load, all of them.
/// @param link        name of a frame: only this link; empty: all.
/// @throws InvalidInput  the model has no values; there is no such frame; as identify().
PayloadReport find_payload(const Model& model, const Recordings& recordings,
                           const IdentificationOptions& options = {}, const std::string& link = {},
                           const Thresholds& limits = {});

}  // namespace veridyn
