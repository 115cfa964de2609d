#include "tool/manual.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <system_error>

#include "tool/examples.hpp"
#include "files/output_file.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/report/json/json_value.hpp"

namespace veridyn::cli {
namespace {

constexpr size_t kTextColumn = 30;

std::string names_of(const CLI::Option& option) {
  const std::string value = option.get_option_text().empty() && option.get_type_size() > 0
                                ? option.get_type_name()
                                : option.get_option_text();
  const std::string names = option.get_name(false, true);
  return value.find_first_not_of(' ') == std::string::npos ? names : names + " " + value;
}

// The default value in parentheses, or empty if the description states it. Negative numbers, and zero unless
// the description explains it, often stand for "not given" and are omitted too.
std::string default_of(const CLI::Option& option) {
  const std::string& value = option.get_default_str();
  const std::string& words = option.get_description();
  const bool stated =
      words.find("default") != std::string::npos || (!words.empty() && words.back() == ')');
  const bool placeholder = value.empty() || value[0] == '[' || value[0] == '-' || value[0] == '{' ||
                           value == "nan" || value == "inf" ||
                           (value == "0" && words.find("0:") == std::string::npos);
  return stated || placeholder || option.get_positional() || option.get_type_size() == 0
             ? ""
             : " (" + value + ")";
}

std::vector<const CLI::App*> subcommands_of(const CLI::App& command) {
  return command.get_subcommands([](const CLI::App*) { return true; });
}

// Visits a command and all commands below it, with their full names.
template <typename Visit>
void for_each_command(const CLI::App& command, const std::string& name, const Visit& visit) {
  visit(command, name);
  for (const CLI::App* below : subcommands_of(command))
    for_each_command(*below, name + " " + below->get_name(), visit);
}

// Columns of the terminal, between 60 and 120; 100 without a terminal.
size_t terminal_width() {
  winsize size{};
  const bool terminal = ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return terminal ? std::clamp<size_t>(size.ws_col, 60, 120) : 100;
}

// Wraps words to lines of at most `width` characters; lines after the first begin with `indent` spaces.
std::string wrapped(const std::string& words, size_t column, size_t indent, size_t width) {
  std::string out;
  for (const std::string& word : CLI::detail::split(words, ' ')) {
    const bool first = out.empty();
    if (!first && column + 1 + word.size() > width) {
      out += "\n" + std::string(indent, ' ') + word;
      column = indent + word.size();
    } else {
      out += (first ? "" : " ") + word;
      column += word.size() + (first ? 0 : 1);
    }
  }
  return out;
}

std::string entry_text(const ManualPage::Entry& entry, size_t width) {
  std::string out = "  " + wrapped(entry.names, 2, 4, width);
  const size_t end = out.size();
  const bool beside = end + 2 <= kTextColumn && out.find('\n') == std::string::npos;
  if (entry.text.empty()) return out + "\n";
  out += beside ? std::string(kTextColumn - end, ' ') : "\n" + std::string(kTextColumn, ' ');
  return out + wrapped(entry.text, kTextColumn, kTextColumn, width) + "\n";
}

// Escapes text for a man page (groff), in which a backslash and a leading dot or quote are commands.
std::string roff(const std::string& words) {
  std::string out;
  bool begins = true;
  for (const char c : words) {
    if (begins && (c == '.' || c == '\'')) out += "\\&";
    if (c == '\\' || c == '-') out += '\\';
    out += c == '\\' ? 'e' : c;
    begins = c == '\n';
  }
  return out;
}

std::string man_text(const ManualPage& page) {
  std::string title = page.name;
  std::replace(title.begin(), title.end(), ' ', '-');
  std::string out = ".TH " + title + " 1 \"\" \"veridyn " VERIDYN_VERSION "\"\n.SH NAME\n" +
                    roff(title) + " \\- " + roff(page.summary) + "\n.SH SYNOPSIS\n" +
                    roff(page.usage) + "\n";
  for (const ManualPage::Section& section : page.sections) {
    out += ".SH \"" + roff(section.title) + "\"\n";
    for (const ManualPage::Entry& entry : section.entries)
      out += ".TP\n\\fB" + roff(entry.names) + "\\fR\n" + roff(entry.text) + "\n";
  }
  if (!page.notes.empty()) out += ".SH NOTES\n.nf\n" + roff(page.notes) + "\n.fi\n";
  if (!page.examples.empty()) out += ".SH EXAMPLES\n";
  for (const ManualPage::Entry& example : page.examples)
    out += ".TP\n" + roff(example.names) + "\n" + roff(example.text) + "\n";
  return out;
}

std::string table_cell(std::string words) {
  for (size_t at = 0; (at = words.find('|', at)) != std::string::npos; at += 2)
    words.insert(at, "\\");
  return words;
}

std::string markdown_text(const ManualPage& page) {
  std::string out = "\n## " + page.name + "\n\n" + page.summary + ".\n\n    " + page.usage + "\n";
  for (const ManualPage::Section& section : page.sections) {
    if (section.title == "Common") continue;
    out += "\n| " + section.title + " | |\n|---|---|\n";
    for (const ManualPage::Entry& entry : section.entries) {
      if (entry.names.rfind("-h,", 0) == 0) continue;
      out += "| `" + table_cell(entry.names) + "` | " + table_cell(entry.text) + " |\n";
    }
  }
  if (!page.notes.empty()) out += "\n```\n" + page.notes + "\n```\n";
  for (const ManualPage::Entry& example : page.examples)
    out += "\n    " + example.names + "\n\n" + example.text + ".\n";
  return out;
}

Json entries_json(const std::vector<ManualPage::Entry>& entries) {
  return json_each(entries, [&](const ManualPage::Entry& entry) -> Json { return {entry.names, entry.text}; });
}

std::vector<ManualPage::Entry> entries_of(const Json& entries) {
  std::vector<ManualPage::Entry> out;
  for (const Json& entry : entries) out.push_back({entry.at(0), entry.at(1)});
  return out;
}

class ManualFormatter : public CLI::FormatterBase {
 public:
  std::string make_help(const CLI::App* command, std::string name,
                        CLI::AppFormatMode) const override {
    return terminal_text(manual_page(*command, name));
  }
};

}  // namespace

ManualPage manual_page(const CLI::App& command, const std::string& name) {
  ManualPage out;
  out.name = name;
  out.summary = command.get_description();
  out.notes = command.get_footer();
  out.examples = examples_of(name);
  out.usage = name + " [OPTIONS]";
  std::vector<ManualPage::Section> groups;
  ManualPage::Section positionals{"Arguments", {}};
  std::string behind, required;
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_group().empty()) continue;
    const ManualPage::Entry entry{names_of(*option),
                                  option->get_description() + default_of(*option)};
    const std::string value = option->get_option_text();
    if (option->get_positional()) {
      const std::string word =
          value.find_first_not_of(' ') == std::string::npos ? option->get_name(true) : value;
      positionals.entries.push_back({word, entry.text});
      behind += option->get_required() ? " " + word : " [" + word + "]";
      continue;
    }
    if (option->get_required()) required += " " + names_of(*option);
    const auto group = std::find_if(groups.begin(), groups.end(),
                                    [&](const auto& g) { return g.title == option->get_group(); });
    if (group == groups.end())
      groups.push_back({option->get_group(), {entry}});
    else
      group->entries.push_back(entry);
  }
  out.usage += behind + required;
  if (!positionals.entries.empty()) out.sections.push_back(positionals);
  out.sections.insert(out.sections.end(), groups.begin(), groups.end());
  ManualPage::Section commands{"Commands", {}};
  for (const CLI::App* below : subcommands_of(command))
    commands.entries.push_back({below->get_name(), below->get_description()});
  if (!commands.entries.empty()) {
    out.usage += " COMMAND";
    out.sections.push_back(commands);
  }
  return out;
}

