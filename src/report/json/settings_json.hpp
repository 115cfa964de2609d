#pragma once

#include "report/json/json_value.hpp"
#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Recordings, method and preprocessing: what it takes to repeat an identification.
Json settings_json(const Identification& id);

/// {"share", "lateness"}: rows of a recording that were filled in.
Json filled_json(const RecordingError& recording);

}  // namespace veridyn
