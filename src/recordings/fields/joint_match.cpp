#include "recordings/fields/joint_match.hpp"

#include <algorithm>
#include <optional>
#include <set>

#include "files/words.hpp"
#include "recordings/signals/joint_fields.hpp"
#include "veridyn/math/require.hpp"
#include "model/suggestion.hpp"

namespace veridyn::recordings {
namespace {

using Words = std::vector<std::string>;

// Words of a name that distinguish it from other joints.
Words distinctive_words(const std::string& name) {
  static const std::set<std::string> kIdle = {"joint", "link", "axis", "jnt"};
  Words words = words_of(name);
  words.erase(std::remove_if(words.begin(), words.end(),
                             [](const std::string& w) { return kIdle.count(w) > 0; }),
              words.end());
  return words;
}

// Number of words in `longer` before those of `shorter`; nullopt if it does not end with them.
std::optional<int> leading_words(const Words& shorter, const Words& longer) {
  if (shorter.empty() || shorter.size() > longer.size()) return std::nullopt;
  const auto behind = longer.end() - static_cast<long>(shorter.size());
  if (!std::equal(shorter.begin(), shorter.end(), behind)) return std::nullopt;
  return static_cast<int>(longer.size() - shorter.size());
}

std::optional<long> last_number(const std::string& name) {
  const Words words = words_of(name);
  if (words.empty()) return std::nullopt;
  const std::string& last = words.back();
  const bool digits = last.find_first_not_of("0123456789") == std::string::npos;
  if (!digits || last.size() > 6) return std::nullopt;
  return std::stol(last);
}

// Indices of the names 1..n, or 0..n-1, one for each joint; empty if the names are not these numbers.
std::vector<int> by_number(std::size_t wanted, const std::vector<std::string>& recorded) {
  std::vector<std::pair<long, int>> numbers;
  for (std::size_t k = 0; k < recorded.size(); ++k) {
    if (const auto number = last_number(recorded[k]))
      numbers.emplace_back(*number, static_cast<int>(k));
  }
  std::sort(numbers.begin(), numbers.end());
  std::vector<int> out;
  if (numbers.size() < wanted || numbers.empty() || numbers.front().first > 1) return out;
  for (std::size_t k = 0; k < wanted; ++k) {
    if (numbers[k].first != numbers.front().first + static_cast<long>(k)) return {};
    if (k + 1 < numbers.size() && numbers[k + 1].first == numbers[k].first) return {};
    out.push_back(numbers[k].second);
  }
  return out;
}

}  // namespace

std::vector<int> match_joints(const std::vector<std::string>& wanted,
                              const std::vector<std::string>& recorded,
                              const std::map<std::string, std::string>& renamed) {
  std::vector<int> out(wanted.size(), -1);
  std::vector<char> taken(recorded.size(), 0);
  const auto take = [&](std::size_t joint, std::size_t name) {
    out[joint] = static_cast<int>(name);
    taken[name] = 1;
  };
  for (std::size_t j = 0; j < wanted.size(); ++j) {
    const auto asked = renamed.find(wanted[j]);
    const std::string& name = asked == renamed.end() ? wanted[j] : asked->second;
    const auto found = std::find(recorded.begin(), recorded.end(), name);
    require(found != recorded.end() || asked == renamed.end(), "--map: found '", wanted[j], "=",
            name, "', but the recording has no joint ", name, did_you_mean(name, recorded),
            "; it has ", listed(recorded), ".");
    if (found != recorded.end()) take(j, static_cast<std::size_t>(found - recorded.begin()));
  }
  const bool numbers = std::all_of(recorded.begin(), recorded.end(), is_number);
  for (std::size_t j = 0; j < wanted.size(); ++j) {
    if (out[j] >= 0 || numbers) continue;
    const Words words = distinctive_words(wanted[j]);
    int best = 1 << 20;
    std::vector<std::size_t> candidates;
    for (std::size_t k = 0; k < recorded.size(); ++k) {
      if (taken[k] != 0) continue;
      const Words other = distinctive_words(recorded[k]);
      std::optional<int> distance = leading_words(words, other);
      if (!distance) distance = leading_words(other, words);
      if (!distance || *distance > best) continue;
      if (*distance < best) candidates.clear();
      best = *distance;
      candidates.push_back(k);
    }
    require(candidates.size() < 2, "found '", candidates.empty() ? "" : recorded[candidates[0]],
            "' and '", candidates.size() < 2 ? "" : recorded[candidates[1]], "', either may be joint ",
            wanted[j], ", expected --map ", wanted[j], "=NAME.");
    if (!candidates.empty()) take(j, candidates.front());
  }
  bool none = true;  // true: no name matches, except those given by the user
  for (std::size_t j = 0; j < wanted.size(); ++j)
    none = none && (out[j] < 0 || renamed.count(wanted[j]) > 0);
  if (none || numbers) {
    const std::vector<int> counted = by_number(wanted.size(), recorded);
    for (std::size_t j = 0; j < counted.size(); ++j) {
      if (renamed.count(wanted[j]) == 0) out[j] = counted[j];
    }
  }
  if (none && wanted.size() == 1 && recorded.size() == 1 && renamed.empty()) out[0] = 0;  // a single joint matches a single name
  return out;
}

}  // namespace veridyn::recordings
