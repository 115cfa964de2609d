#include "usage.hpp"

#include <regex>
#include <vector>

#include "model/suggestion.hpp"

namespace veridyn::cli {
namespace {

std::vector<std::string> option_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

std::vector<std::string> command_names(const CLI::App& tool) {
  std::vector<std::string> names;
  const auto all = [](const CLI::App*) { return true; };
  for (const CLI::App* command : tool.get_subcommands(all)) names.push_back(command->get_name());
  return names;
}

// The first word that nobody understood; options come first, since they make others look odd.
std::string odd_word(const CLI::App& command) {
  const std::vector<std::string> rest = command.remaining();
  for (const std::string& word : rest) {
    if (word.size() > 1 && word[0] == '-') return word;
  }
  return rest.empty() ? "" : rest.front();
}

std::string one_line(std::string words) {
  for (char& c : words) {
    if (c == '\n') c = ' ';
  }
  // The largest number there is, written out, means that there is no bound.
  static const std::regex kNoBound(" to [0-9]{100,}(\\.0*)?");
  words = std::regex_replace(words, kNoBound, " to any");
  return words.substr(0, words.find_last_not_of(" .") + 1);
}

}  // namespace

std::string usage_message(const CLI::App& tool, const CLI::ParseError& error) {
  const std::vector<CLI::App*> chosen = tool.get_subcommands();
  const CLI::App& command = chosen.empty() ? tool : *chosen.front();
  const std::string word = odd_word(command);
  std::string what = one_line(error.what());
  if (!word.empty() && word[0] == '-') {
    const std::string name = word.substr(0, word.find('='));
    what = "unknown option '" + name + "'" + did_you_mean(name, option_names(command));
  } else if (!word.empty() && chosen.empty()) {
    const std::vector<std::string> commands = command_names(tool);
    what = "unknown command '" + word + "', expected one of " + listed(commands) +
           did_you_mean(word, commands);
  } else if (!word.empty()) {
    what = "found '" + word + "', which nothing asks for";
  } else if (chosen.empty()) {
    what = "no command, expected one of " + listed(command_names(tool));
  }
  const std::string help = chosen.empty() ? "veridyn" : "veridyn " + command.get_name();
  return what + "; see " + help + " --help";
}

}  // namespace veridyn::cli
