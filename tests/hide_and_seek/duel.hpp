#pragma once

#include <string>
#include <utility>
#include <vector>

#include "hide_and_seek/generator.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn::seek {

/// Two causes that ordinary recordings confuse.
struct Pair {
  std::string first, second;
  Mode mode = Mode::kBare;
};

/// The six pairs of the discrimination figure.
const std::vector<Pair>& rival_pairs();

struct DuelRequest {
  Pair pair;
  bool hide_second = false;  ///< otherwise the first is hidden
  std::string arm;
  unsigned seed = 1;
  double share = 0.1;   ///< see CaseRequest
  double reach = 1.0;   ///< of the ordinary motions, see Motion
  int ordinary = 2;     ///< recordings of random motions to learn from; one more is the test
  int designs = 2;      ///< motions that are designed and recorded, with other frequencies
  int slow_passes = 2;  ///< of the joints in question, where the pair is about friction
  int threads = 1;
};

/// What a diagnosis says about a pair.
enum class Answer {
  kNothing,    ///< names neither
  kBoth,       ///< names one, and the other as its rival or as a finding of its own
  kRight,      ///< names the hidden one and not the other
  kWrong,      ///< names the other and not the hidden one
  kElsewhere,  ///< names the hidden one's kind at a wrong place only
};
const char* name_of(Answer answer);

struct Duel {
  bool observable = true;
  Answer before = Answer::kNothing;
  Answer after = Answer::kNothing;
  std::string other;       ///< the rival of the hidden cause where it is not that of the pair
  bool planned = false;    ///< a motion was asked for and found
  std::string hidden;      ///< for people
  std::string asked;       ///< the --between of the next experiment
  bool from_tool = false;  ///< `asked` is what diagnose printed for this pair
  std::string words_before, words_after;
  double share_before = 0.0, share_after = 0.0;  ///< see Discrimination, the smaller of two
  double design_seconds = 0.0;
};

/// Hides a cause, records ordinary motions, diagnoses; where both causes are named (or the hidden
/// one and another rival, see Duel::other), designs motions that discriminate between them, records
/// these too, and diagnoses again.
/// @param folder  for the recordings; it exists.
Duel fight(const DuelRequest& request, const std::string& folder);

}  // namespace veridyn::seek
