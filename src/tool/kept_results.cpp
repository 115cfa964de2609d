#include "veridyn/tool/kept_results.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <utility>
#include <vector>

#include "model/excerpt.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::cli {
namespace {

constexpr const char* kEnd = "end";  // marks the end of a line that was written completely

// Index of a part and its result, read from a line of the file; nullopt if the line is not complete.
std::optional<std::pair<int, VectorXd>> result_in(const std::string& line) {
  std::istringstream words(line);
  int part = 0;
  if (!(words >> part)) return std::nullopt;
  std::vector<double> numbers;
  for (std::string word; words >> word;) {
    if (word == kEnd) return std::pair(part, VectorXd(Eigen::Map<VectorXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size()))));
    char* end = nullptr;
    numbers.push_back(std::strtod(word.c_str(), &end));
    if (*end != '\0') return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace

KeptResults::KeptResults(std::string path, const std::string& what, const std::string& command) : path_(std::move(path)) {
  const std::string header = fmt::format("veridyn {} of command {:016x}", what, std::hash<std::string>{}(command));
  std::error_code error;
  const bool exists = std::filesystem::exists(path_, error);
  require(!exists || std::filesystem::is_regular_file(path_, error), path_,
          ": found a folder, a pipe or a device, expected the name of a file to keep results in.");
  std::ifstream in(path_);
  std::string line;
  const bool any = static_cast<bool>(std::getline(in, line));
  const bool cut = any && in.eof() && header.rfind(line, 0) == 0;
  const bool begun = any && !cut;
  require(!begun || line == header, path_, ":1: found '", excerpt(line), "', expected what this command keeps: '", header, "'.");
  bool whole = true;
  while (begun && std::getline(in, line)) {
    whole = !in.eof();
    if (auto result = result_in(line)) all_.insert_or_assign(result->first, std::move(result->second));
  }
  std::ofstream out(path_, begun ? std::ios::app : std::ios::trunc);
  out << (!begun ? header + "\n" : whole ? "" : "\n");
  const bool written = out.flush().good();
  if (!written && !exists) std::filesystem::remove(path_, error);
  require(written, path_, ": cannot be written: no such folder, no permission, or the disk is full.");
}

std::optional<VectorXd> KeptResults::find(int part) const {
  const auto found = all_.find(part);
  return found == all_.end() ? std::nullopt : std::optional(found->second);
}

void KeptResults::keep(int part, const VectorRef& numbers) {
  std::string line = std::to_string(part);
  for (const double number : numbers) line += fmt::format(" {}", number);
  const std::lock_guard<std::mutex> lock(writing_);
  std::ofstream out(path_, std::ios::app);
  out << line + " " + kEnd + "\n";
  require(out.flush().good(), path_, ": writing failed (disk full?).");
}

}  // namespace veridyn::cli
