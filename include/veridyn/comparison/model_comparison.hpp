#pragma once

#include <string>
#include <vector>

#include "veridyn/model/model.hpp"

namespace veridyn {

struct ComparisonOptions {
  /// Probability that two models of an unchanged arm are said to differ in anything: p-values are
  /// corrected for the number of parameters (Holm, Scandinavian Journal of Statistics 6(2), 1979).
  double significance = 0.05;
};

enum class ComparisonVerdict {
  kSame,        ///< no parameter differs more than the recordings' scatter explains
  kDiffer,      ///< at least one does
  kCannotTell,  ///< neither file carries the statistics of its identification
};

/// What a MODEL file tells of where it comes from.
struct ComparedModel {
  std::string name;
  std::vector<std::string> recordings;
  int clusters = 0;         ///< 0: the file has no statistics, its values are taken as exact
  VectorXd training_error;  ///< (n) relative; empty where the file does not say
  std::string note;         ///< why statistics that the file has are not used; empty otherwise
};

/// Something other than values that is not the same in both files.
struct StructureDifference {
  std::string kind;      ///< "effect", "shape", "geometry", "gravity", "drive_gain" or "facts"
  std::string sentence;  ///< in words
};

/// A number that both models give, with the statistics of its difference.
struct ModelDifference {
  /// "friction", "offset", "weight", "weight_slope" or "inertia" of a joint over standard_motion(),
  /// see ModelComparison::joints; "parameter" for base parameters and parameters of effects.
  std::string quantity;
  std::string name;        ///< Name of the standard parameter that leads the combination; else empty
  std::string expression;  ///< the combination, as `identify` writes it; else empty
  std::string unit;
  std::string effect;   ///< name of the effect, for its parameters; else empty
  std::string same_as;  ///< expression of the one base parameter that a joint's number consists of
  int joint = 0;        ///< from 1; of a parameter: where it makes the largest share of the torque
  std::string coordinate;  ///< its name
  double before = 0.0;     ///< least squares without conditions, which the statistics belong to
  double after = 0.0;
  double difference = 0.0;  ///< after - before
  double deviation = 0.0;   ///< Standard deviation of the difference, from clusters; NaN: neither model has any
  double t = 0.0;
  double degrees_of_freedom = 0.0;  ///< Welch and Satterthwaite, from how clusters contribute
  double low = 0.0, high = 0.0;     ///< 95 % interval of the difference, for this number alone
  double p_value = 1.0;
  double p_corrected = 1.0;  ///< Holm, over all numbers compared (same_as counts once)
  bool significant = false;
  VectorXd torque;  ///< (n) rms over the standard motion of what a parameter's difference makes
  std::string sentence;  ///< in a technician's words
};

/// How the predictions of the two models differ for one joint, over standard_motion().
struct TorqueDifference {
  std::string coordinate;
  std::string unit;
  double before = 0.0, after = 0.0;  ///< rms torque of either model
  double difference = 0.0;           ///< rms
  double share = 0.0;                ///< difference / before
  double by_chance = 0.0;  ///< rms that the scatter alone makes; NaN: neither model has any
  double bodies = 0.0;     ///< rms of what masses, moments and inertias contribute
  double effects = 0.0;    ///< rms of what friction and the other effects contribute
};

/// What differs between two models of one arm. Plain data: report and JSON show nothing else.
struct ModelComparison {
  std::string robot;
  double significance = 0.05;
  ComparisonVerdict verdict = ComparisonVerdict::kSame;
  ComparedModel before, after;
  /// Both learned from the same motion: their clusters are compared in pairs, so that what the
  /// model gets wrong in a phase of it, which is common to both, does not count as scatter.
  bool same_motion = false;
  std::vector<StructureDifference> structure;
  /// What every joint feels, in numbers that do not depend on how the model is parametrised. All
  /// over standard_motion(): friction = half the difference of the effects' mean torques forward
  /// and backward, offset = half their sum, weight = mean torque that holds the bodies at rest,
  /// weight_slope = amplitude with which it follows the joint's own angle, inertia = mean of M_ii
  /// with its rotor. Significant ones first, by p.
  std::vector<ModelDifference> joints;
  /// Base parameters. Significant ones first, by their share of the torque; then the others, by p.
  std::vector<ModelDifference> parameters;
  std::vector<std::string> only_before, only_after;  ///< what only one of them determines
  std::vector<TorqueDifference> torque;              ///< one per joint

  int compared() const;     ///< numbers, those with same_as left out
  int significant() const;  ///< Number of those that differ

  /// Verdict, sentences and torques as text.
  std::string report() const;
};

/// Compares two models that `identify` or `diagnose` wrote for one arm, months apart or before and
/// after a repair.
///
/// Standard parameters are not unique, so base parameters are compared: every combination that the
/// first model's recordings determine and the second one's do too, whatever combinations the second
/// file is written in. Base parameters lean on each other, so what every joint feels is compared as
/// well. Each difference is divided by its standard deviation from the clusters of both
/// identifications. Files without statistics (written by hand) count as exact.
///
/// @throws InvalidInput  the models are of two different robots (coordinates, frames or bodies), or
///                       one of them has no values.
ModelComparison compare(const Model& before, const Model& after,
                        const ComparisonOptions& options = {});

}  // namespace veridyn
