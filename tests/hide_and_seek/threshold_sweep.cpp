#include "hide_and_seek/threshold_sweep.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include "diagnosis/comparison/comparison_numbers.hpp"
#include "identification/estimation/estimation_numbers.hpp"
#include "hide_and_seek/sweep_board.hpp"
#include "identification/fleet/fleet_numbers.hpp"
#include "identification/identification_numbers.hpp"
#include "recordings/quality/quality_numbers.hpp"
#include "veridyn/math/require.hpp"
#include "diagnosis/watch/watch_numbers.hpp"

namespace veridyn::seek {
namespace {

constexpr const char* kHeader = "number,factor,value,cases,right,gained,lost,other answers,which,seed,date";

using Answers = std::vector<SweepAnswer>;

SweepAnswer ask(const RoomCase& one, const std::string& number, double factor) {
  try {
    return one.ask(number, factor);
  } catch (const std::exception& error) {
    return {false, std::string("ERROR ") + error.what()};
  }
}

// What one value of a number changes: cases gained and lost, and answers that differ otherwise.
std::string counts(const std::vector<RoomCase>& board, const Answers& base, const Answers& now) {
  int right = 0, gained = 0, lost = 0, other = 0;
  std::string which;
  const auto add = [&which](const char* sign, const std::string& name) {
    which += fmt::format("{}{}{}", which.empty() ? "" : "; ", sign, name);
  };
  for (size_t k = 0; k < board.size(); ++k) {
    right += now[k].right ? 1 : 0;
    if (now[k].right && !base[k].right) {
      ++gained;
      add("+", board[k].name);
    } else if (base[k].right && !now[k].right) {
      ++lost;
      add("-", board[k].name);
    } else if (now[k].said != base[k].said) {
      ++other;
      add("~", board[k].name);
    }
  }
  return fmt::format("{},{},{},{},{},{}", board.size(), right, gained, lost, other, which);
}

std::string today() {
  const std::time_t now = std::time(nullptr);
  char out[16];
  std::strftime(out, sizeof out, "%F", std::gmtime(&now));
  return out;
}

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> out(1);
  for (const char c : line) {
    if (c == ',') {
      out.emplace_back();
    } else {
      out.back() += c;
    }
  }
  return out;
}

std::vector<std::string> read_sweeps(const std::string& file) {
  std::vector<std::string> out;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) out.push_back(line);
  require(!out.empty() && out.front() == kHeader, file, ":1: found no sweeps, expected the header ", kHeader, ".");
  return out;
}

// Of each number, what its factors changed: "0.5: +1 -2 cases, 3 other answers".
std::map<std::string, std::string> changes_in(const std::string& file) {
  const std::vector<std::string> lines = read_sweeps(file);
  const size_t columns = fields_of(kHeader).size();
  std::map<std::string, std::string> out;
  for (size_t k = 1; k < lines.size(); ++k) {
    const std::vector<std::string> row = fields_of(lines[k]);
    require(row.size() == columns, file, ":", k + 1, ": found ", row.size(), " fields, expected ", columns, ".");
    std::string& text = out[row[0]];
    if (row[1] == "1" || (row[5] == "0" && row[6] == "0" && row[7] == "0")) continue;
    text += fmt::format("{}{}: +{} -{} cases, {} other answers", text.empty() ? "" : "; ", row[1], row[5], row[6], row[7]);
  }
  for (auto& [name, text] : out) {
    if (text.empty()) text = "nothing";
  }
  return out;
}

// Numbers without a row of their present value.
std::vector<std::string> unswept(const SweptRoom& room, const std::vector<std::string>& lines) {
  std::set<std::string> known;
  for (size_t k = 1; k < lines.size(); ++k) {
    const std::vector<std::string> row = fields_of(lines[k]);
    if (row.size() > 2 && row[1] == "1" && row[2] == fmt::format("{:g}", room.value(row[0]))) known.insert(row[0]);
  }
  std::vector<std::string> out;
  for (const std::string& number : room.numbers) {
    if (known.count(number) == 0) out.push_back(number);
  }
  return out;
}

}  // namespace

void set_threshold(const std::string& setting, DiagnosisOptions& options) {
  const size_t equals = setting.find('=');
  const std::string value = equals == std::string::npos ? "" : setting.substr(equals + 1);
  char* end = nullptr;
  const double number = std::strtod(value.c_str(), &end);
  require(!value.empty() && *end == '\0' && std::isfinite(number), "--set: found '", setting,
          "', expected NAME=VALUE.");
  options.thresholds.*find_threshold(setting.substr(0, equals)).value = number;
}

void print_thresholds(const std::string& sweeps) {
  const std::map<std::string, std::string> changed =
      sweeps.empty() ? std::map<std::string, std::string>() : changes_in(sweeps);
  fmt::print("| number | value | holds when | because | chosen on seeds |{}\n|---|---|---|---|---|{}\n",
             sweeps.empty() ? "" : " multiplied by |", sweeps.empty() ? "" : "---|");
  const Thresholds defaults;
  for (const ThresholdEntry& e : threshold_table()) {
    const auto of = changed.find(e.name);
    fmt::print("| `{}` | {:g} | {} | {} | {} |{}\n", e.name, defaults.*e.value, e.inequality, e.reason,
               e.seeds.empty() ? "-" : e.seeds,
               sweeps.empty() ? "" : " " + (of == changed.end() ? "-" : of->second) + " |");
  }
}

