#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace veridyn::cli {

/// Help of one command. The terminal, the man pages and docs/commands.md show the same text.
struct ManualPage {
  struct Entry {
    std::string names;  ///< with the value, as `--rate HZ`
    std::string text;   ///< description and default value
  };
  struct Section {
    std::string title;
    std::vector<Entry> entries;
  };
  std::string name;     ///< in full, as `veridyn dvrk run`
  std::string summary;  ///< one line
  std::string usage;    ///< command line with its required options
  std::vector<Section> sections;
  std::string notes;            ///< preformatted lines after the options; may be empty
  std::vector<Entry> examples;  ///< names: a command line; text: its purpose
};

/// Help of a command.
/// @param name  the command in full, as `veridyn dvrk run`
ManualPage manual_page(const CLI::App& command, const std::string& name);

/// Shows the help of a command and of its subcommands as manual pages, wrapped to the terminal's
/// width (100 columns where the output is not a terminal), with the default value of every option.
/// Call it before subcommands are added: these inherit it.
void show_manual_as_help(CLI::App& tool);

/// Writes what `veridyn help` offers beside the help of a command:
/// `--man FOLDER` (a man page for every command), `--markdown FILE`, `--bash FILE` (completion).
/// @returns false if `words` ask for none of these.
/// Throws InvalidInput if a file cannot be written.
bool write_manual(const CLI::App& tool, const std::vector<std::string>& words);

}  // namespace veridyn::cli
