#pragma once

#include <optional>
#include <string>
#include <vector>

#include "veridyn/recordings/preprocessing.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// A load of known mass, rigidly mounted on a frame while some of the recordings were made. Where
/// on the frame its centre lies and what inertia it has is not asked for: both are found.
struct KnownMass {
  double mass = 0.0;  ///< [kg]
  std::string frame;
  /// Those that carry it, as the recordings are named to find_drive_gains() or by their file names.
  /// Empty: the data tell (allowed where there is one known mass only).
  std::vector<std::string> recordings;
};

/// The drive gain of one joint: its torque (or force) per ampere of motor current.
struct DriveGain {
  std::string coordinate;
  std::string unit;  ///< "N m/A" or "N/A"
  bool identifiable = false;
  std::string reason;      ///< Why it is not identifiable
  double value = 0.0;      ///< best estimate, identifiable or not
  double deviation = 0.0;  ///< standard deviation, from clusters; infinite where nothing tells it
  double low = 0.0;        ///< 95 % interval; infinite ends where the data leave them open
  double high = 0.0;
  double in_file = 0.0;  ///< what the robot file says; 0: nothing
  double share = 0.0;  ///< Share of the joint's rms torque in the loaded recordings that the known mass makes
};

/// What was found out about one known mass.
struct MountedLoad {
  KnownMass known;  ///< with the recordings that carry it
  bool identified = false;
  std::optional<Eigen::Vector3d> centre;  ///< [m] in its frame, where the data determine it
  Eigen::Vector3d centre_deviation = Eigen::Vector3d::Zero();
};

struct DriveGains {
  std::string problem;  ///< why there are no gains at all, one line; empty: there are
  std::vector<DriveGain> joints;
  std::vector<MountedLoad> loads;
  std::vector<std::string> unloaded;  ///< recordings that carry none
  int clusters = 0;                   ///< Clusters of the jackknife

  /// Gains with intervals, and what is not identifiable, as text.
  std::string report() const;
};

/// Finds the drive gains of an arm that reports motor currents, from recordings with and without a
/// known mass.
///
///   current_j = 1/K_j * (Y_j beta + Y_load,j [m, h, L] + effects_j)
///
/// The load's mass m is known; its first moment h and its inertia L, the arm's base parameters beta
/// and the effects are not. Least squares in beta, h, L, effects and 1/K together (the noise is in
/// the currents, on the left). The mass gives the scale of every joint that feels it, the
/// parameters that several joints share carry the scale to the others. Effects that drift from day
/// to day (friction, offset) are free in every recording. Drive gains of the robot file are not
/// used.
///
/// Which recordings carry the load, where that is not said: the division into two groups that fits
/// best, of which the heavier one carries it.
///
/// @param recordings  paths; every one has currents.
/// @throws InvalidInput  a frame or recording that is not there, a mass that is not positive, no
///                       recording with a load or none without, no currents, or a bad file.
DriveGains find_drive_gains(const Model& arm, const std::vector<std::string>& recordings,
                            const std::vector<KnownMass>& loads,
                            const PreprocessingOptions& preprocessing, int threads = 0);

/// The arm with the gains that are identifiable, and their deviations; the others keep what the file says.
Model with_drive_gains(const Model& arm, const DriveGains& gains);

/// Reads "KG@FRAME" or "KG@FRAME=REC,REC". @throws InvalidInput  it is not of that form.
KnownMass parse_known_mass(const std::string& asked);

}  // namespace veridyn
