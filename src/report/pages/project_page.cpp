#include <fmt/chrono.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "report/pages/page.hpp"
#include "report/pages/page_series.hpp"
#include "veridyn/diagnosis/model_comparison.hpp"
#include "veridyn/effects/effect_facts.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/files/model_origin.hpp"
#include "veridyn/report/pages.hpp"

namespace veridyn {
namespace {

namespace fs = std::filesystem;

constexpr int kDeepest = 4;                       // largest depth of subfolders
constexpr std::size_t kMostSentences = 6;         // largest number of sentences for one page or one change
constexpr std::uintmax_t kLargestPage = 8u << 20;  // [bytes] larger pages are skipped

struct DatedModel {
  std::string file, date;
  Model model;
};

// In UTC, as 2026-01-31T12:00:00Z; empty if the file does not exist.
std::string modification_time(const fs::path& path) {
  struct stat about {};
  if (::stat(path.c_str(), &about) != 0) return "";
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(about.st_mtime));
}

// Empty if the file cannot be read.
std::string content_of_file(const fs::path& path) {
  std::ostringstream out;
  out << std::ifstream(path, std::ios::binary).rdbuf();
  return out.str();
}

// Reads the result inside a page or a file of --json; null for other files.
Json result_in(const fs::path& path) {
  std::error_code error;
  if (fs::file_size(path, error) > kLargestPage || error) return nullptr;
  std::string text = content_of_file(path);
  if (path.extension() == ".html") {
    static const std::string kOpen = "<script type=\"application/json\" id=\"result\">";
    const std::size_t at = text.find(kOpen);
    if (at == std::string::npos) return nullptr;
    text = text.substr(at + kOpen.size(), text.find("</script>", at) - at - kOpen.size());
  }
  const Json found = Json::parse(text, nullptr, false);
  const bool ours = found.is_object() && found.contains("veridyn") && found.contains("command");
  return ours && found["command"].is_string() ? found : Json();
}

// The first kMostSentences sentences of verdict and findings, without insignificant ones.
Json sentences_of(const Json& result) {
  Json out = Json::array();
  const auto add = [&out](const Json& sentence) {
    if (sentence.is_string() && out.size() < kMostSentences) out.push_back(sentence);
  };
  if (result.contains("verdict") && result["verdict"].is_object())
    add(result["verdict"].value("sentence", Json()));
  for (const char* list : {"findings", "joints", "data_quality"}) {
    if (!result.contains(list) || !result[list].is_array()) continue;
    for (const Json& one : result[list])
      if (one.is_object() && one.value("significant", Json(true)) != false && one.value("severity", Json()) != "info")
        add(one.value("sentence", Json()));
  }
  return out;
}

// Effect parameters of the model that have a value; "std" is null where unknown.
Json parameters_of(const Model& arm) {
  Json out = Json::array();
  for (const EffectTerm& term : arm.effects()) {
    if (!term.frame.empty() || !has_axis_effect(term.effect)) continue;
    const EffectFacts effect(arm, term);
    for (int p = 0; p < effect.parameter_count(); ++p) {
      const std::string& name = effect.parameters()[p].name;
      if (term.values.count(name) == 0) continue;
      const auto deviation = term.deviations.find(name);
      out.push_back({{"name", effect.parameter_name(p)},
                     {"value", term.values.at(name)},
                     {"std", deviation == term.deviations.end() ? Json() : Json(deviation->second)},
                     {"unit", effect.unit(p)}});
    }
  }
  return out;
}

Json model_json(const DatedModel& one, const ModelOrigin& origin) {
  const auto& identified = one.model.description().identified;
  Json inputs = json_each(origin.inputs, [&](const OriginFile& input) -> Json { return input.file; });
  return {{"file", one.file},
          {"robot", one.model.name()},
          {"date", one.date},
          {"command", origin.command},
          {"inputs", inputs},
          {"relative_error", identified ? json_list(identified->error) : Json::array()},
          {"parameters", parameters_of(one.model)}};
}

// Differences of two successive models of one robot, or the reason why they cannot be compared.
Json change_json(const DatedModel& before, const DatedModel& after) {
  Json out = {{"robot", after.model.name()}, {"before", before.file}, {"after", after.file},
              {"date", after.date},          {"sentences", Json::array()}};
  try {
    const ModelComparison found = compare(before.model, after.model);
    out["verdict"] = found.verdict == ComparisonVerdict::kSame     ? "same"
                     : found.verdict == ComparisonVerdict::kDiffer ? "differ"
                                                                   : "cannot-tell";
    for (const auto* list : {&found.joints, &found.parameters})
      for (const ModelDifference& d : *list)
        if (d.significant && out["sentences"].size() < kMostSentences) out["sentences"].push_back(d.sentence);
  } catch (const InvalidInput& why) {
    out["verdict"] = "cannot-tell";
    out["sentences"].push_back(why.what());
  }
  return out;
}

Json project_result(const std::string& folder, const std::string& output) {
  require(fs::is_directory(folder), folder, ": found no such folder, expected one with results.");
  Json result = json_head("page");
  for (const char* list : {"models", "pages", "recordings", "changes", "unreadable"})
    result[list] = Json::array();
  result["folder"] = folder;
  result["name"] = fs::weakly_canonical(folder).filename().string();
  std::vector<fs::path> files;
  for (auto at = fs::recursive_directory_iterator(folder); at != fs::end(at); ++at) {
    const std::string name = at->path().filename().string();
    if (name[0] == '.' || at.depth() > kDeepest) {
      if (at->is_directory()) at.disable_recursion_pending();
    } else if (at->is_regular_file()) {
      files.push_back(at->path());
    }
  }
  std::sort(files.begin(), files.end());
  std::vector<DatedModel> models;
  const fs::path beside = fs::absolute(output).parent_path();
  for (const fs::path& path : files) {
    const std::string extension = path.extension().string();
    const std::string file = fs::relative(path, folder).string();
    if (fs::absolute(path) == fs::absolute(output)) continue;
    if (extension == ".html" || extension == ".json") {
      const Json found = result_in(path);
      if (found.is_null() || found["command"] == "page") continue;
      const Json robot = found.value("robot", found.value("scenario", Json("")));
      result["pages"].push_back({{"file", file},
                                 {"link", fs::relative(path, beside).generic_string()},
                                 {"command", found["command"]},
                                 {"robot", robot},
                                 {"date", modification_time(path)},
                                 {"sentences", sentences_of(found)}});
    } else if (extension == ".yaml" || extension == ".yml") {
      try {
        const std::optional<ModelOrigin> origin = read_origin(path.string());
        if (!origin) continue;
        models.push_back({file, origin->date, read_model(path.string())});
        result["models"].push_back(model_json(models.back(), *origin));
      } catch (const InvalidInput& why) {
        result["unreadable"].push_back(why.what());
      }
    } else if (extension == ".csv" || extension == ".bag" || extension == ".mcap" ||
               extension == ".db3" || extension == ".npz" || extension == ".mat" ||
               extension == ".h5") {
      result["recordings"].push_back(
          {{"file", file}, {"date", modification_time(path)}, {"bytes", fs::file_size(path)}});
    }
  }
  const auto earlier = [](const Json& a, const Json& b) { return a["date"] < b["date"]; };
  for (const char* list : {"models", "pages", "recordings"})
    std::stable_sort(result[list].begin(), result[list].end(), earlier);
  std::stable_sort(models.begin(), models.end(),
                   [](const DatedModel& a, const DatedModel& b) { return a.date < b.date; });
  for (std::size_t k = 1; k < models.size(); ++k) {
    for (std::size_t j = k; j-- > 0;) {
      if (models[j].model.name() != models[k].model.name()) continue;
      result["changes"].push_back(change_json(models[j], models[k]));
      break;
    }
  }
  require(!result["models"].empty() || !result["pages"].empty(), folder,
          ": found neither a MODEL nor a page of veridyn, expected some.");
  return result;
}

}  // namespace

std::string project_page(const std::string& folder, const std::string& output,
                         const std::string& command) {
  return html_page(folder + ": what stands in it", json_text(project_result(folder, output)), series_of(command), "");
}

std::string project_json(const std::string& folder, const std::string& output) {
  return json_text(project_result(folder, output));
}

}  // namespace veridyn
