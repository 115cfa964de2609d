#include "report/json/error_json.hpp"

namespace veridyn {
namespace {

Json figures(const PredictionError& error) {
  return {{"relative_error", json_list(error.relative)},
          {"max_error", json_list(error.maximum)},
          {"moving", {{"relative_error", json_list(error.moving_relative)}}}};
}

}  // namespace

Json error_json(const PredictionError& error, const PredictionError& repaired,
                const PredictionError& without_excluded) {
  Json out = figures(error);
  if (repaired.relative.size() > 0) {
    out["as_recorded"] = figures(error);
    out["repaired"] = figures(repaired);
  }
  if (without_excluded.relative.size() > 0) out["without_excluded"] = figures(without_excluded);
  return out;
}

}  // namespace veridyn