std::string terminal_text(const ManualPage& page) {
  const size_t width = terminal_width();
  std::string out =
      wrapped(page.summary, 0, 0, width) + "\nUsage: " + wrapped(page.usage, 7, 7, width) + "\n";
  for (const ManualPage::Section& section : page.sections) {
    out += "\n" + section.title + ":\n";
    for (const ManualPage::Entry& entry : section.entries) out += entry_text(entry, width);
  }
  if (!page.notes.empty()) out += "\n" + page.notes + "\n";
  if (!page.examples.empty()) out += "\nExamples:\n";
  for (const ManualPage::Entry& example : page.examples)
    out += "  " + example.names + "\n      " + wrapped(example.text, 6, 6, width) + "\n";
  return out;
}

void show_manual_as_help(CLI::App& tool) {
  tool.formatter(std::make_shared<ManualFormatter>());
  tool.option_defaults()->always_capture_default();
}

std::vector<CommandHelp> help_of(const CLI::App& tool) {
  std::vector<CommandHelp> out;
  for_each_command(tool, "veridyn", [&](const CLI::App& command, const std::string& name) {
    CommandHelp one{manual_page(command, name), {}, {}};
    const CLI::App& listed = command.get_name() == "help" ? tool : command;
    for (const CLI::App* below : subcommands_of(listed)) one.commands.push_back(below->get_name());
    for (const CLI::Option* option : command.get_options()) {
      for (const std::string& option_name : option->get_lnames()) one.options.push_back("--" + option_name);
    }
    out.push_back(std::move(one));
  });
  return out;
}

