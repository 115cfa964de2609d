#include <gtest/gtest.h>

#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "cli/tool.hpp"

// Commands of packages: their programs are looked for beside the tool, then on the path.

namespace veridyn {
namespace {

namespace fs = std::filesystem;

// A copy of the tool in a folder of its own, where no package stands beside it.
class LonelyTool {
 public:
  LonelyTool() { fs::copy_file(VERIDYN_TOOL, folder_.path("veridyn")); }

  /// @param path  the only folder of PATH.
  ToolRun run(const std::string& arguments, const std::string& path) const {
    const std::string out = folder_.path("out"), err = folder_.path("err");
    const int status = std::system(("PATH='" + path + "' '" + folder_.path("veridyn") + "' " + arguments + " >" + out + " 2>" + err).c_str());
    ToolRun run;
    run.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    run.out = content_of(out);
    run.err = content_of(err);
    return run;
  }

 private:
  TemporaryFolder folder_;
};

TEST(Packages, ACommandOfAMissingPackageIsRefusedNamingThePackage) {
  const LonelyTool tool;
  const struct {
    const char *arguments, *package;
  } calls[] = {{"calibrate axis markers.csv", "package calibration"}, {"cooperate scenario.yaml", "package cooperation"},
               {"stability scenario.yaml", "package cooperation"},    {"loadcell read udp:5000", "package cooperation"},
               {"dvrk monitor", "package dvrk"},                      {"help dvrk run", "package dvrk"},
               {"kinematics PSM1", "package dvrk"},                   {"export a.yaml --dvrk-gravity=b.json", "package dvrk"},
               {"excite planar-2r -o a.csv --for calibration", "package calibration"}};
  for (const auto& call : calls) {
    const ToolRun run = tool.run(call.arguments, "/nonexistent");
    EXPECT_EQ(run.status, 2) << call.arguments;
    EXPECT_EQ(run.error_lines(), 1) << run.err;
    EXPECT_NE(run.err.find(call.package), std::string::npos) << call.arguments << ": " << run.err;
    EXPECT_EQ(run.out, "") << call.arguments;
  }
}

TEST(Packages, CoreCommandsRunWithoutAnyPackage) {
  const LonelyTool tool;
  EXPECT_EQ(tool.run("info planar-2r", "/nonexistent").status, 0);
  EXPECT_EQ(tool.run("export --help", "/nonexistent").status, 0);
  const ToolRun all = tool.run("--help", "/nonexistent");
  EXPECT_EQ(all.status, 0);
  EXPECT_NE(all.out.find("calibrate"), std::string::npos) << all.out;
}

TEST(Packages, AProgramOnThePathRunsTheCommand) {
  const fs::path programs = fs::path(VERIDYN_TOOL).parent_path();
  if (!fs::exists(programs / "veridyn-calibrate")) GTEST_SKIP() << "the package calibration is not built";
  const LonelyTool tool;
  const ToolRun help = tool.run("calibrate rcm --help", programs.string());
  EXPECT_EQ(help.status, 0) << help.err;
  EXPECT_NE(help.out.find("veridyn calibrate rcm"), std::string::npos) << help.out;
}

// Arguments with blanks and the status of the program pass through; a program of another name is never started.
TEST(Packages, ArgumentsAndStatusPassThrough) {
  const TemporaryFolder folder;
  folder.write("veridyn-calibrate", "#!/bin/sh\nfor word; do echo \"[$word]\"; done\nexit 42\n");
  folder.write("veridyn-identify", "#!/bin/sh\nexit 43\n");
  for (const char* name : {"veridyn-calibrate", "veridyn-identify"})
    fs::permissions(folder.path(name), fs::perms::owner_all);
  const LonelyTool tool;
  const ToolRun run = tool.run("calibrate axis 'a b.csv' --json ''", folder.path(""));
  EXPECT_EQ(run.status, 42);
  EXPECT_EQ(run.out, "[--as]\n[calibrate]\n[axis]\n[a b.csv]\n[--json]\n[]\n");
  EXPECT_EQ(tool.run("identify", folder.path("")).status, 2);
}

}  // namespace
}  // namespace veridyn
