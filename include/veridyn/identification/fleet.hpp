#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/identification/factor_set.hpp"

namespace veridyn {

/// One arm of a fleet and its data.
struct FleetArm {
  std::string name;
  std::vector<std::string> files;  ///< recordings, or factor files of them
};

/// Reads a list of arms: one line `ARM,FILE` for every file (an optional header `arm,file`; spaces
/// or a tab separate as well; `#` comments), files relative to the list.
/// @throws InvalidInput  the list cannot be read or is empty, or a line does not have two fields.
std::vector<FleetArm> read_fleet(const std::string& path);

struct FleetOptions {
  PreprocessingOptions preprocessing;
  /// Probability of reporting an outlier in a fleet without one, over all tested quantities.
  double significance = 0.01;
  int threads = 0;
  std::function<void(const std::string&, double)> progress;
};

/// Distribution over the fleet of a parameter that differs from arm to arm.
struct FleetSpread {
  std::string name;
  std::string unit;
  double median = 0.0;
  double spread = 0.0;  ///< robust standard deviation over the arms: 1.4826 times the median deviation
  int arms = 0;         ///< number of arms that identify it
};

/// A quantity in which an arm is an outlier of its fleet.
struct FleetOutlier {
  std::string arm;
  std::string what;   ///< a parameter, or "torque_gain:JOINT"
  std::optional<JointIndex> joint;  ///< nullopt for a parameter of no joint
  double value = 0.0; ///< value of the arm
  double median = 0.0;
  double deviations = 0.0;  ///< robust standard deviations away from the fleet
};

/// An arm that is excluded from the fit of the shared bodies, because its own bodies improve its fit more
/// than they do for the other arms. It may carry a tool, be of another type, or have larger effects that the
/// robot file does not contain. Its own values are estimated nevertheless.
struct FleetLeftOut {
  std::string arm;
  JointIndex joint;             ///< the joint of the largest deviation
  double with_fleet = 0.0;  ///< unexplained share of that joint's torque with the fleet's bodies
  double with_own = 0.0;        ///< unexplained share with bodies of its own
  double excess = 0.0;          ///< ln of the squared ratio of the two, the largest over the joints
  double median_excess = 0.0;   ///< median of `excess` over the fleet
  double deviations = 0.0;      ///< robust standard deviations from that median
};

/// An arm whose recordings do not determine its base parameters. It is left out, because its
/// bodies cannot be compared with those of the fleet.
struct UndeterminedArm {
  std::string arm;
  std::string why;
};

/// Results of one arm.
struct FleetMember {
  std::string name;
  int recordings = 0;
  double rows = 0.0;
  VectorXd own;  ///< values of its own parameters; NaN if its data do not determine them
  VectorXd relative_error;  ///< (n) relative error with the fleet's bodies and the arm's own values
  VectorXd alone_error;     ///< (n) relative error with the arm's own bodies
};

struct Fleet {
  std::string robot;
  int joints = 0;
  double rows = 0.0;
  VectorXd parameters;  ///< all standard parameters: shared bodies, medians of the individual ones
  std::vector<BaseValue> base;  ///< base parameters of the shared bodies; std by leaving arms out
  std::vector<FleetSpread> spreads;
  std::vector<FleetMember> members;
  std::vector<FleetOutlier> outliers;     ///< largest deviation first
  std::vector<FleetLeftOut> other_bodies; ///< arms to which the shared bodies were not fitted
  std::vector<UndeterminedArm> undetermined;  ///< arms that were left out
  std::vector<UnusedRecording> unusable_recordings;  ///< files that could not be used
  std::vector<std::string> remarks;       ///< files whose velocities were taken from the positions
  std::optional<Model> model;  ///< the arm with `parameters`; nullopt if there is a reason
  std::string reason;  ///< reason for a missing model: fewer than three arms remained

  std::string report() const;
};

/// One model for many arms of one type. Their bodies are the same; every effect of the robot file
/// (friction, offsets) and the torque gain of every joint differ from arm to arm:
///
///   min over beta, eta_1 .. eta_N of  sum_a || W (Y_a beta + F_a eta_a - tau_a) ||^2
///
/// The matrix is a block arrow. Each arm's own columns are eliminated from its factor by QR, the rest over beta is
/// merged, beta is solved for and substituted for every eta_a: the cost is linear in the number of arms, and
/// samples are read once. Source: Bierman, 1977, ch. VII (considered and local parameters).
///
/// With fewer than three arms with data of their own the result has a reason and no model.
/// @throws InvalidInput  fewer than three arms are left because files cannot be used, or factors
/// belong to another arm.
Fleet identify_fleet(const Model& arm, const std::vector<FleetArm>& arms,
                     const FleetOptions& options = {});

/// identify_fleet() from factors in memory, one set per arm.
Fleet identify_fleet(const Model& arm, const std::vector<std::string>& names,
                     const std::vector<FactorSet>& factors, const FleetOptions& options = {});

}  // namespace veridyn
