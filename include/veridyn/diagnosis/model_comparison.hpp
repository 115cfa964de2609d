#pragma once

#include <string>
#include <vector>

#include "veridyn/model/model.hpp"

namespace veridyn {

struct ComparisonOptions {
  /// Probability of reporting any difference between two models of an unchanged arm: p-values are
  /// corrected for the number of parameters (Holm, Scandinavian Journal of Statistics 6(2), 1979).
  double significance = 0.05;
};

enum class ComparisonVerdict {
  kSame,        ///< no parameter differs by more than its scatter explains
  kDiffer,      ///< at least one does
  kCannotTell,  ///< neither file carries the statistics of its identification
};

/// Provenance of a model file, and the statistics in it.
struct ComparedModel {
  std::string name;
  std::vector<std::string> recordings;
  int clusters = 0;         ///< 0: the file has no statistics, and its values count as exact
  VectorXd training_error;  ///< (n) relative; empty if the file does not have it
  std::string note;  ///< reason for which statistics of the file are not used; empty otherwise
};

/// The part of a robot file that differs. Models of one arm agree in kRobot, and constants are part of the geometry.
enum class StructureKind { kRobot, kEffect, kBody, kShape, kGeometry, kConstant, kGravity, kDriveGain, kFacts };

/// The kind's name in files: "effect", "drive_gain".
const char* name_of(StructureKind kind);

/// A difference between the two files that is not one of values.
struct StructureDifference {
  StructureKind kind = StructureKind::kEffect;
  std::string sentence;  ///< whole sentence for the user
};

/// A property of a joint's torque over standard_motion(), see ModelComparison::joints; kParameter: a base parameter or a
/// parameter of an effect.
enum class ComparedQuantity { kFriction, kOffset, kWeight, kWeightSlope, kInertia, kParameter };

/// The quantity's name in files: "weight_slope".
const char* name_of(ComparedQuantity quantity);

/// A quantity of both models, with the statistics of its difference.
struct ModelDifference {
  ComparedQuantity quantity = ComparedQuantity::kParameter;
  std::string name;        ///< leading standard parameter of the combination; else empty
  std::string expression;  ///< the combination, as `identify` writes it; else empty
  std::string unit;
  std::string effect;   ///< name of the effect, for its parameters; else empty
  std::string same_as;  ///< expression of the only base parameter in a joint's number
  /// For a parameter, the joint in whose torque it has the largest share.
  JointIndex joint;
  std::string coordinate;  ///< its name
  double before = 0.0;     ///< unconstrained least squares, to which the statistics belong
  double after = 0.0;
  double difference = 0.0;  ///< after - before
  /// Standard deviation of the difference, from clusters; NaN: neither model has any.
  double deviation = 0.0;
  double t = 0.0;
  /// Formula of Welch and Satterthwaite, from the contributions of the clusters.
  double degrees_of_freedom = 0.0;
  double low = 0.0, high = 0.0;     ///< 95 % interval of the difference, for this number alone
  double p_value = 1.0;
  double p_corrected = 1.0;  ///< Holm's correction over all compared numbers (same_as counts once)
  bool significant = false;
  VectorXd torque;  ///< (n) rms torque, over the standard motion, of a parameter's difference
  std::string sentence;  ///< whole sentence for a technician
};

/// Difference of the two models' predictions for one joint, over standard_motion().
struct TorqueDifference {
  std::string coordinate;
  std::string unit;
  double before = 0.0, after = 0.0;  ///< rms torque of either model
  double difference = 0.0;           ///< rms
  double share = 0.0;                ///< difference / before
  /// Rms difference due to scatter alone; NaN: neither model has any.
  double by_chance = 0.0;
  double bodies = 0.0;     ///< rms contribution of masses, moments and inertias
  double effects = 0.0;    ///< rms contribution of friction and the other effects
};

/// Differences between two models of one arm. Plain data: report and JSON show nothing else.
struct ModelComparison {
  std::string robot;
  double significance = 0.05;
  ComparisonVerdict verdict = ComparisonVerdict::kSame;
  ComparedModel before, after;
  /// Both were trained on the same motion: clusters are compared in pairs, so that model errors in
  /// a phase of the motion, which both share, do not count as scatter.
  bool same_motion = false;
  std::vector<StructureDifference> structure;
  /// Torques of every joint, in quantities that do not depend on the parametrisation. All over
  /// standard_motion(): friction = half the difference of the effects' mean torques forward and
  /// backward, offset = half their sum, weight = mean torque that holds the bodies at rest,
  /// weight_slope = amplitude with which it follows the joint's own angle, inertia = mean of M_ii
  /// with its rotor. Significant ones first, by p.
  std::vector<ModelDifference> joints;
  /// Base parameters. Significant ones first, by their share of the torque; then the others, by p.
  std::vector<ModelDifference> parameters;
  /// Parameters that only one of the models determines.
  std::vector<std::string> only_before, only_after;
  std::vector<TorqueDifference> torque;              ///< one per joint

  int compared() const;     ///< number of quantities, without those that have same_as
  int significant() const;  ///< number of significant differences

  /// Verdict, sentences and torques as text.
  std::string report() const;
};

/// Compares two models of one arm written by `identify` or `diagnose`, for example months apart, or before
/// and after a repair.
///
/// Standard parameters are not unique, so that base parameters are compared: every combination that the
/// recordings of both models determine, independent of the combinations in the second file. Base parameters
/// are correlated, so that the torques of every joint are compared as well. Each difference is divided by its
/// standard deviation from the clusters of both identifications. Files without statistics (written by hand)
/// count as exact.
///
/// @throws InvalidInput  the models are of two different robots (coordinates, frames or bodies), or
///                       one of them has no values.
ModelComparison compare(const Model& before, const Model& after,
                        const ComparisonOptions& options = {});

}  // namespace veridyn
