#include "diagnosis/stages/asked_tables.hpp"

#include <algorithm>

#include "diagnosis/unnamed/dependence.hpp"
#include "diagnosis/unnamed/tables.hpp"
#include "effects/tabulated_force.hpp"
#include "math/student_t.hpp"

namespace veridyn {
namespace {

struct AskedTable {
  EffectTerm term;
  MotionSignal signal;
};

// A curve that is nothing yet, between the ends of the signal.
std::vector<EffectTerm> empty_table(const Model& arm, JointIndex joint, const MotionSignal& s) {
  UnnamedShape nothing;
  for (const double x : {s.low, s.high}) {
    CurvePoint p;
    p.at = {x};
    nothing.curve.push_back(std::move(p));
  }
  std::vector<EffectTerm> out = tables_of(arm, joint, nothing, {s});
  for (EffectTerm& term : out) {
    for (const EffectParameter& p : find_effect(term.effect).parameters()) term.values.erase(p.name);
  }
  return out;
}

Hypothesis hypothesis_of(const EffectTerm& term, JointIndex joint, const std::string& signal) {
  Hypothesis h;
  h.cause = NewEffect{term.effect, joint};
  h.joint = joint;
  h.signs.assign(find_effect(term.effect).parameters().size(), ParameterSign::kAny);
  h.repeats = false;
  h.extrapolates = true;
  h.stage = static_cast<int>(DiagnosisStage::kFriction);
  h.axis = term.axis;
  h.signal = signal;
  return h;
}

// Adds values at the nodes with their intervals, except for nodes that the arm never reached.
void add_nodes(const CandidateTests& asked, const Selection& selection, const Hypothesis& h,
               const MotionSignal& s, UnnamedShape& shape) {
  const std::vector<EffectParameter> parameters = find_effect(kTabulatedForce).parameters();
  const double t = student_t_quantile(numerics::kOutside, selection.degrees_of_freedom);
  for (int k = 0, p = 0; k < kTableNodes; ++k) {
    CurvePoint point;
    point.at = {table_node(s.low, s.high, k)};
    if (k == kTableNodes / 2) {
      shape.curve.push_back(std::move(point));
      continue;
    }
    const std::string& name = h.columns[p++];
    for (size_t c = 0; c < selection.columns.size(); ++c) {
      if (asked.data.names()[selection.columns[c]] != name) continue;
      const auto at = static_cast<Eigen::Index>(c);
      const double half = t * selection.standard_deviations[at];
      point.value = selection.values[at];
      point.low = point.value - half;
      point.high = point.value + half;
      shape.curve.push_back(point);
      break;
    }
  }
}

}  // namespace

std::vector<AcceptedTable> ask_tables(const DiagnosisState& x, const std::vector<MotionSignal>& signals,
                                      const std::vector<int>& joints) {
  const Model& arm = *x.d.extended.model;
  CandidateList list = x.list();
  list.wanted = {kTabulatedForce};
  std::vector<MotionSignal> of;
  for (const int j : joints) {
    for (const MotionSignal& s : signals) {
      const bool own = s.joint == j;
      if (s.kind != SignalKind::kPosition &&
          !(own && (s.kind == SignalKind::kVelocity || s.kind == SignalKind::kTorque)))
        continue;
      for (EffectTerm& term : empty_table(arm, {j}, s)) {
        Hypothesis h = hypothesis_of(term, {j}, s.name);
        list.known.emplace_back(std::move(h), std::move(term));
        of.push_back(s);
      }
    }
  }
  if (list.known.empty() || !x.options.effects.empty()) return {};
  const CandidateTests asked = prepare_tests(x, list, x.d.extended);
  const std::vector<Hypothesis>& all = asked.q.augmented.hypotheses;
  DiagnosisOptions options = x.options;
  options.max_effects = static_cast<int>(options.thresholds.unnamed_terms);
  const Selection selection = select_effects(asked.data, asked.q.base, all, options, {});
  std::vector<AcceptedTable> out;
  for (const Accepted& a : selection.accepted) {
    const auto at = static_cast<size_t>(a.evidence.hypothesis);
    AcceptedTable table;
    table.joint = *all[at].joint;
    table.term = term_of(asked.q.augmented.model, all[at]);
    table.gain = a.evidence.gain;
    table.p_value = a.evidence.p_value;
    table.shape.signals = {of[at].name};
    table.shape.units = {of[at].unit};
    table.shape.effort = effort_unit(arm.coordinates()[table.joint.value]);
    add_nodes(asked, selection, all[at], of[at], table.shape);
    table.shape.words = shape_words(table.shape, {of[at]});
    out.push_back(std::move(table));
  }
  return out;
}

}  // namespace veridyn