const std::vector<std::string>& swept_rooms() {
  static const std::vector<std::string> kAll = {"quality", "estimation", "watch", "compare", "fleet", "identification"};
  return kAll;
}

namespace {

template <typename Numbers>
void print_table(const std::vector<TableNumber<Numbers>>& table, const std::string& sweeps) {
  const std::map<std::string, std::string> changed =
      sweeps.empty() ? std::map<std::string, std::string>() : changes_in(sweeps);
  fmt::print("| number | value | multiplied by |\n|---|---|---|\n");
  for (const TableNumber<Numbers>& one : table) {
    const auto of = changed.find(one.name);
    fmt::print("| `{}` | {:g} | {} |\n", one.name, one.in(Numbers()), of == changed.end() ? "-" : of->second);
  }
}

SweptRoom room_named(const SweepRequest& request, const std::string& folder) {
  if (request.room == "quality") return quality_room(request.seed, folder);
  if (request.room == "estimation") return estimation_room(request.seed);
  if (request.room == "watch") return watch_room(request.seed);
  if (request.room == "compare") return comparison_room(request.seed, folder);
  if (request.room == "fleet") return fleet_room(request.seed);
  if (request.room == "identification") return identification_room(request.seed, folder);
  return diagnosis_room(request.options, request.seed, folder);
}

}  // namespace

void print_numbers(const std::string& room, const std::string& sweeps) {
  if (room == "quality") print_table(quality_numbers(), sweeps);
  if (room == "estimation") print_table(estimation_numbers(), sweeps);
  if (room == "watch") print_table(watch_numbers(), sweeps);
  if (room == "compare") print_table(comparison_numbers(), sweeps);
  if (room == "fleet") print_table(fleet_numbers(), sweeps);
  if (room == "identification") print_table(identification_numbers(), sweeps);
}

SweptRoom diagnosis_room(const DiagnosisOptions& options, unsigned seed, const std::string& folder) {
  SweptRoom out;
  for (const ThresholdEntry& e : threshold_table()) out.numbers.push_back(e.name);
  out.value = [options](const std::string& number) { return options.thresholds.*find_threshold(number).value; };
  for (SweepCase& one : sweep_board(seed, folder)) {
    const auto ask = [one, options](const std::string& number, double factor) {
      DiagnosisOptions moved = options;
      moved.thresholds.*find_threshold(number).value *= factor;
      return one.ask(moved);
    };
    out.cases.push_back({one.name, ask, [one](const std::string& number) { return concerns(one, number); }});
  }
  return out;
}

void write_sweeps(const SweepRequest& request) {
  namespace fs = std::filesystem;
  const std::string& file = request.file;
  std::vector<std::string> lines = fs::exists(file) ? read_sweeps(file) : std::vector<std::string>{kHeader};
  const fs::path folder = fs::temp_directory_path() / fmt::format("veridyn-sweeps-{}", getpid());
  const SweptRoom room = room_named(request, folder.string());
  const std::vector<std::string> numbers = request.numbers.empty() ? unswept(room, lines) : request.numbers;
  for (const std::string& number : numbers) room.value(number);  // throws where there is none
  Answers as_it_is;
  for (const RoomCase& one : room.cases) {
    as_it_is.push_back(ask(one, room.numbers.front(), 1.0));
    fmt::print("{:<5} {}: {}\n", as_it_is.back().right ? "right" : "wrong", one.name, as_it_is.back().said);
    std::fflush(stdout);
  }
  std::vector<double> factors = request.factors;
  std::sort(factors.begin(), factors.end());
  for (const std::string& name : numbers) {
    std::vector<RoomCase> board;
    Answers base, first, last;
    for (size_t k = 0; k < room.cases.size(); ++k) {
      if (!room.cases[k].concerns(name)) continue;
      board.push_back(room.cases[k]);
      base.push_back(as_it_is[k]);
      first.push_back(ask(board.back(), name, factors.front()));
      last.push_back(ask(board.back(), name, factors.back()));
    }
    lines.erase(std::remove_if(lines.begin(), lines.end(),
                               [&name](const std::string& l) { return fields_of(l).front() == name; }),
                lines.end());
    const auto add = [&](double factor, const Answers& answers) {
      lines.push_back(fmt::format("{},{:g},{:g},{},{},{}", name, factor, factor * room.value(name),
                                  counts(board, base, answers), request.seed, today()));
      fmt::print("{}\n", lines.back());
      std::fflush(stdout);
    };
    add(1.0, base);
    for (const double factor : factors) {
      Answers answers = factor == factors.front() ? first : last;
      for (size_t k = 0; k < board.size() && factor != factors.front() && factor != factors.back(); ++k) {
        const bool moves = first[k].said != base[k].said || last[k].said != base[k].said;
        answers[k] = moves ? ask(board[k], name, factor) : base[k];
      }
      add(factor, answers);
    }
    std::ofstream out(file);
    for (const std::string& line : lines) out << line << "\n";
    require(out.good(), file, ": cannot be written.");
  }
  fs::remove_all(folder);
}

}  // namespace veridyn::seek
