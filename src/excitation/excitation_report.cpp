#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "veridyn/excitation/excitation.hpp"

namespace veridyn {

const char* name_of(ExcitationCriterion criterion) {
  if (criterion == ExcitationCriterion::kDiscriminate) return "discriminate";
  if (criterion == ExcitationCriterion::kAOptimal) return "a-optimal";
  return criterion == ExcitationCriterion::kCondition ? "condition" : "d-optimal";
}

const char* name_of(ExcitationSolver solver) {
  if (solver == ExcitationSolver::kIpopt) return "ipopt";
  if (solver == ExcitationSolver::kNlopt) return "nlopt";
  return solver == ExcitationSolver::kRandom ? "random" : "interior-point";
}

const char* name_of(ColumnScaling scaling) {
  if (scaling == ColumnScaling::kOrthogonal) return "orthogonal";
  return scaling == ColumnScaling::kNorm ? "norm" : "none";
}

namespace {

constexpr const char* kGap = "gap of ";  // beginning of the name of a limit between links
constexpr size_t kNamedGaps = 5;         // largest number of such limits in the text
constexpr size_t kNamed = 5;  // largest number of entries in the text; the JSON has all

std::string margin_line(const LimitMargin& m) {
  const auto bound = [](double value) {
    return std::isfinite(value) ? fmt::format("{:.4g}", value) : std::string("open");
  };
  return fmt::format("{:<28}{:>8} {:>21} {:>21} {:>10.3g}\n", m.name, m.unit,
                     fmt::format("{:.4g} .. {:.4g}", m.lowest, m.highest),
                     bound(m.lower) + " .. " + bound(m.upper), m.margin);
}

std::string weakest_text(const Excitation& e) {
  std::string out = "Hardest to tell from each other:";
  for (size_t k = 0; k < std::min(kNamed, e.weakest.size()); ++k)
    out += fmt::format("{} {} ({:.2f})", k > 0 ? "," : "", e.weakest[k].first, e.weakest[k].second);
  return out + ".\n";
}

std::string prediction_text(const Prediction& p) {
  std::vector<std::string> shares;
  for (const double noise : p.noise.deviation) shares.push_back(fmt::format("{:.2g}", noise));
  std::string out = fmt::format(
      "Predicted standard deviations of the base parameters ({}): median {:.3g} %, mean {:.3g} % "
      "of the values {}, with torque noise of {} N m (N) ({}), one independent sample in {:.2g} s.\n",
      p.parameters.size(), 100.0 * p.median_relative, 100.0 * p.mean_relative, p.values,
      fmt::join(shares, ", "), p.noise.source, p.noise.seconds);
  std::vector<PredictedParameter> worst = p.parameters;
  std::sort(worst.begin(), worst.end(),
            [](const auto& a, const auto& b) { return a.relative > b.relative; });
  for (size_t k = 0; k < std::min(kNamed, worst.size()); ++k) {
    out += fmt::format("  {:<50} {:>10.3g} +- {:.3g} {}\n", worst[k].name, worst[k].value,
                       worst[k].deviation, worst[k].unit);
  }
  return out;
}

std::string essential_text(const EssentialParameters& p) {
  std::string out = fmt::format(
      "Condition number {:.4g} for {} essential parameters; columns as they are {:.4g}, scaled by "
      "their range {:.4g}.\n",
      p.condition_number, p.count, p.plain_condition_number, p.range_condition_number);
  if (p.non_essential.empty()) return out;
  out +=
      fmt::format("Regrouped with them, since they would add less than {:.3g} %:", 100.0 * p.share);
  for (size_t k = 0; k < p.non_essential.size(); ++k) {
    out += fmt::format("{} {} ({:.2g} %)", k > 0 ? "," : "", p.non_essential[k].first,
                       100.0 * p.non_essential[k].second);
  }
  return out + ".\n";
}

// Text of a share in percent.
std::string percent(double share) {
  return std::isfinite(share) ? fmt::format("{:.0f} %", 100.0 * share) : "-";
}

std::string limit_use_text(const Excitation& e) {
  std::string out =
      fmt::format("{:<28}{:>10}{:>10}{:>10}   used of its limits{}\n", "joint", "range", "speed",
                  "torque",
                  e.limit_share > 0.0 ? fmt::format(", of which {:.3g} may be", e.limit_share)
                                      : ", but for what a safety supervisor needs");
  for (size_t i = 0; i < e.used.size(); ++i) {
    const UsedLimits& u = e.used[i];
    out += fmt::format("{:<28}{:>10}{:>10}{:>10}\n", e.joints[i], percent(u.range),
                       percent(u.velocity), percent(u.effort));
  }
  return out;
}

std::string quality_text(const Excitation& e) {
  std::string out = fmt::format(
      "Condition number {:.4g} for {} base parameters (a random motion: {:.4g}); columns as they "
      "are {:.4g}, scaled by their range {:.4g}, orthogonal at random states {:.4g}; ln det "
      "{:.4g}.\n",
      e.condition_number, e.base_parameters, e.start_condition_number, e.plain_condition_number,
      e.range_condition_number, e.orthogonal_condition_number, e.log_determinant);
  if (e.condition_number_with_given != e.condition_number) {
    out += fmt::format("Together with the given recordings the condition number is {:.4g}.\n",
                       e.condition_number_with_given);
  }
  if (e.essential) out += essential_text(*e.essential);
  out += weakest_text(e);
  if (e.prediction) out += prediction_text(*e.prediction);
  if (!e.discrimination) return out;
  const Discrimination& d = *e.discrimination;
  out += fmt::format(
      "Of what the rest of the model leaves of {}, {:.3g} % cannot be taken for the other cause; "
      "of "
      "{}, {:.3g} %{}.\n",
      d.first, 100.0 * d.first_share, d.second, 100.0 * d.second_share,
      d.bodies_known ? ", with the bodies' parameters known (a change of an identified arm)" : "");
  return out;
}

}  // namespace

std::vector<std::string> Excitation::warnings() const {
  std::vector<std::string> out;
  for (size_t i = 0; i < used.size(); ++i) {
    const UsedLimits& u = used[i];
    if (!(u.range < kLittleUse) || !(u.velocity < kLittleUse)) continue;
    std::string why = "no limit holds it there: another --seed, more --starts or a higher --frequency move it more";
    if (!u.held_by.empty()) {
      why = "held by the " + u.held_by.front();
      for (size_t k = 1; k < u.held_by.size(); ++k) why += ", the " + u.held_by[k];
    }
    out.push_back(fmt::format("{} uses {} of its range and {} of its speed, {}", joints[i],
                              percent(u.range), percent(u.velocity), why));
  }
  return out;
}

std::string Excitation::report() const {
  std::string out;
  for (const std::string& caution : cautions) out += caution + ".\n";
  if (speed < 1.0)
    out += fmt::format("The path is played at {:.3g} of its designed speed.\n", speed);
  else
    out += "First run: the same command with --speed 0.5 writes this path at half its speed.\n";
  out += fmt::format(
      "Excitation of {}: {} periods of {:.4g} s, {} harmonics, {:.4g} s in all, from rest to "
      "rest.\n",
      robot, periods, trajectory.period(), trajectory.harmonics(), periods * trajectory.period());
  if (slow_seconds > 0.0)
    out +=
        fmt::format("Slow passes of one joint after the other follow: {:.4g} s.\n", slow_seconds);
  if (status == ExcitationStatus::kRankDeficient) {
    out +=
        fmt::format("No motion was found that excites all {} base parameters.\n", base_parameters);
  } else if (status == ExcitationStatus::kLimitsNotMet) {
    out += "No motion was found within the limits; this one crosses them least.\n";
  } else {
    out += quality_text(*this);
  }
  if (!friction_remark.empty()) out += friction_remark + "\n";
  out += fmt::format("{}{}, {} evaluations, {:.1f} s.\n",
                     interrupted ? "Interrupted; the best so far. " : "", name_of(solver),
                     evaluations, seconds);
  out += limit_use_text(*this);
  out += fmt::format("{:<28}{:>8} {:>21} {:>21} {:>10}\n", "limit", "unit", "motion", "limit",
                     "margin");
  std::vector<LimitMargin> gaps;
  for (const LimitMargin& m : margins) {
    if (m.name.rfind(kGap, 0) == 0) gaps.push_back(m);
    else out += margin_line(m);
  }
  std::sort(gaps.begin(), gaps.end(), [](const auto& a, const auto& b) { return a.margin < b.margin; });
  for (size_t k = 0; k < std::min(kNamedGaps, gaps.size()); ++k) out += margin_line(gaps[k]);
  if (gaps.size() > kNamedGaps) out += fmt::format("{} more pairs of links stay farther apart.\n", gaps.size() - kNamedGaps);
  return out;
}

}  // namespace veridyn
