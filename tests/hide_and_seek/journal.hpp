#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>

namespace veridyn::seek {

/// Results of cases in a file, one line each, from which a run that was killed continues. An
/// incomplete last line is ignored.
class Journal {
 public:
  /// @throws InvalidInput  the file cannot be read or written.
  explicit Journal(std::string path);

  /// The result of a case with exactly these settings; null: there is none.
  const nlohmann::json* find(const nlohmann::json& settings) const;
  void keep(const nlohmann::json& settings, const nlohmann::json& result);

 private:
  std::string path_;
  std::map<std::string, nlohmann::json> results_;
};

}  // namespace veridyn::seek