std::string to_json(const std::vector<CommandHelp>& help) {
  Json out = Json::array();
  for (const CommandHelp& one : help) {
    Json sections = Json::array();
    for (const ManualPage::Section& section : one.page.sections)
      sections.push_back({{"title", section.title}, {"entries", entries_json(section.entries)}});
    out.push_back({{"name", one.page.name}, {"summary", one.page.summary}, {"usage", one.page.usage},
                   {"sections", sections}, {"notes", one.page.notes}, {"examples", entries_json(one.page.examples)},
                   {"commands", one.commands}, {"options", one.options}});
  }
  return json_text(out);
}

std::vector<CommandHelp> help_from_json(const std::string& json, const std::string& program) {
  try {
    const Json all = Json::parse(json);
    std::vector<CommandHelp> out;
    for (std::size_t k = 1; k < all.size(); ++k) {
      const Json& one = all[k];
      CommandHelp help{{one.at("name"), one.at("summary"), one.at("usage"), {}, one.at("notes"), entries_of(one.at("examples"))},
                       one.at("commands"), one.at("options")};
      for (const Json& section : one.at("sections"))
        help.page.sections.push_back({section.at("title"), entries_of(section.at("entries"))});
      out.push_back(std::move(help));
    }
    return out;
  } catch (const Json::exception& error) {
    throw InvalidInput(program + " --describe: found no help of commands, expected that of a package of this version: " + error.what());
  }
}

void write_man_pages(const std::vector<CommandHelp>& help, const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  require(!error, folder, ": cannot be made: ", error.message(), ".");
  for (const CommandHelp& one : help) {
    std::string file = one.page.name;
    std::replace(file.begin(), file.end(), ' ', '-');
    write_file(folder + "/" + file + ".1", man_text(one.page));
  }
}

std::string markdown_manual(const std::vector<CommandHelp>& help) {
  std::string out =
      "# Commands\n\nEvery command with its options, as `veridyn help COMMAND` prints them. "
      "Default values stand in parentheses.\n"
      "Most commands take `--json FILE`, `--report FILE` (an HTML page), `--threads N`, `--quiet` "
      "and `--version`, which are left out here.\n";
  for (std::size_t k = 1; k < help.size(); ++k) out += markdown_text(help[k].page);
  return out;
}

std::string bash_completion(const std::vector<CommandHelp>& help) {
  std::string cases, with_commands;
  for (const CommandHelp& one : help) {
    const std::string& name = one.page.name;
    std::string words;
    for (const std::string& word : one.commands) words += word + " ";
    for (const std::string& word : one.options) words += word + " ";
    cases += "    '" + name + "') words='" + words + "' ;;\n";
    if (!one.commands.empty() && name != "veridyn" && name != "veridyn help")
      with_commands += (with_commands.empty() ? "" : " | ") + name.substr(name.rfind(' ') + 1);
  }
  return "# Completion of veridyn for bash: commands, options and file names.\n"
         "_veridyn() {\n"
         "  local command=veridyn words='' current=${COMP_WORDS[COMP_CWORD]}\n"
         "  ((COMP_CWORD > 1)) && command+=\" ${COMP_WORDS[1]}\"\n"
         "  case ${COMP_WORDS[1]} in\n"
         "    " +
         with_commands +
         ") ((COMP_CWORD > 2)) && command+=\" ${COMP_WORDS[2]}\" ;;\n"
         "  esac\n"
         "  case $command in\n" +
         cases +
         "  esac\n"
         "  mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$current\"; [[ $current == -* ]] "
         "|| compgen -f -- \"$current\")\n"
         "}\n"
         "complete -o filenames -F _veridyn veridyn\n";
}

}  // namespace veridyn::cli
