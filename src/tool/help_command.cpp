#include <algorithm>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "tool/manual.hpp"
#include "tool/packages.hpp"
#include "veridyn/tool/common_options.hpp"
#include "veridyn/tool/sound_arguments.hpp"
#include "files/output_file.hpp"
#include "model/suggestion.hpp"

namespace veridyn::cli {
namespace {

struct HelpRequest {
  std::vector<std::string> command;
  std::string man, markdown, bash;
};

const CLI::App& command_named(const CLI::App& tool, const std::vector<std::string>& words) {
  const CLI::App* command = &tool;
  for (const std::string& word : words) {
    std::vector<std::string> names;
    const CLI::App* next = nullptr;
    for (const CLI::App* below : command->get_subcommands([](const CLI::App*) { return true; })) {
      names.push_back(below->get_name());
      if (names.back() == word) next = below;
    }
    if (next == nullptr) {
      throw CLI::ValidationError("COMMAND", names.empty()
                                                ? "found '" + word + "', expected nothing after '" +
                                                      command->get_name() + "'"
                                                : "found '" + word + "', expected one of " +
                                                      listed(names) + did_you_mean(word, names));
    }
    command = next;
  }
  return *command;
}

// Help of all commands in the order of the list, including those of installed packages.
std::vector<CommandHelp> complete_help(const CLI::App& tool) {
  std::vector<CommandHelp> out;
  for (CommandHelp& own : help_of(tool)) {
    const std::vector<PackageCommand>& rows = package_commands();
    const auto row = std::find_if(rows.begin(), rows.end(), [&](const PackageCommand& one) { return "veridyn " + one.command == own.page.name; });
    const std::size_t before = out.size();
    if (row != rows.end()) {
      for (CommandHelp& theirs : help_of_program(row->program)) {
        if ((theirs.page.name + " ").rfind(own.page.name + " ", 0) == 0) out.push_back(std::move(theirs));
      }
    }
    const bool absent = row != rows.end() && !row->summary.empty();
    if (out.size() == before && !absent) out.push_back(std::move(own));
  }
  return out;
}

void run(const CLI::App& tool, const HelpRequest& request) {
  std::string name = "veridyn";
  for (const std::string& word : request.command) name += " " + word;
  const CLI::App& command = command_named(tool, request.command);
  if (request.man.empty() && request.markdown.empty() && request.bash.empty()) {
    std::cout << terminal_text(manual_page(command, name));
    return;
  }
  const std::vector<CommandHelp> help = complete_help(tool);
  if (!request.man.empty()) write_man_pages(help, request.man);
  if (!request.markdown.empty()) write_file(request.markdown, markdown_manual(help));
  if (!request.bash.empty()) write_file(request.bash, bash_completion(help));
}

}  // namespace

void add_help_command(CLI::App& tool) {
  const auto request = std::make_shared<HelpRequest>();
  CLI::App& command =
      *tool.add_subcommand("help", "Show the help of a command, or write all of it");
  add_value(command, "COMMAND COMMAND...", request->command, "Command, as identify or dvrk run");
  add_value(command, "--man FOLDER", request->man, "Write a man page for every command");
  add_output_option(command, "--markdown", request->markdown, "Write the help of all commands",
                    {".md"});
  add_output_option(command, "--bash", request->bash, "Write completion for bash");
  command.callback([request, &tool] { run(tool, *request); });
}

}  // namespace veridyn::cli
