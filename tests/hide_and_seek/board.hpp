#pragma once

#include <memory>
#include <string>
#include <vector>

#include "hide_and_seek/journal.hpp"
#include "hide_and_seek/judge.hpp"

namespace veridyn::seek {

/// Visibility::best_gain of amplitudes three times as large as the smallest that are beyond doubt.
constexpr double kWellVisible = 0.27;

/// Selection of cases and settings of a run.
struct BoardRequest {
  std::vector<std::string> arms = bench_arms();
  std::vector<std::string> effects;  ///< empty: all effects of the mode, and `none`
  std::vector<unsigned> seeds = {1, 2};
  double share = 0.1;
  std::string mode = "bare";               ///< bare, changed or both
  std::vector<std::string> troubles = {};  ///< each alone; empty: recordings without trouble
  int pairs = 0;                           ///< two effects at once: so many per arm and seed
  bool one_joint = false;  ///< pairs on one joint, the first of `effects` in each
  double noise = 0.0;                      ///< see CaseRequest
  int threads = 2;
  std::string json;  ///< one record per case is appended to this file
  std::string keep;  ///< recordings stay in this folder
  std::shared_ptr<Journal> journal;  ///< cases in it are not played again; null: all are played
  bool well_visible = false;
  DiagnosisOptions options;
};

/// A case with the line of the table in which it is counted.
struct BoardCase {
  CaseRequest request;
  std::string group;
};

/// All cases of a board, in the order in which they are played.
std::vector<BoardCase> cases_of(const BoardRequest& request);

/// One case after it was played.
struct Outcome {
  std::string group;
  bool observable = true;
  double best_gain = 0.0;
  Verdict verdict;
  double seconds = 0.0;
};

/// Plays one case and prints a line for it.
Outcome play(const BoardCase& one, const BoardRequest& request);

/// Everything that an outcome depends on, the build of this program too.
nlohmann::json settings_of(const BoardCase& one, const BoardRequest& request);

/// Plays all cases that its journal lacks; one that cannot be played is printed as an error and left out.
std::vector<Outcome> play_all(const BoardRequest& request);

/// Counts by group and over all.
void print_table(const std::vector<Outcome>& all, const char* title);

/// Named first, named with joint, extras of all cases.
struct Totals {
  int cases = 0, first = 0, first_rival = 0, hidden = 0, named = 0;
  int with_extras = 0, extras = 0, intervals = 0, covered = 0, unseen = 0;
};
Totals totals(const std::vector<Outcome>& all);

/// "torque_drift@3(+2 rivals), ..."; "none" where there is nothing.
std::string findings_text(const std::vector<NamedFinding>& findings);

/// "first", "rival", "MISSED +2 wrong", ...
std::string words_of(const Verdict& v);

}  // namespace veridyn::seek
