#include "cli/motions/kept_searches.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <fstream>
#include <functional>
#include <sstream>
#include <utility>
#include <vector>

#include "veridyn/math/require.hpp"

namespace veridyn::cli {
namespace {

constexpr const char* kEnd = "end";  // of a line that was not cut short

std::optional<std::pair<int, VectorXd>> search_in(const std::string& line) {
  std::istringstream words(line);
  int start = 0;
  if (!(words >> start)) return std::nullopt;
  std::vector<double> numbers;
  for (std::string word; words >> word;) {
    if (word == kEnd) return std::pair(start, VectorXd(Eigen::Map<VectorXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size()))));
    numbers.push_back(std::strtod(word.c_str(), nullptr));
  }
  return std::nullopt;
}

}  // namespace

KeptSearches::KeptSearches(std::string path, const std::string& command) : path_(std::move(path)) {
  const std::string header = fmt::format("veridyn excite: searches of command {:016x}", std::hash<std::string>{}(command));
  std::ifstream in(path_);
  std::string line;
  const bool any = static_cast<bool>(std::getline(in, line));
  const bool cut = any && in.eof() && header.rfind(line, 0) == 0;
  const bool begun = any && !cut;
  require(!begun || line == header, path_, ":1: found '", line, "', expected the searches of this command: '", header, "'.");
  bool whole = true;
  while (begun && std::getline(in, line)) {
    whole = !in.eof();
    if (auto search = search_in(line)) all_.insert(std::move(*search));
  }
  std::ofstream out(path_, begun ? std::ios::app : std::ios::trunc);
  out << (!begun ? header + "\n" : whole ? "" : "\n");
  require(out.flush().good(), path_, ": cannot be written.");
}

std::optional<VectorXd> KeptSearches::find(int start) const {
  const auto found = all_.find(start);
  return found == all_.end() ? std::nullopt : std::optional(found->second);
}

void KeptSearches::keep(int start, const VectorXd& numbers) {
  std::string line = std::to_string(start);
  for (const double number : numbers) line += fmt::format(" {}", number);
  const std::lock_guard<std::mutex> lock(writing_);
  std::ofstream out(path_, std::ios::app);
  out << line + " " + kEnd + "\n";
  require(out.flush().good(), path_, ": writing failed (disk full?).");
}

}  // namespace veridyn::cli
