#include "hide_and_seek/threshold_sweep.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

#include "veridyn/math/require.hpp"

namespace veridyn::seek {

void set_threshold(const std::string& setting, DiagnosisOptions& options) {
  const size_t equals = setting.find('=');
  const std::string value = equals == std::string::npos ? "" : setting.substr(equals + 1);
  char* end = nullptr;
  const double number = std::strtod(value.c_str(), &end);
  require(!value.empty() && *end == '\0' && std::isfinite(number), "--set: found '", setting,
          "', expected NAME=VALUE.");
  options.thresholds.*find_threshold(setting.substr(0, equals)).value = number;
}

void print_thresholds() {
  fmt::print("| number | value | holds when | because | chosen on seeds |\n|---|---|---|---|---|\n");
  const Thresholds defaults;
  for (const ThresholdEntry& e : threshold_table())
    fmt::print("| `{}` | {:g} | {} | {} | {} |\n", e.name, defaults.*e.value, e.inequality, e.reason,
               e.seeds.empty() ? "-" : e.seeds);
}

void print_sweep(const BoardRequest& request, const std::string& name,
                 const std::vector<double>& factors) {
  const ThresholdEntry& entry = find_threshold(name);
  fmt::print("{}: {}\n", name, entry.inequality);
  std::string table = fmt::format("\n{:>12} {:>6} {:>6} {:>8} {:>9} {:>6} {:>11}\n", name, "cases",
                                  "first", "named", "diagnoses", "false", "covered");
  for (const double factor : factors) {
    BoardRequest moved = request;
    double& value = moved.options.thresholds.*entry.value;
    value *= factor;
    const Totals t = totals(play_all(moved));
    table += fmt::format("{:>12.4g} {:>6} {:>6} {:>4}/{:<3} {:>9} {:>6} {:>5}/{:<5}\n", value,
                         t.cases, t.first, t.named, t.hidden, t.with_extras, t.extras, t.covered,
                         t.intervals);
  }
  fmt::print("{}", table);
}

}  // namespace veridyn::seek
