#pragma once

#include <vector>

#include "veridyn/diagnosis/diagnosis.hpp"
#include "veridyn/identification/rest_poses.hpp"

namespace veridyn {

/// diagnose() from poses at rest: forces that depend on the position in addition to gravity, offsets and dry
/// friction, such as those of springs, cables and harnesses. Joints that do not move between the poses are
/// excluded.
///
/// A cause is accepted if three conditions hold. In cross-validation on the training poses the sum over joints of
/// ln(mean square residual) falls by more than `smallest_gain`; the error of the cause's own joint falls in every part
/// (of four or more parts in all but one); an F test over the poses is significant after Bonferroni's correction.
///
/// @throws InvalidInput  the poses do not fit the arm.
Diagnosis diagnose_at_rest(const Model& arm, const std::vector<RestPoses>& train,
                           const std::vector<RestPoses>& test, const DiagnosisOptions& options = {});

}  // namespace veridyn
