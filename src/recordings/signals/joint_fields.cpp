#include "recordings/signals/joint_fields.hpp"

#include <algorithm>
#include <cctype>
#include <map>
#include <set>

#include "files/words.hpp"

namespace veridyn::recordings {
namespace {

constexpr int kQ = 0, kDq = 1, kDdq = 2, kTau = 3, kCurrent = 4;

// Words that name a signal, alone or as a pair in this order.
const std::map<std::string, int>& signal_words() {
  static const std::map<std::string, int> kWords = {
      {"q", kQ}, {"pos", kQ}, {"position", kQ}, {"positions", kQ}, {"angle", kQ}, {"angles", kQ},
      {"qpos", kQ}, {"theta", kQ}, {"jointpos", kQ}, {"posn", kQ},
      {"dq", kDq}, {"qd", kDq}, {"qdot", kDq}, {"vel", kDq}, {"velocity", kDq}, {"velocities", kDq},
      {"speed", kDq}, {"speeds", kDq}, {"qvel", kDq}, {"dtheta", kDq}, {"omega", kDq},
      {"jointvel", kDq},
      {"ddq", kDdq}, {"qdd", kDdq}, {"qddot", kDdq}, {"acc", kDdq}, {"accel", kDdq},
      {"acceleration", kDdq}, {"accelerations", kDdq}, {"qacc", kDdq},
      {"tau", kTau}, {"torque", kTau}, {"torques", kTau}, {"effort", kTau}, {"efforts", kTau},
      {"eff", kTau}, {"trq", kTau}, {"qfrc", kTau}, {"force", kTau}, {"taus", kTau},
      {"i", kCurrent}, {"current", kCurrent}, {"currents", kCurrent}, {"cur", kCurrent},
      {"amps", kCurrent}};
  return kWords;
}

// True for words of signals that are not measured, or do not belong to a joint.
bool is_foreign(const std::string& word) {
  static const std::set<std::string> kForeign = {
      "target", "desired", "des",   "d",      "cmd",      "command", "commanded", "ref",
      "reference", "setpoint", "goal", "error", "err",     "limit",   "min",  "max", "tcp", "tool",
      "cartesian", "ee", "elbow_d", "wrench", "pose", "ext", "external", "std", "offset", "gravity",
      "temperature", "twist", "stamp", "header", "linear", "angular", "sensor", "ft", "imu"};
  return kForeign.count(word) > 0;
}

// True for words without information: `actual q 0` means `q 0`.
bool is_filler(const std::string& word) {
  static const std::set<std::string> kFiller = {"actual", "measured", "meas", "motor", "field",
                                                "state",  "actuator", "real", "msr",   "joints"};
  return kFiller.count(word) > 0;
}

bool is_unit(const std::string& word) {
  static const std::set<std::string> kUnits = {"deg",  "rad", "mm",  "rads", "degs", "nm",
                                               "mrad", "mnm", "ma"};
  return kUnits.count(word) > 0;
}

bool is_digits(const std::string& word) {
  return !word.empty() && std::all_of(word.begin(), word.end(), [](unsigned char c) {
    return std::isdigit(c) != 0;
  });
}

// A word of a name, and its position.
struct Word {
  std::string text;
  std::size_t begin = 0, end = 0;
};

std::vector<Word> pieces_of(const std::string& name) {
  std::vector<Word> words;
  const auto kind = [](char c) {
    const auto u = static_cast<unsigned char>(c);
    return std::isdigit(u) != 0 ? 2 : std::isalpha(u) != 0 ? 1 : 0;
  };
  for (std::size_t k = 0; k < name.size();) {
    const int now = kind(name[k]);
    if (now == 0) {
      ++k;
      continue;
    }
    std::size_t end = k + 1;
    while (end < name.size() && kind(name[end]) == now) {
      const bool hump = std::isupper(static_cast<unsigned char>(name[end])) != 0 &&
                        std::islower(static_cast<unsigned char>(name[end - 1])) != 0;
      if (hump) break;
      ++end;
    }
    words.push_back({lower(name.substr(k, end - k)), k, end});
    k = end;
  }
  return words;
}

// The name without a unit in brackets at its end, and without brackets around array indices.
std::string without_unit(const std::string& name) {
  const std::size_t open = name.find_last_of("[(");
  if (open == std::string::npos || open == 0) return name;
  const std::string inner = name.substr(open + 1, name.find_last_of("])") - open - 1);
  if (is_digits(inner)) return name;
  // `q(elbow)` contains the joint; `q [deg]` the unit.
  const bool unit = name[open] == '[' || (name[open - 1] == ' ') || is_unit(lower(inner));
  return unit ? name.substr(0, open) : name;
}

struct Found {
  int signal = -1;
  std::size_t first = 0, last = 0;  // first and last word of the signal
};

// The signal at word k, with all words that belong to it: `tau J`, `q dot`, `joint position`.
Found signal_at(const std::vector<Word>& words, std::size_t k) {
  const auto found = signal_words().find(words[k].text);
  if (found == signal_words().end()) return {};
  Found out{found->second, k, k};
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
    if (is_digits(words[k].text)) continue;
    return is_unit(words[k].text) ? words[k].text : std::string();
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
    if (is_foreign(word.text) && !(first && word.text == "d")) return field;
    if (is_filler(word.text) || (is_unit(word.text) && !first)) continue;
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
