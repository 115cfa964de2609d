#pragma once

#include <array>
#include <string>
#include <vector>

#include "veridyn/diagnosis/thresholds.hpp"
#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// [kg] largest magnitude of a load in the search.
constexpr double kHeaviestLoad = 200.0;

/// A load, assumed on one link, that the arm has and the model does not; a negative mass if the model has it
/// and the arm does not.
struct PayloadEstimate {
  std::string frame;  ///< frame of the link, in which the following vectors are written
  /// Frames of other links with indistinguishable motion, any of which may carry it.
  std::vector<std::string> others;
  double mass = 0.0;                ///< [kg] of a point mass
  double mass_low = 0.0;            ///< 95 % interval; mass and lever arm are strongly correlated
  double mass_high = 0.0;
  Eigen::Vector3d com = Eigen::Vector3d::Zero();  ///< [m]
  /// In a direction that the torques do not determine (along parallel axes without gravity) it is
  /// the largest distance of a load.
  Eigen::Vector3d com_half_width = Eigen::Vector3d::Zero();
  std::array<bool, 3> seen = {true, true, true};  ///< directions of the centre that the torques determine
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();  ///< mass times centre [kg m]
  Eigen::Vector3d moment_half_width = Eigen::Vector3d::Zero();
  /// About the centre of mass (xx, xy, yy, xz, yz, zz) [kg m^2], beyond the point mass;
  /// undetermined for small loads, see the half widths.
  Eigen::Matrix<double, 6, 1> inertia = Eigen::Matrix<double, 6, 1>::Zero();
  Eigen::Matrix<double, 6, 1> inertia_half_width = Eigen::Matrix<double, 6, 1>::Zero();
  InertialParameters phi = InertialParameters::Zero();  ///< parameters of the point mass
  /// Decrease of the sum over joints of ln(held-out mean square residual); NaN: too few poses at rest to hold any out.
  double gain = 0.0;
  double explained = 0.0;  ///< share of the model's residual that it explains, over all joints
  double most_off = kHeaviestLoad;  ///< [kg] mass of the link, which bounds a negative load
  bool at_bound = false;   ///< mass or centre is at a bound of the search: no finding
  std::vector<std::string> unexplained{};  ///< joints on which the load acts and whose error stays far above that of the model
  /// True if the interval of the mass excludes zero.
  bool has_mass() const;
  /// Residual per joint divided by that of the unmodified model, (n): with friction and offsets of
  /// the joints that carry the load fitted again, and with the load in addition.
  VectorXd error_with_drift, error_with_load;
};

struct PayloadReport {
  std::string robot;
  /// One for each class of links with indistinguishable motion, best first; of those within Thresholds::tie
  /// of the best gain the one nearest to the load is first, as in diagnose().
  std::vector<PayloadEstimate> links;
  /// Relative errors, (n): of the unmodified model; with friction and offsets of the joints that
  /// carry the best load fitted again; with that load in addition. All fitted to these recordings.
  VectorXd error_before, error_with_drift, error_after;
  /// One factor of the torques of all joints that explains the recordings as well as the best load does; 0: none does.
  double torque_factor = 0.0;
  std::string reason;  ///< reason why there is no estimate; empty otherwise
  std::vector<std::string> remarks{};  ///< sentences on the assumptions of the values and intervals
  double smallest_gain = 0.0;  ///< Thresholds::smallest_change, the bound of the gain in found()
  double seconds = 0.0;

  /// True if the best load lowers the held-out error by more than the model's own error, explains every joint that it
  /// acts on and more than torque_factor does, and the interval of its mass or its moment excludes zero.
  bool found() const;
  std::string headline() const;  ///< one line: the load with its interval, or the reason for which there is none

  std::string report() const;
};

/// Estimates mass, centre and inertia of an added load for every link that might carry it.
///
/// The load is modelled as a point mass, because on a link that turns about a fixed point torques
/// determine only mass times lever and the inertia. Friction and offsets of the joints that carry
/// it may have changed with the load; this drift is estimated as well and is part of the
/// intervals, as is the scatter between phases of the motion (jackknife).
///
/// @param model       an arm with values.
/// In poses at rest (read_rest_poses()) gravity determines mass and centre; if their direction of approach is unknown,
/// the model's dry friction widens the intervals.
///
/// @param recordings  all of them with the load.
/// @param link        frame of the only link to test; empty: all links.
/// @throws InvalidInput  the model has no values, the frame does not exist, or as identify().
PayloadReport find_payload(const Model& model, const Recordings& recordings,
                           const IdentificationOptions& options = {}, const std::string& link = {},
                           const Thresholds& limits = {});

}  // namespace veridyn
