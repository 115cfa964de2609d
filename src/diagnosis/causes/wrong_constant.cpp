#include "diagnosis/causes/wrong_constant.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "diagnosis/evidence/numerics.hpp"
#include "diagnosis/shapes/candidate_data.hpp"
#include "identification/many_recordings.hpp"
#include "veridyn/effects/cause.hpp"
#include "math/student_t.hpp"

namespace veridyn {
namespace {

// Gains of the best effects in place of a wrong constant.
std::vector<std::pair<Hypothesis, double>> effects_instead(const CandidateData& q,
                                                           const NormalBlocks& data,
                                                           const DiagnosisOptions& options) {
  DiagnosisOptions none = options;
  none.max_effects = 0;
  const Selection asked = select_effects(data, q.base, q.augmented.hypotheses, none);
  std::vector<Evidence> all = asked.last_evaluated;
  std::sort(all.begin(), all.end(),
            [](const Evidence& a, const Evidence& b) { return a.gain > b.gain; });
  std::vector<std::pair<Hypothesis, double>> out;
  std::set<Candidate> named;
  for (const Evidence& e : all) {
    const Hypothesis& h = q.augmented.hypotheses[e.hypothesis];
    if (e.collinear || e.infeasible_sign || !named.insert(h).second) continue;
    out.emplace_back(h, e.gain);
  }
  return out;
}

}  // namespace

double correction_gain(const Model& corrected, const CandidateData& q, const NormalBlocks& data,
                       const std::vector<std::string>& train, const DiagnosisOptions& options) {
  const IdentificationOptions& how = options.identification;
  std::vector<CompressedRecording> factors =
      compress_all(corrected, train, how.preprocessing, how.threads);
  const int blocks = blocks_that_fit(corrected, static_cast<int>(train.size()));
  for (CompressedRecording& r : factors) merge_blocks(r, blocks);
  const std::vector<std::string> names = parameter_names(standard_parameters(corrected));
  std::vector<std::string> columns;
  ColumnSet base;
  for (const int j : base_parameters(corrected).independent) {
    base.push_back(static_cast<int>(columns.size()));
    columns.push_back(names[j]);
  }
  return fold_gain(data, q.base, NormalBlocks(factors, columns), base, hold_out(options.thresholds));
}

std::optional<WrongConstant> wrong_constant(const Model& arm,
                                      const std::vector<GeometryFinding>& geometry,
                                      const CandidateData& q, const NormalBlocks& data,
                                      const std::vector<std::string>& train,
                                      const DiagnosisOptions& options) {
  GeometryFinding best = geometry.front();
  const double profiled = best.gain;
  best.gain = correction_gain(with_constant(arm, best.constant, best.found), q, data, train, options);
  const Thresholds& limits = options.thresholds;
  if (best.gain < limits.constant_gain * limits.smallest_gain) return std::nullopt;
  WrongConstant out;
  out.instead = effects_instead(q, data, options);
  const auto& instead = out.instead;
  if (!instead.empty() && best.gain < limits.rival_share * instead.front().second)
    return std::nullopt;
  Finding& f = out.finding;
  f.rank = 1;
  f.cause = KinematicError{best.constant};
  f.joint = acting_joint(arm, f.cause);
  f.unit = unit_of(best.constant);
  const double t = student_t_quantile(numerics::kOutside, best.degrees_of_freedom);
  f.parameters.push_back({"value", f.unit, best.found, best.found - t * best.deviation,
                          best.found + t * best.deviation});
  f.parameters.push_back({"correction", f.unit, best.found - best.stated,
                          best.found - best.stated - t * best.deviation,
                          best.found - best.stated + t * best.deviation});
  f.gain = best.gain;
  f.p_value = student_t_two_sided(
      (best.found - best.stated) / std::max(best.deviation, numerics::kTiny),
      best.degrees_of_freedom);
  for (size_t k = 1; k < geometry.size(); ++k) {
    if (geometry[k].gain < limits.rival_share * profiled) continue;
    f.rivals.push_back(
        {KinematicError{geometry[k].constant},
         "another constant, " + words_for(arm, geometry[k].constant) + ", would explain as much"});
  }
  for (const auto& [h, gain] : instead) {
    if (gain < limits.weaker_rival * best.gain || static_cast<double>(f.rivals.size()) > limits.constant_rivals) break;
    f.rivals.push_back(
        {h.cause, fmt::format("hides it: alone it gains {:.0f} % as much",
                              numerics::kPercent * gain / best.gain)});
  }
  const bool angle = f.unit == "rad";
  const auto shown = [&](double v) {
    return angle ? fmt::format("{:.4g} deg", numerics::kDegrees * v)
                 : fmt::format("{:.5g} {}", v, f.unit);
  };
  f.phrase = fmt::format("{} is {} there; the recordings ask for {}", words_for(arm, best.constant),
                         shown(best.stated), shown(best.found));
  return out;
}

}  // namespace veridyn
