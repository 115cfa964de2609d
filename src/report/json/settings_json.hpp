#pragma once

#include "report/json/json_value.hpp"
#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Recordings, method and preprocessing, sufficient to repeat an identification.
Json settings_json(const Identification& id);

/// Share and lateness of the interpolated rows of a recording, {"share", "lateness"}.
Json filled_json(const RecordingError& recording);

/// Names, expressions, values and standard deviations of base parameters.
Json base_json(const std::vector<BaseValue>& base);

/// Recordings that were left out, with the reasons.
Json unused_json(const std::vector<UnusedRecording>& recordings);

/// Prediction errors on every row as recorded, and, if such rows exist, with repaired rows (`repaired`) and
/// without excluded intervals (`without_excluded`). With `repaired`, the first ones are repeated under their
/// name in earlier versions, `as_recorded`.
Json error_json(const PredictionError& error, const PredictionError& repaired,
                const PredictionError& without_excluded);

}  // namespace veridyn
