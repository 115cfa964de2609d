#include "hide_and_seek/threshold_sweep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>

#include "hide_and_seek/outside.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::seek {
namespace {

constexpr const char* kHeader =
    "number,factor,value,hidden,named,false names,outside,right joint,worded or signals,false names outside,silent,seeds,date";

// What a row of the file counts.
struct Counts {
  int hidden = 0, named = 0, wrong = 0, outside = 0, joint = 0, right = 0, wrong_outside = 0, silent = 0;

  std::string text() const {
    return fmt::format("{},{},{},{},{},{},{},{}", hidden, named, wrong, outside, joint, right, wrong_outside, silent);
  }
};

Counts count(const BoardRequest& request) {
  Counts out;
  const Totals t = totals(play_all(request));
  out.hidden = t.hidden;
  out.named = t.named;
  out.wrong = t.with_extras;
  OutsideRequest other;
  other.arms = request.arms;
  other.seeds = request.seeds;
  other.threads = request.threads;
  other.options = request.options;
  for (const std::string& cause : outside_causes()) {
    for (const std::string& arm : request.arms) {
      for (const unsigned seed : request.seeds) {
        const OutsideScore s = outside_score(other, arm, cause, seed);
        ++out.outside;
        out.joint += s.joint ? 1 : 0;
        out.right += s.joint && (s.signals || s.worded) ? 1 : 0;
        out.wrong_outside += s.false_names > 0 ? 1 : 0;
        out.silent += s.silent ? 1 : 0;
      }
    }
  }
  return out;
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

std::vector<std::string> lines_of(const std::string& file) {
  std::vector<std::string> out;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) out.push_back(line);
  return out;
}

// Of each number, what its factors changed: "0.5: named -1, false names +2".
std::map<std::string, std::string> changes_in(const std::string& file) {
  const std::vector<std::string> lines = lines_of(file);
  require(!lines.empty() && lines.front() == kHeader, file, ":1: found no sweeps, expected the header ", kHeader, ".");
  const std::vector<std::string> names = fields_of(kHeader);
  std::map<std::string, std::vector<std::string>> at_one;
  std::map<std::string, std::string> out;
  for (int turn = 0; turn < 2; ++turn) {
    for (size_t k = 1; k < lines.size(); ++k) {
      const std::vector<std::string> row = fields_of(lines[k]);
      require(row.size() == names.size(), file, ":", k + 1, ": found ", row.size(), " fields, expected ", names.size(), ".");
      if (turn == 0) {
        if (row[1] == "1") at_one[row[0]] = row;
        continue;
      }
      const auto base = at_one.find(row[0]);
      if (row[1] == "1" || base == at_one.end()) continue;
      std::string changed;
      for (size_t c = 4; c + 2 < names.size(); ++c) {
        if (c == 6) continue;  // how many cases there are
        const int by = std::atoi(row[c].c_str()) - std::atoi(base->second[c].c_str());
        if (by != 0) changed += fmt::format("{}{} {:+d}", changed.empty() ? "" : ", ", names[c], by);
      }
      std::string& text = out[row[0]];
      text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", row[1], changed.empty() ? "nothing" : changed);
    }
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

void write_sweeps(const BoardRequest& request, const std::vector<std::string>& names,
                  const std::vector<double>& factors, const std::string& file) {
  const bool fresh = !std::filesystem::exists(file);
  std::vector<std::string> lines = fresh ? std::vector<std::string>{kHeader} : lines_of(file);
  require(!lines.empty() && lines.front() == kHeader, file, ":1: found no sweeps, expected the header ", kHeader, ".");
  for (const std::string& name : names) find_threshold(name);
  const std::string seeds = fmt::format("{}", fmt::join(request.seeds, " "));
  const Counts as_it_is = count(request);
  for (const std::string& name : names) {
    const ThresholdEntry& entry = find_threshold(name);
    lines.erase(std::remove_if(lines.begin(), lines.end(),
                               [&name](const std::string& l) { return fields_of(l).front() == name; }),
                lines.end());
    std::vector<double> all = {1.0};
    all.insert(all.end(), factors.begin(), factors.end());
    for (const double factor : all) {
      BoardRequest moved = request;
      double& value = moved.options.thresholds.*entry.value;
      value *= factor;
      const Counts c = factor == 1.0 ? as_it_is : count(moved);
      lines.push_back(fmt::format("{},{:g},{:g},{},{},{}", name, factor, value, c.text(), seeds, today()));
    }
    std::ofstream out(file);
    for (const std::string& line : lines) out << line << "\n";
    require(out.good(), file, ": cannot be written.");
  }
}

void print_sweep(const BoardRequest& request, const std::string& name,
                 const std::vector<double>& factors) {
  const ThresholdEntry& entry = find_threshold(name);
  fmt::print("{}: {}\n", name, entry.inequality);
  std::string table = fmt::format("\n{:>12} {:>6} {:>6} {:>8} {:>9} {:>6} {:>11}\n", name, "cases",
                                  "first", "named", "diagnoses", "false", "covered");
  for (const double factor : factors) {
    BoardRequest moved = request;
    double& value = moved.options.thresholds.*entry.value;
    value *= factor;
    const Totals t = totals(play_all(moved));
    table += fmt::format("{:>12.4g} {:>6} {:>6} {:>4}/{:<3} {:>9} {:>6} {:>5}/{:<5}\n", value,
                         t.cases, t.first, t.named, t.hidden, t.with_extras, t.extras, t.covered,
                         t.intervals);
  }
  fmt::print("{}", table);
}

}  // namespace veridyn::seek
