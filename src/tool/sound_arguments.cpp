#include "veridyn/tool/sound_arguments.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "files/words.hpp"
#include "recordings/csv/csv_table.hpp"
#include "recordings/bags/file_kind.hpp"
#include "files/robot_format.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::cli {
namespace {

namespace fs = std::filesystem;

// Type of options whose value is an output file, for messages about a missing value.
constexpr const char* kOutputType = "FILE to write";

struct NamedFile {
  std::string option;
  fs::path path;
};

bool is_output_option(const CLI::Option& option) { return option.get_type_name() == kOutputType; }

// The absolute path of a file that may not exist yet.
fs::path absolute_path(const std::string& path) {
  std::error_code error;
  const fs::path out = fs::weakly_canonical(fs::absolute(path, error), error);
  return error ? fs::path(path) : out;
}

// True for two names of one file, hard links included.
bool same_file(const fs::path& a, const fs::path& b) {
  std::error_code error;
  return a == b || fs::equivalent(a, b, error);
}

void expect_finite(const std::string& name, const std::string& word) {
  if (const auto value = number_in(word); value && !std::isfinite(*value))
    throw CLI::ValidationError(name, "found " + word + ", expected a finite number");
}

// True if the file may have topics: it is not a plain table t,q1,...
bool may_have_topics(const std::string& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return true;  // a pipe
  try {
    recordings::OpenedFile file(path);
    if (file.kind != recordings::FileKind::kText) return true;
    CsvLines lines(std::move(*file.bytes));
    return recordings::table_header(lines, {}).has_value();
  } catch (const InvalidInput&) {
    return true;  // unreadable files are reported by the reader
  }
}

void expect_topics_somewhere(const CLI::App& command) {
  const CLI::Option* topic = command.get_option_no_throw("--topic");
  if (topic == nullptr || topic->count() == 0) return;
  std::string plain;
  for (const char* name : {"REC", "SOURCE", "--train", "--test", "--recording", "--given", "--replay"}) {
    const CLI::Option* option = command.get_option_no_throw(name);
    if (option == nullptr) continue;
    for (const std::string& path : option->results()) {
      std::error_code error;
      const bool robot = robot_format(path).has_value() && fs::path(path).extension() != ".json";
      // A missing file is reported elsewhere.
      if (robot || (path != "-" && !fs::exists(path, error))) continue;
      if (path == "-" || may_have_topics(path)) return;
      plain = path;
    }
  }
  if (!plain.empty())
    throw CLI::ValidationError("--topic", "means nothing here, " + plain + " is a plain table without topics");
}

void check_command_arguments(const CLI::App& command) {
  expect_topics_somewhere(command);
  std::vector<NamedFile> outputs;
  std::vector<NamedFile> inputs;
  for (const CLI::Option* option : command.get_options()) {
    const std::string name = option->get_name();
    for (const std::string& word : option->results()) {
      if (word.empty() && option->get_expected_min() > 0)
        throw CLI::ValidationError(name, "found an empty word, expected " +
                                             (option->get_option_text().empty() ? "a value" : option->get_option_text()));
      if (is_output_option(*option)) {
        // Several outputs may go to one device.
        std::error_code error;
        if (!fs::exists(word, error) || fs::is_regular_file(word, error))
          outputs.push_back({name, absolute_path(word)});
        continue;
      }
      expect_finite(name, word);
      std::error_code error;
      if (!number_in(word) && fs::is_regular_file(word, error))
        inputs.push_back({name, absolute_path(word)});
    }
  }
  for (size_t k = 0; k < outputs.size(); ++k) {
    for (size_t other = 0; other < k; ++other) {
      if (same_file(outputs[k].path, outputs[other].path))
        throw CLI::ValidationError(outputs[k].option,
                                   "found the same file as for " + outputs[other].option);
    }
    for (const NamedFile& input : inputs) {
      if (same_file(outputs[k].path, input.path))
        throw CLI::ValidationError(
            outputs[k].option, "found the same file as for " + input.option + ", which is read");
    }
  }
}

}  // namespace

CLI::Option* add_output_option(CLI::App& command, const std::string& option, std::string& target,
                               const std::string& help, const std::vector<std::string>& endings) {
  static const std::vector<std::string> kYaml = {".yaml", ".yml"};
  static const std::map<std::string, std::vector<std::string>> kOfOption = {
      {"--json", {".json"}}, {"--report", {".html", ".htm"}}, {"--urdf", {".urdf", ".xml"}}, {"--mjcf", {".xml", ".mjcf"}},
      {"--sdf", {".sdf", ".xml"}}, {"--yaml", kYaml}, {"--coefficients", kYaml}, {"--model-out", kYaml}, {"--robot-out", kYaml}};
  static const std::set<std::string> kKnown = {".yaml", ".yml", ".json", ".html", ".htm", ".urdf", ".xml", ".mjcf", ".sdf", ".csv"};
  CLI::Option* const out =
      command.add_option(option, target, help)->type_name(kOutputType)->option_text("FILE");
  const auto own = kOfOption.find(option);
  const std::vector<std::string> expected = own == kOfOption.end() || !endings.empty() ? endings : own->second;
  if (expected.empty()) return out;
  const bool model = option == "--model-out" || option == "--robot-out" || option == "--yaml";
  return out->check([expected, model](const std::string& path) {
    const std::string ending = fs::path(path).extension().string();
    if (kKnown.count(ending) == 0 || std::find(expected.begin(), expected.end(), ending) != expected.end()) return std::string();
    return "found '" + path + "', expected a " + expected.front() + " file" +
           (model ? "; `veridyn export` writes the model as " + ending.substr(1) : "");
  });
}

void require_separate_output(const std::string& option, const std::string& output,
                  const std::vector<std::string>& inputs) {
  for (const std::string& input : inputs) {
    if (!output.empty() && same_file(absolute_path(output), absolute_path(input)))
      throw CLI::ValidationError(option, "found '" + output + "', which is read, expected another file");
  }
}

void check_arguments(CLI::App& tool) {
  for (CLI::App* command : tool.get_subcommands([](const CLI::App*) { return true; })) {
    command->parse_complete_callback([command] { check_command_arguments(*command); });
    check_arguments(*command);
  }
}

}  // namespace veridyn::cli
