// veridyn-hide-and-seek: how often `diagnose` finds what is hidden, measured on arms and recordings
// that share no code with it. Not a test; see hide_and_seek_test.cpp for those.

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <exception>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "hide_and_seek/judge.hpp"
#include "veridyn/report/diagnosis_json.hpp"

namespace veridyn::seek {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kWellVisible =
    0.27;  // best gain of amplitudes thrice the smallest detectable ones

struct Request {
  std::vector<std::string> arms = bench_arms();
  std::vector<std::string> effects;
  std::vector<unsigned> seeds = {1, 2};
  double share = 0.1;
  std::string mode = "bare";
  int pairs = 0;
  int threads = 2;
  std::string json;
  std::string keep;
  bool easy_only = false;
  double cutoff = 0.0;
  bool derived_velocity = false;
};

struct Outcome {
  std::string group;
  bool observable = true;
  double best_gain = 0.0;
  Verdict verdict;
  double seconds = 0.0;
};

const std::vector<std::string>& changed_causes() {
  static const std::vector<std::string> kNames = {
      "payload",          "torque_gain",      "encoder_offset",   "gravity_tilt",
      "viscous_friction", "coulomb_friction", "external_contact", "torque_offset"};
  return kNames;
}

std::vector<std::string> effects_of(const Request& request, Mode mode) {
  if (!request.effects.empty()) return request.effects;
  if (mode == Mode::kChanged) return changed_causes();
  std::vector<std::string> names = all_causes();
  names.erase(std::find(names.begin(), names.end(), "payload"));  // part of the bodies' own values
  return names;
}

Json record_of(const HiddenCase& hidden, const Verdict& v, const Diagnosis& d) {
  Json out = {{"arm", hidden.request.arm},
              {"mode", hidden.request.mode == Mode::kBare ? "bare" : "changed"},
              {"seed", hidden.request.seed},
              {"asked_share", hidden.request.share}};
  out["hidden"] = Json::array();
  for (size_t k = 0; k < hidden.causes.size(); ++k) {
    const Cause& c = hidden.causes[k];
    out["hidden"].push_back({{"effect", c.effect},
                             {"joint", c.joint + 1},
                             {"from", c.from + 1},
                             {"frame", c.frame},
                             {"constant", c.constant},
                             {"share", hidden.shares[k]},
                             {"values", c.values}});
  }
  out["visible"] = {{"share", hidden.visible.share},
                    {"residue", hidden.visible.residue},
                    {"best_gain", hidden.visible.best_gain}};
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

std::string findings_text(const Diagnosis& d) {
  std::string out;
  for (const Finding& f : d.findings) {
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

Outcome play(const CaseRequest& asked, const Request& request, const std::string& group) {
  const auto begin = std::chrono::steady_clock::now();
  Outcome out;
  out.group = group;
  const HiddenCase hidden = hide(asked);
  std::string what;
  for (const Cause& c : hidden.causes)
    what += (what.empty() ? "" : " + ") + describe(c, hidden.bench.robot);
  out.observable = hidden.observable;
  out.best_gain = hidden.visible.best_gain;
  if (!hidden.observable) {
    fmt::print("{:<11} {} {}: not observable on this arm\n", asked.arm, asked.seed, group);
    return out;
  }
  if (request.easy_only && out.best_gain < kWellVisible && !hidden.causes.empty()) {
    out.observable = false;
    fmt::print("{:<11} {} {}: too small, best gain {:.2f}\n", asked.arm, asked.seed, what,
               out.best_gain);
    return out;
  }
  namespace fs = std::filesystem;
  const fs::path folder =
      request.keep.empty()
          ? fs::temp_directory_path() / fmt::format("veridyn-hide-and-seek-{}", getpid())
          : fs::path(request.keep) / fmt::format("{}-{}-{}", group, asked.arm, asked.seed);
  fs::create_directories(folder);
  const CaseFiles files = write_case(hidden, folder.string());
  DiagnosisOptions options;
  options.identification.threads = request.threads;
  PreprocessingOptions& how = options.identification.preprocessing;
  if (request.cutoff > 0.0) how.cutoff = request.cutoff;
  if (request.derived_velocity) how.velocity = VelocitySource::kDerived;
  const Diagnosis d = seek_causes(hidden, files, folder.string(), options);
  if (request.keep.empty()) fs::remove_all(folder);
  out.verdict = judge(hidden, d);
  out.seconds = d.seconds;
  if (!request.json.empty())
    std::ofstream(request.json, std::ios::app) << record_of(hidden, out.verdict, d).dump() << "\n";
  const double all =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  fmt::print("{:<11} {} {} [gain at best {:.2f}]: {} | {} | {}{:.1f} of {:.1f} s\n", asked.arm,
             asked.seed, what.empty() ? "none" : what, out.best_gain, words_of(out.verdict),
             findings_text(d), out.verdict.outside, d.seconds, all);
  std::fflush(stdout);
  return out;
}

double median(std::vector<double> v) {
  if (v.empty()) return 0.0;
  std::nth_element(v.begin(), v.begin() + static_cast<long>(v.size() / 2), v.end());
  return v[v.size() / 2];
}

void print_row(const std::string& name, const std::vector<Outcome>& all) {
  int cases = 0, first = 0, rival = 0, hidden = 0, named = 0, named_rival = 0, loosely = 0;
  int extras = 0, with_extras = 0, intervals = 0, covered = 0, unseen = 0;
  std::vector<double> ratio, seconds;
  for (const Outcome& o : all) {
    if (!o.observable) {
      ++unseen;
      continue;
    }
    const Verdict& v = o.verdict;
    ++cases;
    first += static_cast<int>(v.first);
    rival += static_cast<int>(v.first_rival);
    hidden += v.hidden;
    named += v.named;
    named_rival += v.named_rival;
    loosely += v.named_loosely;
    extras += v.extras;
    with_extras += static_cast<int>(v.extras > 0);
    intervals += v.intervals;
    covered += v.covered;
    ratio.push_back(v.error_ratio);
    seconds.push_back(o.seconds);
  }
  fmt::print(
      "{:<29} {:>5} {:>6} {:>6} {:>6} {:>6} {:>6} {:>6} {:>7} {:>4}/{:<4} {:>6.2f} {:>6.1f} "
      "{:>5}\n",
      name, cases, first, rival, fmt::format("{}/{}", named, hidden), named_rival, loosely,
      with_extras, extras, covered, intervals, median(ratio), median(seconds), unseen);
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

void play_mode(const Request& request, Mode mode, std::vector<Outcome>& all) {
  const std::string suffix = mode == Mode::kChanged ? " (changed)" : "";
  for (const std::string& effect : effects_of(request, mode)) {
    for (const std::string& arm : request.arms) {
      for (const unsigned seed : request.seeds) {
        CaseRequest asked{arm, {effect}, seed, request.share, mode};
        if (effect == "none") asked.effects.clear();
        try {
          all.push_back(play(asked, request, effect + suffix));
        } catch (const std::exception& error) {
          fmt::print("{} {} {}: ERROR {}\n", arm, seed, effect, error.what());
        }
      }
    }
  }
}

// Two effects out of all that are not of the whole arm.
void play_pairs(const Request& request, std::vector<Outcome>& all) {
  std::vector<std::string> names = effects_of(request, Mode::kBare);
  names.erase(std::remove_if(names.begin(), names.end(),
                             [](const std::string& e) {
                               return e == "none" || e == "time_delay" || e == "torque_gain";
                             }),
              names.end());
  for (int k = 0; k < request.pairs; ++k) {
    for (const std::string& arm : request.arms) {
      for (const unsigned seed : request.seeds) {
        std::vector<std::string> pair = names;
        Draw draw(seed, "pair " + std::to_string(k) + arm);
        draw.shuffle(pair);
        pair.resize(2);
        try {
          all.push_back(play({arm, pair, seed, request.share, Mode::kBare}, request, "pair"));
        } catch (const std::exception& error) {
          fmt::print("{} {} pair: ERROR {}\n", arm, seed, error.what());
        }
      }
    }
  }
}

int run(int argc, char** argv) {
  Request request;
  CLI::App app("How often diagnose finds what is hidden");
  app.add_option("--arms", request.arms, "Arms of tests/hide_and_seek/robots or data/robots")
      ->delimiter(',');
  app.add_option("--effects", request.effects, "Names of CONTRACT.md, or none")->delimiter(',');
  app.add_option("--seeds", request.seeds, "Seeds")->delimiter(',');
  app.add_option("--size", request.share, "Rms of the effect, share of its joint's rms torque");
  app.add_option("--mode", request.mode, "bare, changed or both")
      ->check(CLI::IsMember({"bare", "changed", "both"}));
  app.add_option("--pairs", request.pairs, "Two effects at once: so many per arm and seed");
  app.add_option("--threads", request.threads, "Of diagnose");
  app.add_option("--json", request.json, "Append one record per case to this file");
  app.add_option("--keep", request.keep, "Keep the recordings in this folder");
  app.add_flag("--well-visible", request.easy_only,
               "Skip cases below three times the smallest detectable size");
  app.add_option("--filter-cutoff", request.cutoff, "[Hz] instead of the default of diagnose");
  app.add_flag("--derived-velocity", request.derived_velocity,
               "Velocity from q instead of the recorded one");
  CLI11_PARSE(app, argc, argv);
  std::vector<Outcome> all;
  if (request.pairs > 0) {
    play_pairs(request, all);
  } else {
    if (request.mode != "changed") play_mode(request, Mode::kBare, all);
    if (request.mode != "bare") play_mode(request, Mode::kChanged, all);
  }
  print_table(all, "all cases");
  std::vector<Outcome> seen;
  std::copy_if(all.begin(), all.end(), std::back_inserter(seen), [](const Outcome& o) {
    return o.observable && (o.best_gain >= kWellVisible || o.verdict.hidden == 0);
  });
  print_table(seen, "cases at or above three times the smallest detectable size");
  return 0;
}

}  // namespace
}  // namespace veridyn::seek

int main(int argc, char** argv) {
  return veridyn::seek::run(argc, argv);
}
