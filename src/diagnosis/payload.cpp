#include "veridyn/diagnosis/payload.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "diagnosis/shapes/candidate_data.hpp"
#include "diagnosis/evidence/payload_fit.hpp"
#include "diagnosis/evidence/silent_joints.hpp"
#include "diagnosis/evidence/numerics.hpp"
#include "math/digits.hpp"
#include "veridyn/effects/cause.hpp"
#include "veridyn/math/require.hpp"
#include "model/suggestion.hpp"
#include "identification/velocity_choice.hpp"
#include "recordings/named_recordings.hpp"
#include "veridyn/effects/effect_facts.hpp"

namespace veridyn {
namespace {

// The link that carries the frame, named after that frame.
void keep_only(const Model& arm, const std::string& link, AugmentedModel& augmented) {
  std::vector<std::string> names;
  for (const Frame& frame : arm.frames()) names.push_back(frame.name);
  const int wanted = arm.find_frame(link);
  require(wanted >= 0, "--link: found '", link, "', expected the name of a frame",
          did_you_mean(link, names), ".");
  auto& all = augmented.hypotheses;
  all.erase(std::remove_if(all.begin(), all.end(),
                           [&](const Hypothesis& h) {
                             return is_load(h) &&
                                    !same_link(arm, *frame_of(h.cause), {wanted});
                           }),
            all.end());
}

// Fall of the held-out error (phases of the motion, or recordings) for every hypothesis, beside
// changes of friction and offset: what more parameters explain in sample counts for nothing.
std::vector<double> held_out_gains(const CandidateData& q, const NormalBlocks& data,
                                   const Thresholds& limits) {
  ColumnSet base;
  for (const Hypothesis& h : q.augmented.hypotheses) {
    if (is_load(h)) continue;
    const ColumnSet own = columns_of(data, h);
    base.insert(base.end(), own.begin(), own.end());
  }
  DiagnosisOptions none;
  none.max_effects = 0;
  none.thresholds = limits;
  const Selection asked = select_effects(data, base, q.augmented.hypotheses, none);
  std::vector<double> out;
  for (const Evidence& e : asked.last_evaluated) out.push_back(e.collinear ? 0.0 : e.gain);
  return out;
}

// Best first; of links whose gains are a tie, as in a diagnosis, the outermost comes first: what
// hangs on the axis of a joint can be held by either of the links that it connects.
void put_best_first(const Model& model, const Thresholds& limits, std::vector<PayloadEstimate>& links) {
  std::stable_sort(links.begin(), links.end(),
                   [](const auto& a, const auto& b) { return a.gain > b.gain; });
  if (links.empty()) return;
  const double least = limits.tie * links.front().gain;
  const auto tied = std::find_if(links.begin(), links.end(),
                                 [&](const PayloadEstimate& l) { return !(l.gain > least); });
  const auto outermost = std::max_element(links.begin(), tied, [&](const auto& a, const auto& b) {
    return model.find_frame(a.frame) < model.find_frame(b.frame);
  });
  if (tied != links.begin()) std::rotate(links.begin(), outermost, std::next(outermost));
}

// Effects without values, such as friction of a CAD model, get them from these recordings; bodies and
// effects that have values keep them.
Model with_fitted_effects(const Model& cad, const std::vector<std::string>& recordings,
                          const IdentificationOptions& options) {
  ModelDescription d = cad.description();
  for (Frame& frame : d.frames) {
    if (frame.body) frame.body->fixed = true;
  }
  for (EffectTerm& term : d.effects) {
    if (has_axis_effect(term.effect)) term.fixed = EffectFacts(cad, term).has_values();
  }
  const Identification id = identify(Model(std::move(d)), recordings, {}, options);
  require(id.model.has_value(), "payload: found effects without values in '", cad.name(),
          "', and these recordings do not give them: ", id.reason);
  return *id.model;
}

// The arm with a body of this load on the link that carries it.
Model with_load(const Model& arm, const PayloadEstimate& load) {
  ModelDescription d = arm.description();
  Frame frame;
  frame.name = std::string(AddedLoad::kName) + "@" + load.frame;
  frame.parent = FrameIndex{arm.find_frame(load.frame)};
  frame.variable.coefficients = VectorXd::Zero(arm.joints());
  frame.body = Body{};
  frame.body->phi = load.phi;
  d.frames.push_back(std::move(frame));
  return Model(std::move(d));
}

// The values that an arm's effects were fitted to beside a load.
Model with_effects_of(const Model& arm, const Model& fitted) {
  ModelDescription d = arm.description();
  d.effects = fitted.effects();
  return Model(std::move(d));
}

// The report of an arm all of whose values are known.
PayloadReport find_on(const Model& model, const std::string& robot, const std::vector<std::string>& recordings,
                      IdentificationOptions options, const std::string& link, const Thresholds& limits) {
  PayloadReport out;
  out.smallest_gain = limits.smallest_change;
  out.robot = robot;
  leave_wrong_velocities_out(model, recordings, {}, options);
  options.choose_velocities = false;
  Identification start = evaluate(model, recordings, {}, options);
  if (!start.model) {
    out.reason = start.reason;
    return out;
  }
  const std::vector<ExcludedInterval> rows = silent_rows(start.factors);
  if (!rows.empty()) {
    std::vector<ExcludedInterval>& left_out = options.preprocessing.excluded_intervals;
    left_out.insert(left_out.end(), rows.begin(), rows.end());
    start = evaluate(model, recordings, {}, options);
  }
  CandidateList list;
  list.wanted = {AddedLoad::kName};
  for (const std::string& effect : elementary_effects()) list.wanted.push_back(effect);
  list.changes = true;
  list.limits = limits;
  AugmentedModel augmented = augmented_model(with_fixed_parameters(model), start.factors, list);
  if (!link.empty()) keep_only(model, link, augmented);
  const CandidateData q = prepare(start, std::move(augmented), true, recordings, {}, options);
  const NormalBlocks data(q.train, q.columns);
  const std::vector<double> gains = held_out_gains(q, data, limits);
  std::vector<const Hypothesis*> asked;
  for (const Hypothesis& h : q.augmented.hypotheses) {
    if (!is_load(h) || columns_of(data, h).empty()) continue;
    const auto twin = std::find_if(asked.begin(), asked.end(), [&](const Hypothesis* other) {
      return same_torques(data, *other, h);
    });
    const std::string name = words_of(model, h.cause).frame;
    if (twin != asked.end()) {
      out.links[twin - asked.begin()].others.push_back(name);
      continue;
    }
    asked.push_back(&h);
    out.links.push_back(fit_payload(q.augmented, data, h));
    out.links.back().gain = gains[&h - q.augmented.hypotheses.data()];
  }
  put_best_first(model, limits, out.links);
  out.error_before = start.train_error.relative;
  if (out.links.empty()) {
    out.reason = "no link moves enough in these recordings to feel a load";
  } else {
    out.error_with_drift = out.error_before.cwiseProduct(out.links.front().error_with_drift);
    out.error_after = out.error_before.cwiseProduct(out.links.front().error_with_load);
  }
  return out;
}

}  // namespace

PayloadReport find_payload(const Model& given_model, const Recordings& loaded,
                           const IdentificationOptions& given, const std::string& link,
                           const Thresholds& limits) {
  const auto begin = std::chrono::steady_clock::now();
  require(given_model.inertial_values().has_value(), "payload: robot '", given_model.name(),
          "' has no values; expected a MODEL that identify or diagnose wrote, or bodies of a CAD model.");
  NamedRecordings<IdentificationOptions> named(loaded, {}, given);
  keep_recordings(named.how, KeptRecordings::kManyQuestions);
  const std::vector<std::string>& recordings = named.train;
  PayloadReport out;
  if (has_all_values(given_model)) {
    out = find_on(given_model, given_model.name(), recordings, named.how, link, limits);
  } else {
    // Friction and load in turns: what is fitted without the load has a part of it.
    Model cad = with_fitted_effects(given_model, recordings, named.how);
    for (int turn = 0; turn < numerics::kPayloadTurns; ++turn) {
      out = find_on(cad, given_model.name(), recordings, named.how, link, limits);
      if (out.links.empty() || turn + 1 == numerics::kPayloadTurns) break;
      const Model loaded_arm = with_fitted_effects(with_load(given_model, out.links.front()), recordings, named.how);
      cad = with_effects_of(cad, loaded_arm);
    }
  }
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return out;
}

bool PayloadReport::found() const {
  if (links.empty() || links.front().gain < smallest_gain) return false;
  const PayloadEstimate& best = links.front();
  if (best.mass >= numerics::kHeaviest) return false;
  const bool has_moment = (best.moment.cwiseAbs() - best.moment_half_width).maxCoeff() > 0.0;
  return best.mass_low > 0.0 || has_moment;
}

std::string PayloadReport::report() const {
  if (links.empty()) return robot + ": no payload: " + reason + "\n";
  std::string out = found()
                        ? fmt::format("{}: a load of {:.3g} kg on {} (95 %: {:.3g} to {:.3g} kg)\n",
                                      robot, links.front().mass, links.front().frame,
                                      links.front().mass_low, links.front().mass_high)
                        : robot + ": no load that these recordings could be sure of\n";
  out += fmt::format("  {:<22}{:>14}  {:<19}{:>8}{:>8}{:>8}  {:>9}{:>10}\n", "if it is on", "mass kg",
                     "  95 %", "x m", "y m", "z m", "explains", "held out");
  for (const PayloadEstimate& link : links) {
    // A mass that may be zero has no centre.
    const bool told = link.mass_low > 0.0;
    const std::string mass = told ? fmt::format("{:.4g}", link.mass) : "not determined";
    const std::string range =
        link.mass >= numerics::kHeaviest ? fmt::format("{:.4g} or beyond", numerics::kHeaviest)
        : told ? fmt::format("{:.4g} to {:.4g}", link.mass_low, link.mass_high)
             : fmt::format("below {:.4g}", link.mass_high);
    std::string centre;
    for (size_t c = 0; c < link.seen.size(); ++c)
      centre += told && link.seen[c] ? fmt::format("{:>8.3f}", link.com[static_cast<Eigen::Index>(c)])
                                     : fmt::format("{:>8}", "-");
    const double explained = numerics::kPercent * std::max(0.0, link.explained);
    out += fmt::format("  {:<22}{:>14}  {:<19}{}  {:>7.1f} %{:>10.3f}\n", link.frame, mass, range, centre,
                       explained, link.gain == 0.0 ? 0.0 : link.gain);
    for (const std::string& other : link.others)
      out += fmt::format("    or on {}: it moves so alike that the torques cannot tell\n", other);
  }
  out += "in the order of held out: how much smaller the logarithm of the squared errors is, over all "
         "joints, on rows that the load was not fitted to; of a tie the outermost link comes first\n";
  const auto line = [&out](const char* name, const VectorXd& v) {
    out += fmt::format("  {:<22}", name);
    for (Eigen::Index i = 0; i < v.size(); ++i) out += in_percent(v[i], numerics::kNumberWidth);
    out += "\n";
  };
  out += "errors, % of the torque, per joint\n";
  line("the model as it is", error_before);
  line("friction, offset anew", error_with_drift);
  line("and the load", error_after);
  return out;
}

}  // namespace veridyn
