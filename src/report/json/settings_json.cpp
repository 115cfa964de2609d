#include "report/json/settings_json.hpp"

#include "veridyn/report/setting_names.hpp"

namespace veridyn {
namespace {

// First row and the row after the last; null instead of it: to the end.
Json rows_json(const PreprocessingOptions& o) {
  const Json end = o.row_count ? Json(o.first_row + *o.row_count) : Json();
  return Json::array({o.first_row, end});
}

Json error_figures(const PredictionError& error) {
  return {{"relative_error", json_list(error.relative)},
          {"max_error", json_list(error.maximum)},
          {"moving", {{"relative_error", json_list(error.moving_relative)}}}};
}

}  // namespace

Json settings_json(const Identification& id) {
  const PreprocessingOptions& o = id.preprocessing;
  const auto sources = [](const std::vector<RecordingError>& recordings) {
    return json_each(recordings, [&](const RecordingError& r) -> Json { return r.source; });
  };
  Json derived = json_each(o.derive_velocity_of, [&](JointIndex joint) -> Json { return joint.value + 1; });
  return {{"train", sources(id.train)},
          {"test", sources(id.test)},
          {"method", name_of(id.method)},
          {"weights", id.method == Method::kOls ? Json() : Json(name_of(id.weights))},
          {"condition", id.method == Method::kFeasible ? Json(name_of(id.condition)) : Json()},
          {"signs", id.method == Method::kFeasible ? Json(name_of(id.signs)) : Json()},
          {"prior", id.prior.empty() ? Json() : Json(id.prior)},
          {"filter_cutoff", o.cutoff},
          {"filter_order", o.order},
          {"filtering", name_of(o.filtering)},
          {"velocity", name_of(o.velocity)},
          {"velocity_derived_of", derived},
          {"stale_rows", name_of(o.stale_rows)},
          {"resample", o.rate},
          {"decimation", o.decimation},
          {"drop_start", o.drop_start},
          {"drop_end", o.drop_end},
          {"min_speed", o.min_speed},
          {"rows", rows_json(o)},
          {"test_rows", rows_json(id.test_preprocessing)},
          {"columns", o.columns},
          {"rate", o.header_rate}};
}

Json filled_json(const RecordingError& recording) {
  return {
      {"share", static_cast<double>(recording.filled.count) / static_cast<double>(recording.rows)},
      {"lateness", recording.filled.lateness()}};
}

Json base_json(const std::vector<BaseValue>& base) {
  return json_each(base, [&](const BaseValue& b) -> Json {
    return {{"name", b.name}, {"expression", b.expression}, {"value", b.value}, {"std", b.std}, {"unit", b.unit}};
  });
}

Json unused_json(const std::vector<UnusedRecording>& recordings) {
  return json_each(recordings, [&](const UnusedRecording& r) -> Json { return {{"file", r.source}, {"why", r.why}}; });
}

Json error_json(const PredictionError& error, const PredictionError& repaired,
                const PredictionError& without_excluded) {
  Json out = error_figures(error);
  if (repaired.relative.size() > 0) {
    out["as_recorded"] = error_figures(error);
    out["repaired"] = error_figures(repaired);
  }
  if (without_excluded.relative.size() > 0) out["without_excluded"] = error_figures(without_excluded);
  return out;
}

}  // namespace veridyn
