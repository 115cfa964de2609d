#include "recordings/signals/joint_fields.hpp"

#include <cctype>
#include <map>
#include <utility>

#include "files/words.hpp"

namespace veridyn::recordings {
namespace {

// Meaning of a word in the name of a column: a signal (an index into kRecordingSignals), or one of those below.
constexpr int kQ = 0, kDq = 1, kDdq = 2, kTau = 3, kCurrent = 4;
constexpr int kNone = -1;     // a word of another kind, such as the name of a joint
constexpr int kForeign = -2;  // the column is not measured, or does not belong to a joint
constexpr int kFiller = -3;   // no information: `actual q 0` means `q 0`
constexpr int kUnit = -4;

// Index of the signal that a word means; negative: none.
int signal_of_word(const std::string& word) {
  static const std::pair<int, const char*> kWords[] = {
      {kQ, "q pos position positions angle angles qpos theta jointpos posn"},
      {kDq, "dq qd qdot vel velocity velocities speed speeds qvel dtheta omega jointvel"},
      {kDdq, "ddq qdd qddot acc accel acceleration accelerations qacc"},
      {kTau, "tau torque torques effort efforts eff trq qfrc force taus"},
      {kCurrent, "i current currents cur amps"},
      {kForeign, "target desired des d cmd command commanded ref reference setpoint goal error err limit min max"},
      {kForeign, "tcp tool cartesian ee wrench pose ext external std offset gravity temperature twist stamp header"},
      {kForeign, "linear angular sensor ft imu"},
      {kFiller, "actual measured meas motor field state actuator real msr joints"},
      {kUnit, "deg rad mm rads degs nm mrad mnm ma"}};
  static const std::map<std::string, int> kMeanings = [] {
    std::map<std::string, int> meanings;
    for (const auto& [meaning, words] : kWords) {
      for (const std::string& one : split(words, ' ')) meanings[one] = meaning;
    }
    return meanings;
  }();
  const auto found = kMeanings.find(word);
  return found == kMeanings.end() ? kNone : found->second;
}

// A word of a name, with its position in it.
struct Word {
  std::string text;
  std::size_t begin = 0, end = 0;
};

std::vector<Word> pieces_of(const std::string& name) {
  std::vector<Word> words;
  const auto is = [&name](int (*kind)(int), std::size_t k) { return kind(static_cast<unsigned char>(name[k])) != 0; };
  for (std::size_t k = 0, end = 0; k < name.size(); k = end) {
    end = k + 1;
    if (!is(std::isalnum, k)) continue;
    const bool digit = is(std::isdigit, k);
    const auto hump = [&](std::size_t at) { return is(std::isupper, at) && is(std::islower, at - 1); };
    while (end < name.size() && is(std::isalnum, end) && is(std::isdigit, end) == digit && !hump(end)) ++end;
    words.push_back({to_lower(name.substr(k, end - k)), k, end});
  }
  return words;
}

// The name without a unit in brackets at its end, and without brackets around array indices.
std::string without_unit(const std::string& name) {
  const std::size_t open = name.find_last_of("[(");
  if (open == std::string::npos || open == 0) return name;
  const std::string inner = name.substr(open + 1, name.find_last_of("])") - open - 1);
  if (is_number(inner)) return name;
  // Brackets contain a unit in `q [deg]`, and the joint in `q(elbow)`.
  const bool unit = name[open] == '[' || (name[open - 1] == ' ') || signal_of_word(to_lower(inner)) == kUnit;
  return unit ? name.substr(0, open) : name;
}

struct Found {
  int signal = -1;
  std::size_t first = 0, last = 0;  // first and last word of the signal
};

// The signal at word k, with all words that belong to it: `tau J`, `q dot`, `joint position`.
Found signal_at(const std::vector<Word>& words, std::size_t k) {
  Found out{signal_of_word(words[k].text), k, k};
  if (out.signal < 0) return {};
  const std::string next = k + 1 < words.size() ? words[k + 1].text : "";
  if (out.signal == kQ && (next == "dot" || next == "ddot" || next == "dd")) {
    out.signal = next == "dot" ? kDq : kDdq;
    ++out.last;
  }
  if (words[k].text == "tau" && next == "j") ++out.last;
  if (k == 1 && words[0].text == "joint") --out.first;
  return out;
}

}  // namespace

std::vector<std::string> words_of(const std::string& name) {
  std::vector<std::string> words;
  for (const Word& word : pieces_of(name)) words.push_back(word.text);
  return words;
}

std::string unit_in(const std::string& name) {
  const std::string bare = without_unit(name);
  if (bare.size() < name.size()) {
    const std::size_t open = bare.size();
    return name.substr(open + 1, name.find_last_of("])") - open - 1);
  }
  const std::vector<Word> words = pieces_of(name);
  for (std::size_t k = words.size(); k-- > 1;) {
    if (!is_number(words[k].text)) return signal_of_word(words[k].text) == kUnit ? words[k].text : std::string();
  }
  return {};
}

RawField field_of(const std::string& path) {
  RawField field;
  field.path = path;
  const std::string name = without_unit(path);
  std::vector<Word> words;
  for (Word& word : pieces_of(name)) {
    const bool first = words.empty();
    const int meaning = signal_of_word(word.text);
    if (meaning == kForeign && !(first && word.text == "d")) return field;
    if (meaning == kFiller || (meaning == kUnit && !first)) continue;
    words.push_back(std::move(word));
  }
  if (words.empty()) return field;
  // The signal is the last word (`elbow/position`), or the first (`q_elbow`, `position 3`).
  Found found = signal_at(words, words.size() - 1);
  if (found.signal < 0) found = signal_at(words, 0);
  if (found.signal < 0 && words.size() > 1 && words[0].text == "joint") found = signal_at(words, 1);
  if (found.signal < 0) return field;
  const bool at_back = found.last + 1 == words.size();
  const std::size_t begin = at_back ? 0 : found.last + 1;
  const std::size_t end = at_back ? found.first : words.size();
  const bool unnamed = begin == end || (end - begin == 1 && words[begin].text == "joint");
  field.joint = unnamed ? "1"
                        : name.substr(words[begin].begin, words[end - 1].end - words[begin].begin);
  field.signal = found.signal;
  return field;
}

}  // namespace veridyn::recordings
