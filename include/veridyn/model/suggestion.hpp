#pragma once

#include <string>
#include <vector>

namespace veridyn {

/// The candidates, the most similar to `name` first (least number of inserted, deleted or replaced
/// letters).
std::vector<std::string> by_similarity(const std::string& name,
                                       std::vector<std::string> candidates);

/// " (did you mean 'x'?)" for the most similar candidate; empty if none is similar.
std::string did_you_mean(const std::string& name, const std::vector<std::string>& candidates);

/// The names as "a, b, c" for a message; long names from a file are abbreviated.
std::string listed(const std::vector<std::string>& names);

}  // namespace veridyn
