#include "hide_and_seek/blind.hpp"

#include "hide_and_seek/baseline.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>

#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/report/diagnosis_json.hpp"

namespace veridyn::seek {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFormat = "veridyn-hide-and-seek 1";

Json read_json(const std::string& path) {
  std::ifstream file(path);
  require(file.good(), path, ": the file is not there or cannot be read.");
  try {
    return Json::parse(file);
  } catch (const Json::parse_error& error) {
    throw InvalidInput(path + ": " + error.what());
  }
}

void write_json(const Json& value, const std::string& path) {
  std::ofstream file(path);
  file << value.dump(1) << "\n";
  require(file.good(), path, ": cannot be written.");
}

// Names of files only: cases are read where the folder stands.
Json names_of(const std::vector<std::string>& paths) {
  Json out = Json::array();
  for (const std::string& path : paths) out.push_back(fs::path(path).filename().string());
  return out;
}

std::vector<std::string> paths_of(const Json& one, const char* key, const fs::path& folder) {
  std::vector<std::string> out;
  for (const Json& name : one.at(key)) out.push_back((folder / name.get<std::string>()).string());
  return out;
}

Cause cause_of(const Json& j) {
  Cause c;
  c.effect = j.at("effect").get<std::string>();
  c.joint = j.at("joint").get<int>() - 1;
  c.from = j.value("from", 0) - 1;
  c.frame = j.value("frame", "");
  c.constant = j.value("constant", "");
  for (const auto& [name, value] : j.at("values").items()) c.values[name] = value.get<double>();
  return c;
}

Named rival_of(const Json& j) {
  Named r;
  r.effect = j.at("effect").get<std::string>();
  r.joint = j.value("joint", 0);
  r.frame = j.value("frame", "");
  r.why = j.value("why", r.frame);
  return r;
}

NamedFinding finding_of(const Json& j) {
  NamedFinding f;
  f.effect = j.at("effect").get<std::string>();
  f.joint = j.value("joint", 0);
  f.frame = j.value("frame", "");
  for (const Json& r : j.value("rivals", Json::array())) f.rivals.push_back(rival_of(r));
  const Json parameters = j.value("parameters", Json::object());
  for (const auto& [name, p] : parameters.items()) {
    if (!p.contains("ci95")) continue;
    f.parameters.push_back({name, "", p.at("value").get<double>(), p.at("ci95").at(0).get<double>(),
                            p.at("ci95").at(1).get<double>()});
  }
  return f;
}

// Findings of one case; `where` begins the message if they have another form.
std::vector<NamedFinding> findings_of(const Json& answer, const std::string& where) {
  std::vector<NamedFinding> out;
  require(answer.contains("findings") && answer["findings"].is_array(), where,
          ": found no list `findings`, expected one (empty where nothing is named).");
  for (const Json& one : answer["findings"]) {
    try {
      out.push_back(finding_of(one));
    } catch (const Json::exception& error) {
      throw InvalidInput(fmt::format("{}, finding {}: {}", where, out.size() + 1, error.what()));
    }
  }
  return out;
}

Json manifest(const std::string& folder) {
  const std::string path = (fs::path(folder) / "cases.json").string();
  Json out = read_json(path);
  require(out.value("format", "") == kFormat, path, ": found the format '",
          out.value("format", ""), "', expected '", kFormat, "'.");
  return out;
}

}  // namespace

Json truth_json(const HiddenCase& hidden) {
  Json also = Json::array();
  for (const Cause& c : hidden.also_true)
    also.push_back({{"effect", c.effect}, {"joint", c.joint + 1}, {"values", c.values}});
  Json causes = Json::array();
  for (size_t k = 0; k < hidden.causes.size(); ++k) {
    const Cause& c = hidden.causes[k];
    causes.push_back({{"effect", c.effect},
                      {"joint", c.joint + 1},
                      {"from", c.from + 1},
                      {"frame", c.frame},
                      {"constant", c.constant},
                      {"share", hidden.shares[k]},
                      {"values", c.values}});
  }
  return {{"causes", causes},
          {"also_true", also},
          {"arm", hidden.request.arm},
          {"seed", hidden.request.seed},
          {"trouble", name_of(hidden.request.trouble)},
          {"best_gain", hidden.visible.best_gain},
          {"oracle_t", hidden.visible.oracle_t}};
}

