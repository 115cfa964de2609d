#include "hide_and_seek/journal.hpp"

#include <fstream>
#include <utility>

#include "veridyn/math/require.hpp"

namespace veridyn::seek {

using nlohmann::json;

Journal::Journal(std::string path) : path_(std::move(path)) {
  std::ifstream in(path_);
  bool whole = true;
  for (std::string line; std::getline(in, line);) {
    whole = !in.eof();
    const json one = json::parse(line, nullptr, false);
    if (whole && one.is_object() && one.contains("settings") && one.contains("result"))
      results_[one["settings"].dump()] = one["result"];
  }
  std::ofstream out(path_, std::ios::app);
  if (!whole) out << "\n";
  require(out.flush().good(), path_, ": cannot be written.");
}

const json* Journal::find(const json& settings) const {
  const auto found = results_.find(settings.dump());
  return found == results_.end() ? nullptr : &found->second;
}

void Journal::keep(const json& settings, const json& result) {
  std::ofstream out(path_, std::ios::app);
  out << (json{{"settings", settings}, {"result", result}}.dump() + "\n");
  require(out.flush().good(), path_, ": cannot be written.");
  results_[settings.dump()] = result;
}

}  // namespace veridyn::seek
