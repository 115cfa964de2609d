#include "tool/usage.hpp"

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

// The command that the user meant, such as `calibrate links`, with its full name.
struct Meant {
  const CLI::App* command;
  std::string name = "veridyn";
  std::string odd;  // first argument that was not understood
};

// The first argument that was not understood; options are preferred, since they affect the meaning of the others.
std::string unexpected_argument(const CLI::App& command) {
  const std::vector<std::string> rest = command.remaining();
  for (const std::string& word : rest) {
    if (word.size() > 1 && word[0] == '-') return word;
  }
  return rest.empty() ? "" : rest.front();
}

Meant intended_command(const CLI::App& tool) {
  Meant out{&tool, "veridyn", unexpected_argument(tool)};
  while (!out.command->get_subcommands().empty()) {
    out.command = out.command->get_subcommands().front();
    out.name += " " + out.command->get_name();
    if (out.odd.empty()) out.odd = unexpected_argument(*out.command);
  }
  return out;
}

// Words for the values that an option expects: "a whole number".
std::string kind_of(const CLI::Option* option) {
  const std::string type = option == nullptr ? "" : option->get_type_name();
  if (type.find("NONNEGATIVE") != std::string::npos) return "a number that is not negative";
  if (type.find("POSITIVE") != std::string::npos) return "a number above zero";
  if (type.find("UINT") != std::string::npos) return "a whole number that is not negative";
  if (type.find("INT") != std::string::npos) return "a whole number";
  if (type.find("FLOAT") != std::string::npos) return "a number";
  return "a value of another kind";
}

// Removes trailing zeros: "0.5" for "0.500000".
std::string trimmed_number(const std::string& number) {
  const bool decimals = number.find('.') != std::string::npos;
  std::string out = decimals ? number.substr(0, number.find_last_not_of('0') + 1) : number;
  if (!out.empty() && out.back() == '.') out.pop_back();
  return out;
}

// Converts the parser's message to the form "found ..., expected ...".
std::string found_and_expected(const CLI::App& command, const std::string& words) {
  static const std::regex kRange("^(.*): Value (.*) not in range (\\S+) to (\\S+)$");
  static const std::regex kOneOf("^(.*): (.*) not in \\{(.*)\\}$");
  static const std::regex kConversion("^Could not convert: (\\S+) = (.*)$");
  static const std::regex kMissing("^(.*): [0-9]+ required .+ missing$");
  static const std::regex kRequired("^(.*) is required$");
  std::smatch m;
  const auto option = [&command](const std::string& name) {
    return command.get_option_no_throw(name.substr(0, name.find(',')));
  };
  if (std::regex_match(words, m, kRange)) {
    const std::string kind = kind_of(option(m[1]));
    const bool bounded = m[4].length() < 100;
    const std::string expected =
        bounded ? "a number from " + trimmed_number(m[3]) + " to " + trimmed_number(m[4]) : kind;
    return m[1].str() + ": found '" + m[2].str() + "', expected " + expected;
  }
  if (std::regex_match(words, m, kOneOf)) {
    const std::vector<std::string> names = CLI::detail::split(m[3], ',');
    return m[1].str() + ": found '" + m[2].str() + "', expected one of " + listed(names) +
           did_you_mean(m[2], names);
  }
  if (std::regex_match(words, m, kConversion))
    return m[1].str() + ": found '" + m[2].str() + "', expected " + kind_of(option(m[1]));
  if (std::regex_match(words, m, kMissing) || std::regex_match(words, m, kRequired)) {
    const CLI::Option* const missing = option(m[1]);
    const std::string text = missing == nullptr ? "" : missing->get_option_text();
    const bool named = text.find_first_not_of(' ') != std::string::npos;
    const std::string kind = kind_of(missing);
    return m[1].str() + ": found nothing, expected " +
           (named                               ? text
            : kind == "a value of another kind" ? "a value"
                                                : kind);
  }
  return words;
}

std::string one_line(std::string words) {
  for (char& c : words) {
    if (c == '\n') c = ' ';
  }
  return words.substr(0, words.find_last_not_of(" .") + 1);
}

}  // namespace

std::string usage_message(const CLI::App& tool, const CLI::ParseError& error) {
  const Meant meant = intended_command(tool);
  const CLI::App& command = *meant.command;
  const std::string& word = meant.odd;
  const std::vector<std::string> commands = command_names(command);
  const bool top = &command == &tool;
  std::string what = found_and_expected(command, one_line(error.what()));
  if (!word.empty() && word[0] == '-') {
    const std::string name = word.substr(0, word.find('='));
    what = "unknown option '" + name + "'" + did_you_mean(name, option_names(command));
  } else if (!word.empty() && !commands.empty()) {
    what = "unknown command '" + word + "'" + (top ? "" : " of " + command.get_name()) +
           ", expected one of " + listed(commands) + did_you_mean(word, commands);
  } else if (!word.empty()) {
    what = "found '" + word + "', which nothing asks for";
    if (command.get_option_no_throw("--train") != nullptr) what += "; recordings follow --train or --test";
  } else if (!commands.empty() && command.get_subcommands().empty()) {
    what = "no command" + std::string(top ? "" : " of " + command.get_name()) +
           ", expected one of " + listed(commands);
  }
  return what + "; see " + meant.name + " --help";
}

}  // namespace veridyn::cli
