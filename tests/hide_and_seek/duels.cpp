// veridyn-duels: after a motion that was designed to tell two causes apart, does `diagnose` name
// the right one alone, where it named both before? Not a test; it takes minutes to hours.

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <filesystem>

#include "hide_and_seek/duel.hpp"

namespace veridyn::seek {
namespace {

struct Tally {
  int cases = 0, both = 0, planned = 0, from_tool = 0, alone = 0, still = 0, wrong = 0;
  int alone_before = 0, errors = 0;
  int others = 0, others_alone = 0;
};

void count(const Duel& duel, Tally& t) {
  ++t.cases;
  t.alone_before += static_cast<int>(duel.before == Answer::kRight);
  t.others += static_cast<int>(!duel.other.empty() && duel.planned);
  t.others_alone +=
      static_cast<int>(!duel.other.empty() && duel.planned && duel.after == Answer::kRight);
  if (duel.before != Answer::kBoth) return;
  ++t.both;
  t.from_tool += static_cast<int>(duel.from_tool);
  t.planned += static_cast<int>(duel.planned);
  t.alone += static_cast<int>(duel.planned && duel.after == Answer::kRight);
  t.still += static_cast<int>(duel.planned && duel.after == Answer::kBoth);
  t.wrong += static_cast<int>(duel.planned && duel.after == Answer::kWrong);
}

void print(const DuelRequest& asked, const Duel& duel) {
  fmt::print("{:<11} {:>2} {}: ", asked.arm, asked.seed, duel.hidden);
  if (!duel.observable) {
    fmt::print("not observable on this arm\n");
  } else if (duel.before != Answer::kBoth && duel.other.empty()) {
    fmt::print("{} | {}\n", name_of(duel.before), duel.words_before);
  } else {
    fmt::print("{} -> {} | {} | {}{} | {} | left {:.2g}, {:.1f} s\n",
               duel.other.empty() ? "both" : "other",
               duel.planned ? name_of(duel.after) : "NO MOTION", duel.words_before,
               duel.from_tool ? "" : "(not first asked) ", duel.asked, duel.words_after,
               duel.share_after, duel.design_seconds);
  }
  std::fflush(stdout);
}

int run(int argc, char** argv) {
  DuelRequest asked;
  std::vector<std::string> arms = {"pick-scara", "pallet-4", "psm-3dof", "bench-6r"};
  std::vector<unsigned> seeds = {1, 2};
  std::vector<size_t> pairs = {1, 2, 3, 4, 5, 6};
  std::string keep;
  CLI::App app("Whether a designed motion tells two causes apart");
  app.add_option("--arms", arms, "Arms of tests/hide_and_seek/robots or data/robots")
      ->delimiter(',');
  app.add_option("--seeds", seeds, "Seeds")->delimiter(',');
  app.add_option("--pairs", pairs, "Numbers of pairs, 1 to 6")
      ->delimiter(',')
      ->check(CLI::Range(1, 6));
  app.add_option("--size", asked.share, "Rms of the effect, share of its joint's rms torque");
  app.add_option("--reach", asked.reach, "Of the ordinary motions, share of usual ones")
      ->check(CLI::Range(0.01, 1.0));
  app.add_option("--ordinary", asked.ordinary, "Recordings of ordinary motions to learn from")
      ->check(CLI::Range(1, 3));
  app.add_option("--designs", asked.designs, "Motions that are designed and recorded")
      ->check(CLI::Range(1, 4));
  app.add_option("--slow-passes", asked.slow_passes, "Where the pair is about friction")
      ->check(CLI::Range(0, 10));
  app.add_option("--threads", asked.threads, "Of diagnose and of the search");
  app.add_option("--keep", keep, "Keep the recordings in this folder");
  CLI11_PARSE(app, argc, argv);
  namespace fs = std::filesystem;
  std::vector<std::pair<std::string, Tally>> table;
  for (const size_t number : pairs) {
    asked.pair = rival_pairs()[number - 1];
    Tally tally;
    for (const std::string& arm : arms) {
      for (const unsigned seed : seeds) {
        for (const bool second : {false, true}) {
          asked.arm = arm;
          asked.seed = seed;
          asked.hide_second = second;
          const fs::path folder =
              keep.empty() ? fs::temp_directory_path() / fmt::format("veridyn-duels-{}", getpid())
                           : fs::path(keep) / fmt::format("{}-{}-{}-{}", number, arm, seed,
                                                          second ? "second" : "first");
          fs::create_directories(folder);
          try {
            const Duel duel = fight(asked, folder.string());
            print(asked, duel);
            if (duel.observable) count(duel, tally);
          } catch (const std::exception& error) {
            ++tally.errors;
            fmt::print("{} {} {}: ERROR {}\n", arm, seed,
                       second ? asked.pair.second : asked.pair.first, error.what());
          }
          if (keep.empty()) fs::remove_all(folder);
        }
      }
    }
    table.emplace_back(asked.pair.first + " / " + asked.pair.second, tally);
  }
  fmt::print("\n{:<55} {:>5} {:>6} {:>5} {:>6} {:>8} {:>6} {:>6} {:>6} {:>6} {:>9}\n", "pair",
             "cases", "alone0", "both", "asked", "planned", "alone", "both", "wrong", "errors",
             "others");
  for (const auto& [name, t] : table) {
    fmt::print("{:<55} {:>5} {:>6} {:>5} {:>6} {:>8} {:>6} {:>6} {:>6} {:>6} {:>9}\n", name,
               t.cases, t.alone_before, t.both, t.from_tool, t.planned, t.alone, t.still, t.wrong,
               t.errors, fmt::format("{}/{}", t.others_alone, t.others));
  }
  fmt::print(
      "\ncases: observable ones. alone0: the right one alone from ordinary recordings. both: both "
      "named there;\nof these: asked: the tool's next experiment is about the pair; planned: a "
      "motion was found;\nalone, both, wrong: what is named after recording it too. others: the "
      "hidden cause had a "
      "rival beyond\nthe pair, and was freed of it / cases.\n");
  return 0;
}

}  // namespace
}  // namespace veridyn::seek

int main(int argc, char** argv) {
  return veridyn::seek::run(argc, argv);
}
