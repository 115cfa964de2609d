#pragma once

#include <vector>

#include "veridyn/diagnosis/diagnosis.hpp"
#include "veridyn/identification/rest_poses.hpp"

namespace veridyn {

/// diagnose() from poses at rest: the forces of position that gravity, offsets and dry friction leave
/// over, as springs, cables and harnesses exert them. Joints that stand still are asked about nothing.
///
/// A cause is accepted where the sum over joints of ln(mean square) on held-out parts of the training
/// poses falls by more than `smallest_gain`, that of its own joint in every part (of four or more in all
/// but one), and an F test over the poses is significant among as many questions. What only moves is in the
/// remarks.
///
/// @throws InvalidInput  the poses do not fit the arm.
Diagnosis diagnose_at_rest(const Model& arm, const std::vector<RestPoses>& train,
                           const std::vector<RestPoses>& test, const DiagnosisOptions& options = {});

}  // namespace veridyn
