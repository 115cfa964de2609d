#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/identification/factor_set.hpp"

namespace veridyn {

/// One arm of a fleet and where its data lie.
struct FleetArm {
  std::string name;
  std::vector<std::string> files;  ///< recordings, or factor files of them
};

/// Reads a list of arms: one line `ARM,FILE` for every file (the header `arm,file` may lead;
/// spaces or a tab separate as well; `#` comments), files relative to the list.
/// @throws InvalidInput  the list cannot be read or is empty, or a line has not two fields.
std::vector<FleetArm> read_fleet(const std::string& path);

struct FleetOptions {
  PreprocessingOptions preprocessing;
  /// Chance that a fleet without an odd one has one named, over all that is looked at.
  double significance = 0.01;
  int threads = 0;
  std::function<void(const std::string&, double)> progress;
};

/// A parameter that every arm has for itself, over the fleet.
struct FleetSpread {
  std::string name;
  std::string unit;
  double median = 0.0;
  double spread = 0.0;  ///< robust standard deviation over the arms, 1.4826 of the median deviation
  int arms = 0;         ///< Number of arms that identify it
};

/// Something by which an arm stands out of its fleet.
struct FleetOutlier {
  std::string arm;
  std::string what;   ///< a parameter, or "torque_gain:JOINT"
  int joint = 0;      ///< from 1: where it shows most; 0: none in particular
  double value = 0.0; ///< the arm's
  double median = 0.0;
  double deviations = 0.0;  ///< robust standard deviations away from the fleet
};

/// An arm whose recordings did not go into the bodies that the fleet shares, for bodies of its own
/// explain more of its torques than of the others'. It may carry a tool or be another type; or what
/// the robot file does not know is larger on it than elsewhere. Its own values are still found.
struct FleetLeftOut {
  std::string arm;
  int joint = 0;                ///< from 1: where it shows most
  double with_fleet = 0.0;      ///< unexplained share of that joint's torque with the fleet's bodies
  double with_own = 0.0;        ///< and with bodies of its own
  double excess = 0.0;          ///< ln of the squared ratio of the two, the largest over the joints
  double median_excess = 0.0;   ///< of the fleet
  double deviations = 0.0;      ///< robust standard deviations from that median
};

/// An arm whose recordings do not determine its base parameters: whether its bodies are the fleet's
/// cannot be told, so that it takes no part.
struct UndeterminedArm {
  std::string arm;
  std::string why;
};

/// What one arm has for itself.
struct FleetMember {
  std::string name;
  int recordings = 0;
  double rows = 0.0;
  VectorXd own;             ///< values of the spreads' parameters; NaN where its data cannot tell
  VectorXd relative_error;  ///< (n) with the fleet's bodies and its own values
  VectorXd alone_error;     ///< (n) with bodies of its own
};

struct Fleet {
  std::string robot;
  int joints = 0;
  double rows = 0.0;
  VectorXd parameters;      ///< all standard parameters: bodies of the fleet, medians of the rest
  std::vector<BaseValue> base;  ///< the bodies' base parameters; std from leaving arms out
  std::vector<FleetSpread> spreads;
  std::vector<FleetMember> members;
  std::vector<FleetOutlier> outliers;     ///< the farthest first
  std::vector<FleetLeftOut> other_bodies; ///< arms that the shared bodies were not fitted to
  std::vector<UndeterminedArm> undetermined;  ///< arms that took no part
  std::vector<UnusedRecording> left_out;  ///< files that could not be used
  std::optional<Model> model;             ///< the arm with `parameters`; none where there is a reason
  std::string reason;                     ///< why the arms cannot answer, fewer than three being left

  std::string report() const;
};

/// One model for many arms of one type. Their bodies are alike; every effect of the robot file
/// (friction, offsets) and the gain of every joint's torque differ from arm to arm:
///
///   min over beta, eta_1 .. eta_N of  sum_a || W (Y_a beta + F_a eta_a - tau_a) ||^2
///
/// The matrix is a block arrow. Each arm's own columns are eliminated on its factor by QR, what is
/// left over beta is merged, beta is solved for and carried back to every eta_a: linear in the
/// arms, and no sample is looked at twice. Source: Bierman, 1977, ch. VII (considered and local
/// parameters).
///
/// Fewer than three arms with data of their own give no model, but a reason.
/// @throws InvalidInput  fewer than three arms are left because files cannot be used, or factors of
///   another arm.
Fleet identify_fleet(const Model& arm, const std::vector<FleetArm>& arms,
                     const FleetOptions& options = {});

/// The same from factors that are there already, one set per arm.
Fleet identify_fleet(const Model& arm, const std::vector<std::string>& names,
                     const std::vector<FactorSet>& factors, const FleetOptions& options = {});

}  // namespace veridyn
