#include <fmt/format.h>

#include "veridyn/excitation/excitation.hpp"

namespace veridyn {

const char* name_of(ExcitationCriterion criterion) {
  return criterion == ExcitationCriterion::kCondition ? "condition" : "d-optimal";
}

std::string Excitation::report() const {
  const double seconds = periods * trajectory.period();
  std::string out = fmt::format(
      "Excitation of {}: {} periods of {:.4g} s, {} harmonics, {:.4g} s in all, from rest to "
      "rest.\n",
      robot, periods, trajectory.period(), trajectory.harmonics(), seconds);
  if (status == ExcitationStatus::kRankDeficient) {
    out +=
        fmt::format("No motion was found that excites all {} base parameters.\n", base_parameters);
  } else {
    out += fmt::format(
        "Condition number {:.4g} for {} base parameters (a random motion: {:.4g}); ln det "
        "{:.4g}.\n",
        condition_number, base_parameters, start_condition_number, log_determinant);
  }
  out += fmt::format("{:<16}{:>5} {:>21} {:>21} {:>19} {:>21}\n", "joint", "unit", "position",
                     "limits", "speed (limit)", "acceleration (limit)");
  for (int i = 0; i < trajectory.joints(); ++i) {
    const auto name = static_cast<size_t>(i);
    out +=
        fmt::format("{:<16}{:>5} {:>21} {:>21} {:>19} {:>21}\n", joints[name], units[name],
                    fmt::format("{:.3f} .. {:.3f}", bounds.lower[i], bounds.upper[i]),
                    fmt::format("{:.3f} .. {:.3f}", limits.lower[i], limits.upper[i]),
                    fmt::format("{:.3f} ({:.3g})", bounds.velocity[i], limits.velocity[i]),
                    fmt::format("{:.3f} ({:.3g})", bounds.acceleration[i], limits.acceleration[i]));
  }
  return out;
}

}  // namespace veridyn
