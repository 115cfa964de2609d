#include <gtest/gtest.h>

#include "cli/tool.hpp"

// Wrong usage ends with status 2 and one line that helps; help and version with 0.

namespace veridyn {
namespace {

using testing::Test;

void expect_usage_error(const Words& arguments, const std::string& words) {
  const ToolRun run = run_tool(arguments);
  EXPECT_EQ(run.status, 2) << run.err;
  EXPECT_EQ(run.error_lines(), 1) << run.err;
  EXPECT_EQ(run.out, "");
  EXPECT_EQ(run.err.rfind("veridyn: ", 0), 0u) << run.err;
  EXPECT_NE(run.err.find(words), std::string::npos) << run.err;
}

TEST(Usage, VersionIsOneLineOnStandardOutput) {
  for (const Words& words : {Words{"--version"}, Words{"identify", "--version"}}) {
    const ToolRun run = run_tool(words);
    EXPECT_EQ(run.status, 0);
    EXPECT_EQ(run.out, "veridyn 0.1.0\n");
    EXPECT_EQ(run.err, "");
  }
}

TEST(Usage, HelpNamesEveryCommandAndEveryOption) {
  const ToolRun tool = run_tool({"--help"});
  EXPECT_EQ(tool.status, 0);
  for (const char* word : {"info", "check", "identify", "export"}) {
    EXPECT_NE(tool.out.find(word), std::string::npos) << word;
  }
  const ToolRun identify = run_tool({"identify", "--help"});
  EXPECT_EQ(identify.status, 0);
  for (const char* word :
       {"--train",        "--test",      "--method",    "--weights",    "--condition",
        "--known-mass",   "--model-out", "--prior",     "--json",       "--filter-cutoff",
        "--filter-order", "--filtering", "--velocity",  "--resample",   "--rate",
        "--columns",      "--rows",      "--test-rows", "--drop-start", "--drop-end",
        "--decimation",   "--threads",   "--quiet",     "--version",    "--report"}) {
    EXPECT_NE(identify.out.find(word), std::string::npos) << word;
  }
}

TEST(Usage, NoCommandListsTheCommands) {
  expect_usage_error({}, "expected one of info, check, identify");
}

TEST(Usage, AMisspeltCommandIsCorrected) {
  expect_usage_error({"idenfity", "planar-2r"}, "unknown command 'idenfity'");
  expect_usage_error({"idenfity", "planar-2r"}, "did you mean 'identify'?");
}

TEST(Usage, AMisspeltOptionIsCorrected) {
  expect_usage_error({"identify", "planar-2r", "--trian", "a.csv"},
                     "unknown option '--trian' (did you mean '--train'?)");
  expect_usage_error({"identify", "planar-2r", "--train", "a.csv", "--filter-cutof=3"},
                     "unknown option '--filter-cutof' (did you mean '--filter-cutoff'?)");
}

TEST(Usage, MissingArgumentsAreNamed) {
  expect_usage_error({"identify", "planar-2r"}, "--train");
  expect_usage_error({"identify", "--train", "a.csv"}, "ROBOT");
  expect_usage_error({"check"}, "REC");
  expect_usage_error({"info"}, "ROBOT");
  expect_usage_error({"export", "planar-2r"}, "--urdf");
}

TEST(Usage, BadValuesAreNamedWithWhatIsExpected) {
  const Words identify = {"identify", "planar-2r", "--train", "a.csv"};
  expect_usage_error(identify + Words{"--method", "feasable"},
                     "expected one of ols, wls, feasible (did you mean 'feasible'?)");
  expect_usage_error(identify + Words{"--filtering", "both"}, "matched, signals");
  expect_usage_error(identify + Words{"--filter-cutoff", "five"}, "--filter-cutoff");
  expect_usage_error(identify + Words{"--filter-cutoff", "-1"}, "--filter-cutoff");
  expect_usage_error(identify + Words{"--filter-order", "0"}, "--filter-order");
  expect_usage_error(identify + Words{"--threads", "-2"}, "--threads");
  expect_usage_error(identify + Words{"--rows", "100"}, "expected rows A:B");
  expect_usage_error(identify + Words{"--rows", "100:20"}, "expected rows A:B");
  expect_usage_error(identify + Words{"--test-rows", "a:b"}, "--test-rows");
  expect_usage_error(identify + Words{"--columns", "q,velocity"}, "found 'velocity'");
  expect_usage_error(identify + Words{"--method", "wls", "--prior", "planar-2r"}, "--prior");
}

}  // namespace
}  // namespace veridyn
