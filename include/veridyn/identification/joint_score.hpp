#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Errors of a model on the torque of one joint, relative to that torque; see PredictionError.
struct JointScore {
  JointIndex joint;
  std::string name;
  double error = 0.0;    ///< ||tau - tau_model|| / ||tau||
  double maximum = 0.0;  ///< max|tau - tau_model| / max|tau|
  double moving = 0.0;   ///< `error` on samples at which the joint moves
  double floor = 0.0;    ///< relative difference between repeats of the motion; NaN where nothing repeats
};
/// Writes "joint 2 (pitch): error 3.21 % of its torque, 1.1 % between repeats".
std::ostream& operator<<(std::ostream& out, const JointScore& score);

/// Scores of an identified model on recordings that were not used in its fit, with the preprocessing
/// of the identification's test recordings.
/// @throws InvalidInput  there is no model (see status), or a recording is bad or does not fit the arm.
std::vector<JointScore> validate(const Identification& fit, const Recordings& recordings);

/// Scores of any arm with values. @throws InvalidInput  as evaluate(); recordings without usable rows.
std::vector<JointScore> validate(const Model& arm, const Recordings& recordings,
                                 const IdentificationOptions& options = {});

}  // namespace veridyn
