#include "hide_and_seek/detection_limit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace veridyn::seek {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kFlattest = 0.5;
constexpr double kSteepest = 8.0;
constexpr int kGrid = 200;

double log_likelihood(const std::vector<SizedCase>& cases, double half, double steepness) {
  double sum = 0.0;
  for (const SizedCase& c : cases) {
    const double odds = std::pow(c.share / half, steepness);
    sum += c.named ? std::log(odds / (1.0 + odds)) : -std::log1p(odds);
  }
  return sum;
}

// "2.1 / 3.4"; "<1.0" where all cases are named, ">8.0" where none is: the limit lies outside of
// the sizes that were played.
std::string words_of(const std::vector<SizedCase>& cases) {
  const auto by_size = [](const SizedCase& a, const SizedCase& b) { return a.share < b.share; };
  const auto extremes = std::minmax_element(cases.begin(), cases.end(), by_size);
  const auto small = extremes.first, large = extremes.second;  // names that a lambda can hold in C++17
  const auto named = std::count_if(cases.begin(), cases.end(), [](auto& c) { return c.named; });
  if (cases.empty()) return "-";
  if (named == static_cast<long>(cases.size())) return fmt::format("<{:.1f}", 100.0 * small->share);
  if (named == 0) return fmt::format(">{:.1f}", 100.0 * large->share);
  const DetectionLimit limit = detection_limit(cases);
  const auto bounded = [&](double share) {
    return share > large->share ? fmt::format(">{:.1f}", 100.0 * large->share)
                                : fmt::format("{:.1f}", 100.0 * share);
  };
  return bounded(limit.half) + " / " + bounded(limit.nine_tenths);
}

}  // namespace

DetectionLimit detection_limit(const std::vector<SizedCase>& cases) {
  DetectionLimit out{kNone, kNone, static_cast<int>(cases.size())};
  const auto named = std::count_if(cases.begin(), cases.end(), [](auto& c) { return c.named; });
  if (named == 0 || named == static_cast<long>(cases.size())) return out;
  const auto [small, large] =
      std::minmax_element(cases.begin(), cases.end(), [](const SizedCase& a, const SizedCase& b) {
        return a.share < b.share;
      });
  double best = -std::numeric_limits<double>::infinity();
  for (int i = 0; i <= kGrid; ++i) {
    const double half = small->share * std::pow(large->share / small->share, double(i) / kGrid);
    for (int k = 0; k <= kGrid; ++k) {
      const double steepness = kFlattest * std::pow(kSteepest / kFlattest, double(k) / kGrid);
      const double value = log_likelihood(cases, half, steepness);
      if (value <= best) continue;
      best = value;
      out.half = half;
      out.nine_tenths = half * std::pow(9.0, 1.0 / steepness);
    }
  }
  return out;
}

void print_detection_limits(const BoardRequest& request, const std::vector<double>& sizes) {
  std::map<std::string, std::map<std::string, std::vector<SizedCase>>> found;
  BoardRequest sized = request;
  std::vector<std::string> groups;
  for (const double size : sizes) {
    sized.share = size;
    for (const BoardCase& one : cases_of(sized)) {
      if (one.request.effects.empty()) continue;
      if (std::find(groups.begin(), groups.end(), one.group) == groups.end())
        groups.push_back(one.group);
      const Outcome o = play(one, sized);
      found[one.group][one.request.arm].push_back({size, o.observable && o.verdict.named > 0});
    }
  }
  fmt::print("\nnamed with its joint in 50 % and in 90 % of the cases, % of the joint's rms torque\n");
  fmt::print("{:<30}", "effect");
  for (const std::string& arm : request.arms) fmt::print(" {:>14}", arm);
  fmt::print(" {:>14}\n", "all");
  for (const std::string& group : groups) {
    fmt::print("{:<30}", group);
    std::vector<SizedCase> all;
    for (const std::string& arm : request.arms) {
      const std::vector<SizedCase>& cases = found[group][arm];
      all.insert(all.end(), cases.begin(), cases.end());
      fmt::print(" {:>14}", words_of(cases));
    }
    fmt::print(" {:>14}\n", words_of(all));
  }
}

}  // namespace veridyn::seek
