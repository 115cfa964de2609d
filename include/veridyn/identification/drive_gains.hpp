#pragma once

#include <optional>
#include <string>
#include <vector>

#include "veridyn/recordings/preprocessing.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// A load of known mass, rigidly mounted on a frame in some of the recordings. Its centre and its
/// inertia are estimated.
struct KnownMass {
  double mass = 0.0;  ///< [kg]
  std::string frame;
  /// Recordings that carry it, by the names given to find_drive_gains() or their file names. Empty:
  /// estimated from the data (allowed for a single known mass).
  std::vector<std::string> recordings;
};

/// The drive gain of one joint: its torque (or force) per ampere of motor current.
struct DriveGain {
  std::string coordinate;
  std::string unit;  ///< "N m/A" or "N/A"
  bool identifiable = false;
  std::string reason;      ///< reason why it is not identifiable
  double value = 0.0;      ///< best estimate, identifiable or not
  /// Standard deviation, from clusters; infinite if the data do not determine it.
  double deviation = 0.0;
  double low = 0.0;        ///< 95 % interval; infinite ends if the data do not bound it
  double high = 0.0;
  double in_file = 0.0;  ///< value of the robot file; 0: none
  /// Share of the known mass in the joint's rms torque, in the recordings that carry it.
  double share = 0.0;
};

/// Estimates for one known mass.
struct MountedLoad {
  KnownMass known;  ///< the known mass, and the recordings in which it is mounted
  bool identified = false;
  /// Centre of the load in its frame [m]; nullopt if the data do not determine it.
  std::optional<Eigen::Vector3d> centre;
  Eigen::Vector3d centre_deviation = Eigen::Vector3d::Zero();
};

struct DriveGains {
  std::string problem;  ///< reason why no gain was found, one line; empty: gains were found
  std::vector<DriveGain> joints;
  std::vector<MountedLoad> loads;
  std::vector<std::string> unloaded;  ///< recordings without a load
  int clusters = 0;                   ///< clusters of the jackknife

  /// Text with gains, intervals, and the reasons for gains that are not identifiable.
  std::string report() const;
};

/// Finds the drive gains of an arm that reports motor currents, from recordings with and without a known mass.
///
///   current_j = 1/K_j * (Y_j beta + Y_load,j [m, h, L] + effects_j)
///
/// The load's mass m is known; its first moment h and its inertia L, the arm's base parameters beta
/// and the effects are not. Least squares in beta, h, L, effects and 1/K together (the noise is in the
/// currents, on the left). The known mass fixes the scale of every joint that it loads, and the parameters that
/// joints share fix the scale of the others. Effects that vary from day to day (friction, offset) are separate
/// unknowns in every recording. Drive gains of the robot file are not used.
///
/// If the recordings with the load are not named, the division into two groups that fits best is
/// used; the heavier group carries it.
///
/// @param recordings  paths; every one has currents.
/// @throws InvalidInput  a frame or recording does not exist, a mass is not positive, no recording
/// with a load or none without, no currents, or a bad file.
DriveGains find_drive_gains(const Model& arm, const std::vector<std::string>& recordings,
                            const std::vector<KnownMass>& loads,
                            const PreprocessingOptions& preprocessing, int threads = 0);

/// The arm with the identifiable gains and their deviations; the others keep the value of the file.
Model with_drive_gains(const Model& arm, const DriveGains& gains);

/// Reads "KG@FRAME" or "KG@FRAME=REC,REC". @throws InvalidInput  the text has another form.
KnownMass parse_known_mass(const std::string& asked);

}  // namespace veridyn
