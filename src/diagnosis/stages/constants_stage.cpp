#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <variant>

#include "diagnosis/causes/geometry.hpp"
#include "diagnosis/causes/wrong_constant.hpp"
#include "diagnosis/evidence/held_out.hpp"
#include "diagnosis/evidence/effect_facts.hpp"
#include "diagnosis/findings/finding_words.hpp"
#include "diagnosis/stages/channel_correction.hpp"
#include "diagnosis/stages/diagnosis_state.hpp"
#include "veridyn/effects/cause.hpp"

// Compares wrong constants of the robot file with sensor errors and a tilt of the base, which have
// nearly the same effect: a DH angle and the zero of an encoder, the pose of the first frame and
// the tilt of the base. Both are evaluated after complete correction; the sensor error is the more
// frequent fault, and is preferred if it explains as much.

namespace veridyn {
namespace {

// Channel errors whose gain beside the base is large enough to replace the constant.
std::vector<Hypothesis> channels_in_question(const DiagnosisState& x, const CandidateTests& asked,
                                             const WrongConstant& wrong) {
  std::vector<Hypothesis> out;
  for (const auto& [h, gain] : wrong.instead) {
    const bool near = gain > x.options.thresholds.weaker_rival * wrong.finding.gain;
    const bool commoner = is_channel(h) && find_effect(effect_of(h.cause)).traits().stage == DiagnosisStage::kChannel;
    if (commoner && near && out.size() < 2 && !columns_of(asked.data, h).empty())
      out.push_back(h);
  }
  return out;
}

// The p value of a channel's error beside the base, as one of all causes that are asked about; nothing: it is not
// certain enough.
std::optional<double> sure_beside_base(const CandidateTests& asked, const Hypothesis& h, const DiagnosisOptions& options) {
  const std::vector<Hypothesis>& all = asked.q.augmented.hypotheses;
  const auto at = std::find_if(all.begin(), all.end(), [&h](const Hypothesis& other) { return same_candidate(other, h); });
  const auto index = static_cast<int>(at - all.begin());
  const Examiner examiner(asked.data, asked.q.base, all, options);
  const auto base = examiner.baseline({});
  const double p = examiner.p_value(index, *base, examiner.without_clusters(*base));
  return p < examiner.limit(index) ? std::optional<double>(p) : std::nullopt;
}

// The constant that a channel's error took the place of.
Rival as_rival(const Model& arm, const Finding& wrong, double share) {
  return {wrong.cause, fmt::format("{} It gains {:.0f} % as much.", sentence(arm, wrong),
                                   numerics::kPercent * share)};
}

// True if what held-out parts of the training recordings say of a finding keeps it; else a line says so.
bool is_borne_out(const Finding& f, DiagnosisState& x) {
  if (x.options.extended == ExtendedModel::kAllFindings || f.status == FindingStatus::kConfirmed) return true;
  x.d.not_supported.push_back({f.cause, f.p_value, "held-out parts of the training recordings contradict it"});
  return false;
}

// Takes a channel's error in place of a constant. False if it is not certain enough, or contradicted: then it is not
// asked about again.
bool correct(const CandidateTests& asked, const Hypothesis& h, const CorrectedChannel& channel,
             double gain, const Finding& instead, DiagnosisState& x) {
  const std::optional<double> p_value = sure_beside_base(asked, h, x.options);
  if (!p_value) return false;
  Finding f = channel_finding(asked.q, h, channel.values, channel.half_widths);
  f.gain = gain;
  f.p_value = *p_value;
  f.test_before = x.start.test_error.relative;
  f.test_after = channel.corrected.test_error.relative;
  f.folds_before = x.fold_errors(x.start).relative();
  f.folds_after = x.fold_errors(channel.corrected).relative();
  f.explains = explained_share(f.test_before, f.test_after, x.d.baseline);
  f.status = status_of(f);
  if (!is_borne_out(f, x)) {
    x.refused.insert(h);
    return false;
  }
  f.rivals.push_back(as_rival(x.arm, instead, instead.gain / gain));
  // Alternatives to the constant are alternatives to the channel error.
  for (const Rival& other : instead.rivals) {
    if (std::holds_alternative<KinematicError>(other.cause)) f.rivals.push_back(other);
  }
  x.d.findings.push_back(std::move(f));
  x.start = channel.corrected;
  return true;
}

// Applies the conditions of other causes: significance among all constants that were profiled (Bonferroni), and an
// interval without zero. A constant that fails is reported as not supported.
bool is_sure(const Finding& f, DiagnosisState& x) {
  const std::vector<FrameConstant> constants = row_constants(x.arm);
  const auto profiled = std::count_if(constants.begin(), constants.end(), [&x](const FrameConstant& c) {
    return x.tests_cause(KinematicError{c});
  });
  const bool holds_zero =
      std::any_of(f.parameters.begin(), f.parameters.end(), [](const FoundParameter& p) {
        return p.name == "correction" && p.low <= 0.0 && p.high >= 0.0;
      });
  if (!holds_zero && f.p_value < x.options.thresholds.significance / static_cast<double>(profiled)) return true;
  x.d.not_supported.push_back({f.cause, f.p_value,
                               holds_zero ? "the interval of its correction holds zero"
                                          : "its value is not certain enough among so many constants"});
  return false;
}

}  // namespace

void correct_constants(DiagnosisState& x) {
  if (x.d.changes || x.names_left() < 1 || !x.tests_effect(KinematicError::kName)) return;
  const Model arm = *x.start.model;
  std::vector<GeometryFinding> geometry =
      profile_geometry(arm, x.train, x.options.identification, x.options.thresholds);
  geometry.erase(std::remove_if(geometry.begin(), geometry.end(),
                                [&x](const GeometryFinding& g) { return !x.tests_cause(KinematicError{g.constant}); }),
                 geometry.end());
  if (geometry.empty()) return;
  const CandidateTests asked = prepare_tests(x, x.list(), x.start);
  std::optional<WrongConstant> wrong =
      wrong_constant(arm, geometry, asked.q, asked.data, x.train, x.options);
  if (!wrong) return;
  for (const Hypothesis& h : channels_in_question(x, asked, *wrong)) {
    const std::optional<CorrectedChannel> channel = correct_channel(x, asked, h);
    if (!channel) continue;
    const double gain = correction_gain(*channel->corrected.model, asked.q, asked.data, x.train,
                                        x.options);
    if (gain < x.options.thresholds.commoner_cause * wrong->finding.gain) continue;
    if (correct(asked, h, *channel, gain, wrong->finding, x)) return;
  }
  if (!is_sure(wrong->finding, x)) return;
  const Identification corrected =
      x.fit(with_constant(arm, geometry.front().constant, geometry.front().found));
  if (!corrected.model) return;
  Finding& f = wrong->finding;
  f.test_before = x.start.test_error.relative;
  f.test_after = corrected.test_error.relative;
  f.folds_before = x.fold_errors(x.start).relative();
  f.folds_after = x.fold_errors(corrected).relative();
  f.explains = explained_share(f.test_before, f.test_after, x.d.baseline);
  f.status = status_of(f);
  if (!is_borne_out(f, x)) return;
  x.d.findings.push_back(std::move(f));
  x.start = corrected;
}

}  // namespace veridyn
