#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "diagnosis/stages/account.hpp"
#include "diagnosis/unnamed/tables.hpp"

// Findings without a name as tables of the extended model.

namespace veridyn {
namespace {

std::vector<MotionSignal> signals_of(const Finding& f, const std::vector<MotionSignal>& all) {
  std::vector<MotionSignal> out;
  for (const std::string& name : f.shape->signals) {
    out.push_back(*std::find_if(all.begin(), all.end(), [&name](const MotionSignal& s) { return s.name == name; }));
  }
  return out;
}

const char* why_not_kept(const Finding& f, const Model& arm, const std::vector<MotionSignal>& signals) {
  return tables_of(arm, *f.joint, *f.shape, signals_of(f, signals)).empty()
             ? "a table holds signals of the joint itself and of one other, no accelerations, histories or times, and nothing in proportion to a torque"
             : "with it held-out parts are predicted no better";
}

// A table, and the finding that it is of.
struct Table {
  EffectTerm term;
  size_t finding = 0;
};

Identification fitted_with(const DiagnosisState& x, const std::vector<Table>& tables, const std::set<int>& without) {
  ModelDescription description = x.d.extended.model->description();
  bool any = false;
  for (const Table& table : tables) {
    if (without.count(x.d.findings[table.finding].joint->value) != 0) continue;
    any = true;
    description.effects.push_back(table.term);
  }
  if (!any) return {};
  description.identified.reset();
  return x.fit(Model(std::move(description)));
}

// Adds tables to the extended model and fits it again; what is then left of each joint that has one goes to `left`.
void keep(DiagnosisState& x, const UnexplainedError& over, std::vector<double>& left) {
  std::vector<Table> tables;
  for (size_t k = 0; k < x.d.findings.size(); ++k) {
    const Finding& f = x.d.findings[k];
    if (!f.shape || f.status != FindingStatus::kConfirmed) continue;
    for (EffectTerm& term : tables_of(x.arm, *f.joint, *f.shape, signals_of(f, over.signals)))
      tables.push_back({std::move(term), k});
  }
  std::set<int> worse;
  for (int turn = 0; turn < 2; ++turn) {
    const Identification with = fitted_with(x, tables, worse);
    if (!with.model) return;
    const VectorXd after = x.fold_errors(with).relative();
    bool again = false;
    for (const Table& table : tables) {
      const int j = x.d.findings[table.finding].joint->value;
      if (worse.count(j) == 0 && after[j] > over.folds[j]) again = worse.insert(j).second;
    }
    if (again && turn == 0) continue;
    if (again) return;
    for (const Table& table : tables) {
      Finding& f = x.d.findings[table.finding];
      const int j = f.joint->value;
      if (worse.count(j) != 0) continue;
      f.shape->kept = true;
      left[j] = held_out_error(x, with, j);
    }
    x.d.extended = with;
    return;
  }
}

}  // namespace

void keep_tables(DiagnosisState& x, const UnexplainedError& over) {
  std::vector<double> left;
  for (const JointVerdict& v : x.d.joints) left.push_back(v.left);
  keep(x, over, left);
  for (const Finding& f : x.d.findings) {
    if (!f.shape || f.shape->kept || f.status != FindingStatus::kConfirmed) continue;
    x.d.remarks.push_back(fmt::format("Not in the model: the curve of joint {} over {}: {}.", f.joint->value + 1,
                                      signal_words(f.shape->signals), why_not_kept(f, x.arm, over.signals)));
  }
  for (JointVerdict& v : x.d.joints) {
    v.left = left[v.joint.value];
    v.floor = std::min(v.floor, v.left);
    v.removable = v.held_out - v.floor;
  }
}

}  // namespace veridyn