void export_cases(const BoardRequest& request, const std::string& folder,
                  const std::string& truth) {
  const fs::path top(folder);
  require(!fs::exists(top / "cases.json"), folder, ": holds cases already.");
  fs::create_directories(top);
  Json list = {{"format", kFormat}, {"cases", Json::array()}};
  Json sealed = {{"format", kFormat}, {"cases", Json::object()}};
  int number = 0;
  for (const BoardCase& one : cases_of(request)) {
    const HiddenCase hidden = hide(one.request);
    if (!hidden.observable) {
      fmt::print("{} {} {}: not observable on this arm, left out\n", one.request.arm,
                 one.request.seed, one.group);
      continue;
    }
    const std::string id = fmt::format("case-{:03}", ++number);
    fs::create_directories(top / id);
    const CaseFiles files = write_case(hidden, (top / id).string());
    save_model(hidden.bench.robot, (top / id / "robot.yaml").string());
    Json entry = {{"id", id}, {"robot", "robot.yaml"}};
    if (!files.clean.empty()) entry["before"] = names_of(files.clean);
    entry["train"] = names_of(files.train);
    entry["test"] = names_of(files.test);
    list["cases"].push_back(std::move(entry));
    sealed["cases"][id] = truth_json(hidden);
    sealed["cases"][id]["group"] = one.group;
  }
  write_json(list, (top / "cases.json").string());
  write_json(sealed, truth);
  fmt::print("{}: {} cases; what is hidden in them is in {}\n", folder, number, truth);
}

Json answer_cases(const std::string& folder, const DiagnosisOptions& options) {
  Json out = {{"format", kFormat}, {"tool", "veridyn diagnose"}, {"answers", Json::object()}};
  const Json list = manifest(folder);
  for (const Json& one : list.at("cases")) {
    const auto id = one.at("id").get<std::string>();
    const fs::path here = fs::path(folder) / id;
    Model arm = read_model((here / one.at("robot").get<std::string>()).string());
    if (one.contains("before")) {
      const Identification clean =
          identify(arm, paths_of(one, "before", here), {}, options.identification);
      require(clean.model.has_value(), id, ": the arm could not be identified: ", clean.reason);
      arm = *clean.model;
    }
    const Diagnosis d =
        diagnose(arm, paths_of(one, "train", here), paths_of(one, "test", here), options);
    out["answers"][id] = {{"findings", Json::parse(to_json(d)).at("findings")}};
    fmt::print(stderr, "{}: {}\n", id, findings_text(named_by(d)));
  }
  return out;
}

Json answer_cases_by_least_squares(const std::string& folder, int threads) {
  Json out = {{"format", kFormat}, {"tool", "plain least squares"}, {"answers", Json::object()}};
  const Json list = manifest(folder);
  for (const Json& one : list.at("cases")) {
    const auto id = one.at("id").get<std::string>();
    const fs::path here = fs::path(folder) / id;
    const Model arm = read_model((here / one.at("robot").get<std::string>()).string());
    const std::vector<NamedFinding> named =
        named_by_least_squares(arm, paths_of(one, "train", here), threads);
    Json findings = Json::array();
    for (const NamedFinding& f : named) {
      Json parameters = Json::object();
      for (const FoundParameter& p : f.parameters)
        parameters[p.name] = {{"value", p.value}, {"ci95", {p.low, p.high}}};
      findings.push_back({{"effect", f.effect}, {"joint", f.joint}, {"parameters", parameters}});
    }
    out["answers"][id] = {{"findings", findings}};
    fmt::print(stderr, "{}: {}\n", id, findings_text(named));
  }
  return out;
}

std::vector<Outcome> score(const std::string& folder, const std::string& answers,
                           const std::string& truth) {
  const Json list = manifest(folder);
  const Json sealed = read_json(truth);
  const Json given = read_json(answers);
  require(given.contains("answers") && given["answers"].is_object(), answers,
          ": found no object `answers`, expected one with the names of cases.");
  std::vector<Outcome> out;
  for (const Json& one : list.at("cases")) {
    const auto id = one.at("id").get<std::string>();
    require(sealed.contains("cases") && sealed["cases"].contains(id), truth,
            ": found nothing on ", id, ", expected what is hidden in it.");
    const Json& hidden = sealed["cases"][id];
    std::vector<Cause> causes;
    for (const Json& c : hidden.at("causes")) causes.push_back(cause_of(c));
    std::vector<NamedFinding> findings;
    if (given["answers"].contains(id))
      findings = findings_of(given["answers"][id], answers + ": " + id);
    Outcome o;
    o.group = hidden.value("group", "all cases");
    o.best_gain = hidden.value("best_gain", 0.0);
    std::vector<Cause> also;
    for (const Json& c : hidden.value("also_true", Json::array())) also.push_back(cause_of(c));
    o.verdict = judge(causes, findings, also);
    std::string what;
    for (const Cause& c : causes) {
      what += fmt::format("{}{}@{}", what.empty() ? "" : " + ", c.effect,
                          c.frame.empty() ? std::to_string(c.joint + 1) : c.frame);
    }
    fmt::print("{} {}: {} | {}\n", id, what.empty() ? "none" : what, words_of(o.verdict),
               findings_text(findings));
    out.push_back(std::move(o));
  }
  return out;
}

}  // namespace veridyn::seek
