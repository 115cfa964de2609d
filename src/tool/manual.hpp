#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace veridyn::cli {

/// Help of one command. The terminal, the man pages and the reference of `make docs` show the same text.
struct ManualPage {
  struct Entry {
    std::string names;  ///< name with the value, such as `--rate HZ`
    std::string text;   ///< description and default value
  };
  struct Section {
    std::string title;
    std::vector<Entry> entries;
  };
  std::string name;     ///< full name, such as `veridyn dvrk run`
  std::string summary;  ///< summary in one line
  std::string usage;    ///< command line with its required options
  std::vector<Section> sections;
  std::string notes;            ///< preformatted lines after the options; may be empty
  std::vector<Entry> examples;  ///< names: a command line; text: its purpose
};

/// Help of a command.
/// @param name  full name of the command, such as `veridyn dvrk run`
ManualPage manual_page(const CLI::App& command, const std::string& name);

/// The page wrapped to the terminal's width, 100 columns where the output is not a terminal.
std::string terminal_text(const ManualPage& page);

/// Makes --help of a command and of its subcommands print manual pages.
/// Call it before subcommands are added: these inherit it.
void show_manual_as_help(CLI::App& tool);

/// The help of a command, with the words after it on a command line.
struct CommandHelp {
  ManualPage page;
  std::vector<std::string> commands, options;
};

/// Help of the tool and of all its commands, each before its subcommands.
std::vector<CommandHelp> help_of(const CLI::App& tool);

/// Help in the format that programs of packages print with --describe.
std::string to_json(const std::vector<CommandHelp>& help);
/// Parses to_json(), without the first entry, that of the tool. @param program  for messages.
std::vector<CommandHelp> help_from_json(const std::string& json, const std::string& program);

/// Writes a man page for the tool and for every command, as veridyn-dvrk-run.1.
/// @throws InvalidInput  the folder or a file cannot be written.
void write_man_pages(const std::vector<CommandHelp>& help, const std::string& folder);

/// All pages as Markdown: the reference of `make docs`.
std::string markdown_manual(const std::vector<CommandHelp>& help);

/// Script for bash that completes commands, options and file names.
std::string bash_completion(const std::vector<CommandHelp>& help);

/// Adds `help [COMMAND...]`, which prints a manual page or writes all of them.
void add_help_command(CLI::App& tool);

}  // namespace veridyn::cli
