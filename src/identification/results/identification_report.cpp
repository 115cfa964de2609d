#include <fmt/format.h>

#include <cmath>
#include <string>

#include "math/digits.hpp"
#include "veridyn/identification/identification.hpp"
#include "veridyn/identification/verdict.hpp"

namespace veridyn {
namespace {

std::string percent(const VectorXd& v) {
  std::string out;
  for (Eigen::Index i = 0; i < v.size(); ++i) out += " " + in_percent(v[i], 7);
  return out;
}

const char* method_name(Method m) {
  switch (m) {
    case Method::kOls:
      return "ordinary least squares";
    case Method::kWls:
      return "weighted least squares";
    case Method::kIv:
      return "instrumental variables";
    case Method::kDidim:
      return "direct and inverse model";
    case Method::kFeasible:
      break;
  }
  return "feasible least squares";
}

}  // namespace

std::string Identification::report() const {
  std::string out;
  if (model) out += verdict_of(*this).sentence + "\n";
  out += fmt::format("{}: {}, {:.0f} rows\n", robot, method_name(method), rows);
  if (!model) return out + "no model: " + reason + "\n";
  if (drive_gains) out += drive_gains->report() + "\n";
  if (!reason.empty()) out += "warning: " + reason + "\n";
  out += fmt::format(
      "{} base parameters, rank gap {:.1e}, condition number {:.1f} ({:.1f} with columns scaled), ",
      base.size(), rank_gap, condition_number, condition_number_scaled);
  out += feasible ? "every body physically possible\n" : "NOT physically possible as it stands\n";
  out += "\nerrors, % of the torque, per joint\n";
  const auto line = [&out](const char* name, const VectorXd& v) {
    if (v.size() > 0) out += fmt::format("  {:<22}{}\n", name, percent(v));
  };
  line("training", train_error.relative);
  line("held out", test_error.relative);
  line("held out, repaired", test_repaired.relative);
  line("without excluded rows", test_without_excluded.relative);
  line("held out, moving", test_error.moving_relative);
  line(floor_name(*this), noise_floor);
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
      out += fmt::format("  {:<22}{}  {}\n", "held out", percent(r.error.relative), r.source);
  }
  for (const auto* list : {&train, &test}) {
    for (const RecordingError& r : *list) {
      if (r.filled.count > r.rows / 1000)  // fewer are not worth a line
        out += fmt::format("{}: {}\n", r.source, filled_text(r.filled, r.rows));
    }
  }
  for (const std::string& remark : remarks) out += "remark: " + remark + "\n";
  if (!active_constraints.empty()) {
    out += "\nat the edge of what is physically possible:\n";
    for (const std::string& c : active_constraints) out += "  " + c + "\n";
  }
  out += fmt::format("\n  {:>13} {:>11}  {:<9} base parameter\n", "value", "std", "unit");
  for (const BaseValue& b : base) {
    const std::string deviation = std::isfinite(b.std) ? fmt::format("{:.2g}", b.std) : "-";
    out += fmt::format("  {:13.6g} {:>11}  {:<9} {}\n", b.value, deviation, b.unit, b.expression);
  }
  return out;
}

}  // namespace veridyn
