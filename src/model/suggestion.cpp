#include "model/suggestion.hpp"

#include <algorithm>
#include <cctype>
#include <numeric>

#include "model/excerpt.hpp"

namespace veridyn {
namespace {

bool same_letter(char a, char b) {
  return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
}

// Levenshtein distance, computed row by row, ignoring case.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (same_letter(a[i - 1], b[j - 1]) ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

constexpr std::size_t kTellsEnough = 3;  // shortest prefix, in letters, that identifies a name

// The shortest candidate with the prefix `name`: "psm" may mean "psm-3dof".
std::string shortest_that_begins_with(const std::string& name,
                                      const std::vector<std::string>& candidates) {
  std::string best;
  for (const std::string& candidate : candidates) {
    const bool begins = name.size() >= kTellsEnough && name.size() < candidate.size() &&
                        std::equal(name.begin(), name.end(), candidate.begin(), same_letter);
    if (begins && (best.empty() || candidate.size() < best.size())) best = candidate;
  }
  return best;
}

}  // namespace

std::vector<std::string> by_similarity(const std::string& name,
                                       std::vector<std::string> candidates) {
  std::stable_sort(candidates.begin(), candidates.end(),
                   [&](const std::string& a, const std::string& b) {
                     return edit_distance(name, a) < edit_distance(name, b);
                   });
  return candidates;
}

std::string did_you_mean(const std::string& name, const std::vector<std::string>& candidates) {
  if (candidates.empty()) return "";
  std::string best = by_similarity(name, candidates).front();
  const std::size_t longest = std::max(name.size(), best.size());
  if (2 * edit_distance(name, best) > longest) {
    best = shortest_that_begins_with(name, candidates);
    if (best.empty()) return "";
  }
  return " (did you mean '" + best + "'?)";
}

std::string listed(const std::vector<std::string>& names) {
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + excerpt(name, 200);
  return all;
}

}  // namespace veridyn
