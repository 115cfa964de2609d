// A program of commands, as packages have them.
#include <veridyn/tool/program.hpp>

using namespace veridyn::cli;

int main() {
  char name[] = "veridyn-answer", argument[] = "--quiet";
  char* argv[] = {name, argument, nullptr};
  bool quiet = false;
  const auto answer = [&quiet](CLI::App& tool, Outcome& outcome) {
    CLI::App& command = *tool.add_subcommand("answer", "Answers");
    command.add_flag("--quiet", quiet, "Say nothing");
    command.callback([&outcome] { outcome.status = kDataCannotAnswer; });
  };
  return run_package({answer}, 2, argv) == kDataCannotAnswer && quiet ? 0 : 1;
}
