#include <fmt/format.h>

#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {
namespace {

std::string percents(const VectorXd& v) {
  std::string out;
  for (Eigen::Index i = 0; i < v.size(); ++i) out += fmt::format("{:8.2f}", 100.0 * v[i]);
  return out;
}

std::string finding_text(const Finding& f) {
  std::string out = fmt::format("{}. {}\n", f.rank, f.sentence);
  for (const FoundParameter& p : f.parameters) {
    out += fmt::format("     {} = {:.4g} {} (95 %: {:.4g} to {:.4g})\n", p.name, p.value, p.unit,
                       p.low, p.high);
  }
  out += fmt::format("     held-out error, %: {} -> {}\n", percents(f.test_before),
                     percents(f.test_after));
  out += fmt::format("     p = {:.1e}, explains {:.0f} % of the removable error\n", f.p_value,
                     100.0 * f.explains);
  for (const Rival& r : f.rivals) {
    const std::string place =
        r.frame.empty() ? fmt::format("joint {} ({})", r.joint, r.coordinate) : r.frame;
    out += fmt::format("     rival: {} on {}: {}\n", r.effect, place, r.why);
  }
  return out;
}

}  // namespace

std::string Diagnosis::report() const {
  if (!baseline.model) return baseline.report();
  std::string out =
      fmt::format("{}: {} hypotheses asked in {:.1f} s\n", baseline.robot, hypotheses, seconds);
  for (const RecordingQuality& q : data_quality) {
    for (const QualityFinding& f : q.findings) {
      if (f.severity != Severity::kInfo)
        out += fmt::format("recording {}: {}\n", q.file, f.sentence);
    }
  }
  for (const auto* list : {&baseline.train, &baseline.test}) {
    for (const RecordingError& r : *list) {
      if (r.filled.count > r.rows / 1000)  // fewer are not worth a line
        out += fmt::format("recording {}: {}\n", r.source, filled_text(r.filled, r.rows));
    }
  }
  if (provisional) out += "one recording to learn from: names are provisional\n";
  out += findings.empty() ? "\nverdict: none; the data support no further effect\n"
         : changes        ? "\nwhat changed since the model was made:\n"
                          : "\nwhat the model lacks:\n";
  for (const Finding& f : findings) out += finding_text(f);
  out += "\nerrors, % of the torque, per joint\n";
  const auto line = [&out](const char* name, const VectorXd& v) {
    if (v.size() > 0) out += fmt::format("  {:<24}{}\n", name, percents(v));
  };
  line("held out, as it stands", baseline.test_error.relative);
  line("held out, extended", extended.test_error.relative);
  line("extended, as recorded", extended.test_as_recorded.relative);
  line("training, as it stands", baseline.train_error.relative);
  line("training, extended", extended.train_error.relative);
  line("noise floor", baseline.noise_floor);
  if (!next_experiment.separates.empty()) {
    out += fmt::format("next experiment, to separate {} from {}:\n  {}\n",
                       next_experiment.separates[0], next_experiment.separates[1],
                       next_experiment.trajectory);
  }
  for (const CannotTell& c : cannot_tell)
    out += fmt::format("cannot tell: {} on joint {}: {}\n", c.effect, c.joint, c.why);
  return out;
}

}  // namespace veridyn
