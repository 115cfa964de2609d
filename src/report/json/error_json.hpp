#pragma once

#include "report/json/json_value.hpp"
#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Errors of prediction: those of every row as recorded; beside them, where there are any, those of
/// repaired rows (`repaired`, and `as_recorded` again, a name of earlier versions) and those without
/// excluded intervals (`without_excluded`).
Json error_json(const PredictionError& error, const PredictionError& repaired,
                const PredictionError& without_excluded);

}  // namespace veridyn
