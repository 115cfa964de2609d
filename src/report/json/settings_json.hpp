#pragma once

#include "report/json/json_value.hpp"
#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Recordings, method and preprocessing, sufficient to repeat an identification.
Json settings_json(const Identification& id);

/// {"share", "lateness"} of the interpolated rows of a recording.
Json filled_json(const RecordingError& recording);

}  // namespace veridyn
