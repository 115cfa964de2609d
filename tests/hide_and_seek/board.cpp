#include "hide_and_seek/board.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <filesystem>
#include <fstream>

#include "hide_and_seek/blind.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/report/diagnosis_json.hpp"

namespace veridyn::seek {
namespace {




const std::vector<std::string>& changed_causes() {
  static const std::vector<std::string> kNames = {
      "payload",          "torque_gain",      "encoder_offset",   "gravity_tilt",
      "viscous_friction", "coulomb_friction", "external_contact", "torque_offset"};
  return kNames;
}

std::vector<std::string> effects_of(const BoardRequest& request, Mode mode) {
  if (!request.effects.empty()) return request.effects;
  if (mode == Mode::kChanged) return changed_causes();
  std::vector<std::string> names = all_causes();
  names.erase(std::find(names.begin(), names.end(), "payload"));  // part of the bodies' own values
  return names;
}

void add_mode(const BoardRequest& request, Mode mode, Trouble trouble,
              std::vector<BoardCase>& out) {
  std::string suffix = mode == Mode::kChanged ? " (changed)" : "";
  if (trouble != Trouble::kNone) suffix += std::string(" ") + name_of(trouble);
  for (const std::string& effect : effects_of(request, mode)) {
    for (const std::string& arm : request.arms) {
      for (const unsigned seed : request.seeds) {
        CaseRequest asked{arm, {effect}, seed, request.share, mode, trouble, request.noise};
        if (effect == "none") asked.effects.clear();
        out.push_back({asked, effect + suffix});
      }
    }
  }
}

// Two effects out of all that are not of the whole arm.
void add_pairs(const BoardRequest& request, std::vector<BoardCase>& out) {
  std::vector<std::string> names = effects_of(request, Mode::kBare);
  names.erase(std::remove_if(names.begin(), names.end(),
                             [](const std::string& e) {
                               return e == "none" || e == "time_delay" || e == "torque_gain";
                             }),
              names.end());
  require(!request.one_joint || names.size() > 1, "--one-joint: found ", names.size(), " effects, expected two or more.");
  for (int k = 0; k < request.pairs; ++k) {
    for (const std::string& arm : request.arms) {
      for (const unsigned seed : request.seeds) {
        std::vector<std::string> pair = names;
        Draw draw(seed, "pair " + std::to_string(k) + arm);
        draw.shuffle(pair);
        if (request.one_joint) {  // the others in turn
          const std::string& first = names.front();
          pair = {first, names[1 + (static_cast<size_t>(k) + seed) % (names.size() - 1)]};
        }
        pair.resize(2);
        out.push_back({{arm, pair, seed, request.share, Mode::kBare, Trouble::kNone, request.noise, request.one_joint},
                       "pair"});
      }
    }
  }
}

Json record_of(const HiddenCase& hidden, const Verdict& v, const Diagnosis& d) {
  Json out = {{"arm", hidden.request.arm},
              {"mode", hidden.request.mode == Mode::kBare ? "bare" : "changed"},
              {"trouble", name_of(hidden.request.trouble)},
              {"seed", hidden.request.seed},
              {"asked_share", hidden.request.share}};
  out["hidden"] = truth_json(hidden)["causes"];
  out["visible"] = {{"share", hidden.visible.share},
                    {"residue", hidden.visible.residue},
                    {"best_gain", hidden.visible.best_gain},
                    {"oracle_t", hidden.visible.oracle_t}};
  std::vector<double> noise;
  for (const JointSensors& s : hidden.bench.sensors) noise.push_back(s.torque_noise);
  out["torque_noise"] = noise;
  out["verdict"] = {{"first", v.first},           {"first_rival", v.first_rival},
                    {"named", v.named},           {"named_rival", v.named_rival},
                    {"loosely", v.named_loosely}, {"extras", v.extras},
                    {"intervals", v.intervals},   {"covered", v.covered},
                    {"outside", v.outside},       {"error_ratio", v.error_ratio}};
  out["diagnosis"] = Json::parse(to_json(d));
  return out;
}

double median(std::vector<double> v) {
  if (v.empty()) return 0.0;
  std::nth_element(v.begin(), v.begin() + static_cast<long>(v.size() / 2), v.end());
  return v[v.size() / 2];
}

void print_row(const std::string& name, const std::vector<Outcome>& all) {
  const Totals t = totals(all);
  int named_rival = 0;
  int loosely = 0;
  std::vector<double> ratio, seconds;
  for (const Outcome& o : all) {
    if (!o.observable) continue;
    named_rival += o.verdict.named_rival;
    loosely += o.verdict.named_loosely;
    ratio.push_back(o.verdict.error_ratio);
    seconds.push_back(o.seconds);
  }
  fmt::print(
      "{:<29} {:>5} {:>6} {:>6} {:>6} {:>6} {:>6} {:>6} {:>7} {:>4}/{:<4} {:>6.2f} {:>6.1f} "
      "{:>5}\n",
      name, t.cases, t.first, t.first_rival, fmt::format("{}/{}", t.named, t.hidden), named_rival,
      loosely, t.with_extras, t.extras, t.covered, t.intervals, median(ratio), median(seconds),
      t.unseen);
}

}  // namespace

std::string findings_text(const std::vector<NamedFinding>& findings) {
  std::string out;
  for (const NamedFinding& f : findings) {
    out += fmt::format("{}{}@{}", out.empty() ? "" : ", ", f.effect,
                       f.frame.empty() ? std::to_string(f.joint) : f.frame);
    if (!f.rivals.empty()) out += fmt::format("(+{} rivals)", f.rivals.size());
  }
  return out.empty() ? "none" : out;
}

std::string words_of(const Verdict& v) {
  if (v.hidden == 0) return v.extras == 0 ? "right" : "FALSE NAME";
  std::string out = v.first ? "first" : v.first_rival ? "rival" : v.named > 0 ? "later" : "MISSED";
  if (v.hidden > 1) out += fmt::format(" {}/{}", v.named, v.hidden);
  if (v.extras > 0) out += fmt::format(" +{} wrong", v.extras);
  return out;
}

std::vector<BoardCase> cases_of(const BoardRequest& request) {
  std::vector<BoardCase> out;
  if (request.pairs > 0) {
    add_pairs(request, out);
    return out;
  }
  std::vector<Trouble> troubles;
  for (const std::string& name : request.troubles) troubles.push_back(trouble_of(name));
  if (troubles.empty()) troubles = {Trouble::kNone};
  for (const Trouble trouble : troubles) {
    if (request.mode != "changed") add_mode(request, Mode::kBare, trouble, out);
    if (request.mode != "bare") add_mode(request, Mode::kChanged, trouble, out);
  }
  return out;
}

namespace {

nlohmann::json to_json(const Outcome& o) {
  const Verdict& v = o.verdict;
  return {o.group, o.observable, o.best_gain, o.seconds, v.hidden, v.first, v.first_rival, v.named,
          v.named_rival, v.named_loosely, v.extras, v.intervals, v.covered, v.error_ratio, v.outside};
}

Outcome outcome_from(const nlohmann::json& in) {
  Outcome o;
  size_t k = 0;
  const auto next = [&](auto& out) { in.at(k++).get_to(out); };
  Verdict& v = o.verdict;
  next(o.group), next(o.observable), next(o.best_gain), next(o.seconds), next(v.hidden), next(v.first);
  next(v.first_rival), next(v.named), next(v.named_rival), next(v.named_loosely), next(v.extras);
  next(v.intervals), next(v.covered), next(v.error_ratio), next(v.outside);
  return o;
}

}  // namespace

Outcome play(const BoardCase& one, const BoardRequest& request) {
  const CaseRequest& asked = one.request;
  const auto begin = std::chrono::steady_clock::now();
  Outcome out;
  out.group = one.group;
  const HiddenCase hidden = hide(asked);
  std::string what;
  for (const Cause& c : hidden.causes)
    what += (what.empty() ? "" : " + ") + describe(c, hidden.bench.robot);
  out.observable = hidden.observable;
  out.best_gain = hidden.visible.best_gain;
  if (!hidden.observable) {
    fmt::print("{:<11} {} {}: not observable on this arm\n", asked.arm, asked.seed, one.group);
    return out;
  }
  if (request.well_visible && out.best_gain < kWellVisible && !hidden.causes.empty()) {
    out.observable = false;
    fmt::print("{:<11} {} {}: too small, best gain {:.2f}\n", asked.arm, asked.seed, what,
               out.best_gain);
    return out;
  }
  namespace fs = std::filesystem;
  const fs::path folder =
      request.keep.empty()
          ? fs::temp_directory_path() / fmt::format("veridyn-hide-and-seek-{}", getpid())
          : fs::path(request.keep) / fmt::format("{}-{}-{}", one.group, asked.arm, asked.seed);
  fs::create_directories(folder);
  const CaseFiles files = write_case(hidden, folder.string());
  DiagnosisOptions options = request.options;
  options.identification.threads = request.threads;
  const Diagnosis d = seek_causes(hidden, files, folder.string(), options);
  if (request.keep.empty()) fs::remove_all(folder);
  out.verdict = judge(hidden, d);
  out.seconds = d.seconds;
  if (!request.json.empty())
    std::ofstream(request.json, std::ios::app) << record_of(hidden, out.verdict, d).dump() << "\n";
  const double all =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  fmt::print("{:<11} {} {} [gain at best {:.2f}]: {} | {} | {}{:.1f} of {:.1f} s\n", asked.arm,
             asked.seed, what.empty() ? one.group : what, out.best_gain, words_of(out.verdict),
             findings_text(named_by(d)), out.verdict.outside, d.seconds, all);
  std::fflush(stdout);
  return out;
}

nlohmann::json settings_of(const BoardCase& one, const BoardRequest& request) {
  const CaseRequest& asked = one.request;
  const PreprocessingOptions& how = request.options.identification.preprocessing;
  std::vector<double> thresholds;
  for (const ThresholdEntry& e : threshold_table()) thresholds.push_back(request.options.thresholds.*e.value);
  const std::filesystem::path program = "/proc/self/exe";
  return {one.group, asked.arm, asked.effects, asked.seed, asked.share, static_cast<int>(asked.mode),
          static_cast<int>(asked.trouble), asked.noise, asked.one_joint, request.well_visible, how.cutoff,
          static_cast<int>(how.velocity), thresholds,
          std::filesystem::last_write_time(program).time_since_epoch().count()};
}

std::vector<Outcome> play_all(const BoardRequest& request) {
  std::vector<Outcome> out;
  for (const BoardCase& one : cases_of(request)) {
    try {
      const nlohmann::json settings = request.journal ? settings_of(one, request) : nlohmann::json();
      if (const nlohmann::json* before = request.journal ? request.journal->find(settings) : nullptr) {
        out.push_back(outcome_from(*before));
        continue;
      }
      out.push_back(play(one, request));
      if (request.journal) request.journal->keep(settings, to_json(out.back()));
    } catch (const std::exception& error) {
      fmt::print("{} {} {}: ERROR {}\n", one.request.arm, one.request.seed, one.group,
                 error.what());
    }
  }
  return out;
}

Totals totals(const std::vector<Outcome>& all) {
  Totals t;
  for (const Outcome& o : all) {
    if (!o.observable) {
      ++t.unseen;
      continue;
    }
    const Verdict& v = o.verdict;
    ++t.cases;
    t.first += static_cast<int>(v.first);
    t.first_rival += static_cast<int>(v.first_rival);
    t.hidden += v.hidden;
    t.named += v.named;
    t.extras += v.extras;
    t.with_extras += static_cast<int>(v.extras > 0);
    t.intervals += v.intervals;
    t.covered += v.covered;
  }
  return t;
}

void print_table(const std::vector<Outcome>& all, const char* title) {
  fmt::print(
      "\n{}\n{:<29} {:>5} {:>6} {:>6} {:>6} {:>6} {:>6} {:>6} {:>7} {:>9} {:>6} {:>6} {:>5}\n",
      title, "hidden", "cases", "first", "+rival", "named", "+rival", "loose", "wrong", "extras",
      "covered", "error", "s", "unseen");
  std::vector<std::string> groups;
  for (const Outcome& o : all) {
    if (std::find(groups.begin(), groups.end(), o.group) == groups.end()) groups.push_back(o.group);
  }
  for (const std::string& group : groups) {
    std::vector<Outcome> mine;
    std::copy_if(all.begin(), all.end(), std::back_inserter(mine),
                 [&](const Outcome& o) { return o.group == group; });
    print_row(group, mine);
  }
  print_row("all", all);
}

}  // namespace veridyn::seek
