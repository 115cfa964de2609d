#pragma once

#include "report/json/json_value.hpp"
#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Recordings, method and preprocessing, sufficient to repeat an identification.
Json settings_json(const Identification& id);

/// {"share", "lateness"} of the interpolated rows of a recording.
Json filled_json(const RecordingError& recording);

/// Names, expressions, values and standard deviations of base parameters.
Json base_json(const std::vector<BaseValue>& base);

/// Files that were left out, and why.
Json unused_json(const std::vector<UnusedRecording>& recordings);

/// Prediction errors: on every row as recorded; where they exist, also those with repaired rows
/// (`repaired`; `as_recorded` is then repeated, a name of earlier versions) and those without
/// excluded intervals (`without_excluded`).
Json error_json(const PredictionError& error, const PredictionError& repaired,
                const PredictionError& without_excluded);

}  // namespace veridyn
