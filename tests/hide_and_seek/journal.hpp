#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>

namespace veridyn::seek {

/// Results of cases in a file, one line each, so that a run that was killed goes on where it ended.
/// A line that a kill cut short counts as none.
class Journal {
 public:
  /// @throws InvalidInput  the file cannot be read or written.
  explicit Journal(std::string path);

  /// The result of a case with exactly these settings; null: it has to be played.
  const nlohmann::json* find(const nlohmann::json& settings) const;
  void keep(const nlohmann::json& settings, const nlohmann::json& result);

 private:
  std::string path_;
  std::map<std::string, nlohmann::json> results_;
};

}  // namespace veridyn::seek
