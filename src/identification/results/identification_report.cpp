#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "identification/identification_numbers.hpp"
#include "math/digits.hpp"
#include "veridyn/identification/identification.hpp"
#include "veridyn/identification/parameters_text.hpp"
#include "veridyn/identification/verdict.hpp"

namespace veridyn {
namespace {

std::string percent_columns(const VectorXd& v) {
  std::string out;
  for (Eigen::Index i = 0; i < v.size(); ++i) out += " " + in_percent(v[i], 7);
  return out;
}

const char* method_name(Method m) {
  static constexpr const char* kNames[] = {
      "ordinary least squares", "weighted least squares", "feasible least squares", "instrumental variables",
      "direct and inverse model"};
  return kNames[static_cast<int>(m)];
}

}  // namespace

std::string Identification::report() const {
  std::string out;
  const IdentificationVerdict verdict = verdict_of(*this);
  if (model) out += verdict.sentence + "\n";
  for (const std::string& warning : warnings) out += "warning: " + warning + "\n";
  out += fmt::format("{}: {}, {:.0f} rows", robot, method_name(method), rows);
  if (!model) return out + "\nno model: " + reason + "\n";
  out += fmt::format(", {} base parameters, {}\n", base.size(),
                     feasible ? "every body physically possible" : "NOT physically possible as it stands");
  if (drive_gains) out += drive_gains->report() + "\n";
  if (!reason.empty()) out += "warning: " + reason + "\n";
  out += "errors, % of the torque, per joint\n";
  const std::string tested = verdict.held_out ? "held out" : "learned from";
  const auto line = [&out](const std::string& name, const VectorXd& v) {
    if (v.size() > 0) out += fmt::format("  {:<22}{}\n", name, percent_columns(v));
  };
  line("training", train_error.relative);
  line(tested, test_error.relative);
  line(tested + ", repaired", test_repaired.relative);
  line("without excluded rows", test_without_excluded.relative);
  line(tested + ", moving", test_error.moving_relative);
  line(noise_floor_label(*this), noise_floor);
  if (!endogeneity.empty()) {
    out += "\nDurbin-Wu-Hausman: a small p says that noise in the motion biases least squares\n";
    for (size_t i = 0; i < endogeneity.size(); ++i) {
      const EndogeneityTest& t = endogeneity[i];
      out += fmt::format("  {:<22}F({:.0f}, {:.0f}) = {:.3g}, p = {:.2g}\n", model->coordinates()[i].name,
                         t.numerator_freedom, t.denominator_freedom, t.statistic, t.p_value);
    }
    out += "\n";
  }
  for (const RecordingError& r : test) {
    if (test.size() > 1)
      out += fmt::format("  {:<22}{}  {}\n", r.learned_from.empty() ? "held out" : "learned from", percent_columns(r.error.relative), r.source);
  }
  for (const auto* list : {&train, &test}) {
    for (const RecordingError& r : *list) {
      if (r.filled.count > r.rows / 1000)  // fewer rows are not mentioned
        out += fmt::format("{}: {}\n", r.source, filled_text(r.filled, r.rows));
    }
  }
  for (const std::string& remark : remarks) out += "remark: " + remark + "\n";
  if (!active_constraints.empty()) {
    out += "at the edge of what is physically possible: ";
    const size_t shown = std::min(identifying::kShownAtEdge, active_constraints.size());
    for (size_t k = 0; k < shown; ++k) out += (k > 0 ? ", " : "") + active_constraints[k];
    const size_t more = active_constraints.size() - shown;
    out += more > 0 ? fmt::format(", and {} more\n", more) : "\n";
  }
  return out;
}

std::string parameters_text(const Identification& id) {
  if (!id.model) return "";
  std::string out = fmt::format("\n{} base parameters, rank gap {:.1e}, condition number {:.1f} ({:.1f} with columns scaled)\n",
                                id.base.size(), id.rank_gap, id.condition_number, id.condition_number_scaled);
  out += fmt::format("  {:>13} {:>11}  {:<9} base parameter\n", "value", "std", "unit");
  for (const BaseValue& b : id.base) {
    const std::string deviation = std::isfinite(b.std) ? fmt::format("{:.2g}", b.std) : "-";
    out += fmt::format("  {:13.6g} {:>11}  {:<9} {}\n", b.value, deviation, b.unit, b.expression);
  }
  return out;
}

}  // namespace veridyn
