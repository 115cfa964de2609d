#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>

#include "diagnosis/comparison/comparison_numbers.hpp"
#include "hide_and_seek/bench.hpp"
#include "hide_and_seek/swept_room.hpp"
#include "veridyn/identification/identification.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::seek {
namespace {

constexpr double kWorn = 1.3, kHeavier = 1.2, kSlipped = 1.05;
constexpr int kOtherMotion = 40;

// What happened to the arm between the two models, and how many recordings each of them has.
struct Between {
  const char* name;
  bool differ;
  void (*change)(Bench&) = [](Bench&) {};
  int first = 1;      // recording of the second model
  int recordings = 2;
};

const std::vector<Between>& betweens() {
  static const std::vector<Between> kAll = {
      {"nothing", false},
      {"nothing but another motion", false, [](Bench&) {}, kOtherMotion},
      {"nothing in one recording", false, [](Bench&) {}, 1, 1},
      {"worn", true, [](Bench& b) { b.friction[0].coulomb *= kWorn; }},
      {"worn and another motion", true, [](Bench& b) { b.friction[0].coulomb *= kWorn; }, kOtherMotion},
      {"more damping", true, [](Bench& b) { b.friction[1].viscous *= kWorn; }},
      {"heavier tool", true, [](Bench& b) { b.arm.links.back().moments *= kHeavier; }},
      {"a little worn", true, [](Bench& b) { b.friction[0].coulomb *= kSlipped; }}};
  return kAll;
}

Model identified(const Bench& bench, const Between& how, unsigned noise, const std::string& folder) {
  std::vector<std::string> files;
  for (int k = 0; k < how.recordings; ++k) {
    const int number = how.first + k;
    files.push_back(fmt::format("{}/{}-{}.csv", folder, noise, number));
    write_recording(bench, ideal_recording(bench, {}, Motion(bench.robot, bench.seed, number), number), noise, number, files.back());
  }
  const Identification out = identify(bench.robot, files, {}, {});
  require(out.model.has_value(), "sweeps: ", how.name, " is not identified: ", out.reason);
  return *out.model;
}

// A sentence without its numbers.
std::string wording(const std::string& sentence) {
  std::string out;
  for (const char c : sentence) {
    if (std::isdigit(static_cast<unsigned char>(c)) == 0 && c != '.' && c != '+' && c != '-') out += c;
  }
  return out;
}

std::string said_by(const ModelComparison& c) {
  std::set<std::string> all;
  for (const std::vector<ModelDifference>* part : {&c.joints, &c.parameters}) {
    for (const ModelDifference& d : *part)
      if (d.significant) all.insert(wording(d.sentence));
  }
  for (const std::string& only : c.only_before) all.insert("only before " + only);
  for (const std::string& only : c.only_after) all.insert("only after " + only);
  for (const StructureDifference& d : c.structure) all.insert(wording(d.sentence));
  all.insert(c.before.note);
  std::string out = c.same_motion ? "paired" : "apart";
  for (const std::string& one : all) out += " | " + one;
  return out;
}

}  // namespace

SweptRoom comparison_room(unsigned seed, const std::string& folder) {
  std::filesystem::create_directories(folder);
  std::vector<TableCase<ComparisonNumbers>> cases;
  for (const char* arm : {"psm-3dof", "pick-scara"}) {
    const Bench sound = make_bench(arm, seed);
    for (const Between& one : betweens()) {
      Between first = one;
      first.first = 1;
      const Model before = identified(sound, first, seed, folder);
      Bench bench = sound;
      one.change(bench);
      const Model after = identified(bench, one, seed + 1, folder);
      cases.emplace_back(fmt::format("{} {}", one.name, arm), [before, after, differ = one.differ](const ComparisonNumbers& numbers) {
        const ModelComparison c = compare(before, after, {}, numbers);
        return SweepAnswer{(c.verdict == ComparisonVerdict::kDiffer) == differ, said_by(c)};
      });
    }
  }
  return room_of(comparison_numbers(), cases);
}

}  // namespace veridyn::seek
