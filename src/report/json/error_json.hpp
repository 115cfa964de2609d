#pragma once

#include "report/json/json_value.hpp"
#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Prediction errors: on every row as recorded; where they exist, also those with repaired rows
/// (`repaired`; `as_recorded` is then repeated, a name of earlier versions) and those without
/// excluded intervals (`without_excluded`).
Json error_json(const PredictionError& error, const PredictionError& repaired,
                const PredictionError& without_excluded);

}  // namespace veridyn
