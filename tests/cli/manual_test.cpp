#include <gtest/gtest.h>

#include <cstdio>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "cli/tool.hpp"

// `veridyn help`: pages for a terminal, for man, for docs and for bash say the same, and the
// examples in them run.

namespace veridyn {
namespace {

const std::string kSource = VERIDYN_SOURCE_DIR;

Words words_of(const std::string& line) {
  std::istringstream in(line);
  Words out;
  for (std::string word; in >> word;) out.push_back(word);
  return out;
}

Words lines_of(const std::string& text) {
  std::istringstream in(text);
  Words out;
  for (std::string line; std::getline(in, line);) out.push_back(line);
  return out;
}

std::string markdown() {
  const TemporaryFolder folder;
  EXPECT_EQ(run_tool({"help", "--markdown", folder.path("commands.md")}).status, 0);
  return content_of(folder.path("commands.md"));
}

// Examples in the reference, by command in full.
std::vector<std::pair<std::string, std::string>> examples() {
  std::vector<std::pair<std::string, std::string>> out;
  std::string command;
  bool usage = false;
  for (const std::string& line : lines_of(markdown())) {
    if (line.rfind("## ", 0) == 0) {
      command = line.substr(3);
      usage = true;
    } else if (line.rfind("    veridyn ", 0) == 0) {
      if (!usage) out.emplace_back(command, line.substr(4));
      usage = false;
    }
  }
  return out;
}

TEST(Manual, EveryCommandHasExamplesWithOptionsThatItHas) {
  std::map<std::string, int> count;
  for (const auto& [command, line] : examples()) {
    ++count[command];
    EXPECT_EQ(line.rfind(command + " ", 0), 0u) << line;
    Words help = words_of(command);
    help.erase(help.begin());
    const std::string page = run_tool(help + Words{"--help"}).out;
    for (const std::string& word : words_of(line)) {
      if (word.rfind("-", 0) == 0 && word.size() > 1) {
        EXPECT_NE(page.find(word), std::string::npos) << command << " has no " << word;
      }
    }
  }
  for (const std::string& line : lines_of(run_tool({"help"}).out)) {
    std::smatch m;
    if (!std::regex_match(line, m, std::regex("  ([a-z]+) {2,}\\S.*"))) continue;
    const std::string name = "veridyn " + m[1].str();
    const bool parent =
        name == "veridyn dvrk" || name == "veridyn calibrate" || name == "veridyn loadcell";
    EXPECT_GE(count[name], parent ? 0 : 2) << name;
  }
}

TEST(Manual, ExamplesRunOneAfterTheOther) {
  // These need boards, a sensor, recordings of cameras, or half a minute.
  const std::set<std::string> elsewhere = {
      "veridyn calibrate axis",    "veridyn calibrate rcm",      "veridyn calibrate links",
      "veridyn calibrate handeye", "veridyn loadcell calibrate", "veridyn loadcell read",
      "veridyn dvrk emulate",      "veridyn dvrk monitor",       "veridyn dvrk read",
      "veridyn dvrk run",          "veridyn cooperate",          "veridyn stability"};
  const Words order = {"help",     "excite",  "simulate", "check",      "identify", "diagnose",
                       "friction", "payload", "compare",  "export",     "info",     "kinematics",
                       "watch",    "fleet",   "page",     "numbers",  "dvrk config"};
  const TemporaryFolder folder;
  folder.write("fleet.txt", "a one.csv\nb two.csv\nc loaded.csv\n");
  const auto all = examples();
  size_t run = 0;
  for (const std::string& name : order) {
    for (const auto& [command, line] : all) {
      if (command != "veridyn " + name) continue;
      Words words = words_of(line);
      words.erase(words.begin());
      const ToolRun result = run_tool(words, folder.path(""));
      EXPECT_EQ(result.status, 0) << line << "\n" << result.err;
      ++run;
    }
  }
  size_t known = 0;
  for (const auto& example : all) known += elsewhere.count(example.first) == 0;
  EXPECT_EQ(run, known);
}

TEST(Manual, UnknownCommandsAreRefused) {
  const std::vector<std::pair<Words, std::string>> wrong = {
      {{"help", "idenfity"}, "found 'idenfity', expected one of info, check"},
      {{"help", "dvrk", "walk"}, "found 'walk', expected one of emulate"},
      {{"help", "identify", "more"}, "expected nothing after 'identify'"},
      {{"help", "--man"}, "--man: found nothing, expected FOLDER"}};
  for (const auto& [words, message] : wrong) {
    const ToolRun run = run_tool(words);
    EXPECT_EQ(run.status, 2) << message;
    EXPECT_EQ(run.error_lines(), 1) << run.err;
    EXPECT_NE(run.err.find(message), std::string::npos) << run.err;
  }
  const ToolRun nowhere = run_tool({"help", "--man", "/dev/null/man"});
  EXPECT_EQ(nowhere.status, 3);
  EXPECT_EQ(nowhere.error_lines(), 1) << nowhere.err;
}

TEST(Manual, ManPagesRenderWithoutWarnings) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_tool({"help", "--man", folder.path("man")}).status, 0);
  const std::string page = content_of(folder.path("man") + "/veridyn-dvrk-run.1");
  EXPECT_EQ(page.rfind(".TH veridyn-dvrk-run 1", 0), 0u);
  EXPECT_NE(page.find("\\-\\-watchdog"), std::string::npos);
  for (const std::string& line : lines_of(page)) EXPECT_FALSE(line.rfind("'", 0) == 0) << line;
}

TEST(Manual, BashCompletesCommandsAndOptions) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_tool({"help", "--bash", folder.path("veridyn.bash")}).status, 0);
  const auto completed = [&folder](const std::string& typed, int at) {
    const std::string script = "source '" + folder.path("veridyn.bash") + "'; COMP_WORDS=(" +
                               typed + "); COMP_CWORD=" + std::to_string(at) +
                               "; _veridyn; echo \"${COMPREPLY[@]}\"";
    FILE* const pipe = ::popen(("cd '" + folder.path("") + "' && bash -c '" +
                                std::regex_replace(script, std::regex("'"), "'\\''") + "'")
                                   .c_str(),
                               "r");
    std::string out(4096, '\0');
    out.resize(std::fread(out.data(), 1, out.size(), pipe));
    EXPECT_EQ(::pclose(pipe), 0);
    return out;
  };
  EXPECT_EQ(completed("veridyn iden", 1), "identify\n");
  EXPECT_EQ(completed("veridyn identify --known", 2), "--known-mass\n");
  EXPECT_EQ(completed("veridyn dvrk emu", 2), "emulate\n");
  EXPECT_EQ(completed("veridyn dvrk run --largest", 3), "--largest-error\n");
  EXPECT_EQ(completed("veridyn help sim", 2), "simulate\n");
  EXPECT_EQ(completed("veridyn info veri", 2), "veridyn.bash\n");
}

TEST(Manual, HelpFitsTheTerminalAndShowsDefaults) {
  const std::string help = run_tool({"help", "excite"}).out;
  for (const std::string& line : lines_of(help)) {
    if (line.rfind("  veridyn ", 0) != 0) {
      EXPECT_LE(line.size(), 100u) << line;
    }
  }
  EXPECT_NE(run_tool({"help", "identify"}).out.find("(feasible)"), std::string::npos);
  EXPECT_NE(run_tool({"help", "payload"}).out.find("MODEL REC..."), std::string::npos);
}

// A number stands below its inequality and its reason, as in the header.
TEST(Numbers, OfEveryTableArePrintedBelowTheirInequality) {
  const std::string quality = run_tool({"numbers", "quality"}).out;
  EXPECT_EQ(quality.rfind("quality (src/", 0), 0U) << quality;
  EXPECT_NE(quality.find("  share of stale rows >= few_stale: reported; > many_stale: a warning; > frozen: a fault.\n"
                         "      few_stale = 0.001, many_stale = 0.02, frozen = 0.5;\n"),
            std::string::npos) << quality;
  EXPECT_EQ(quality.find("struct"), std::string::npos);
  const std::string all = run_tool({"numbers"}).out;
  for (const char* table : {"diagnose", "quality", "identify", "fleet", "compare", "watch", "search"})
    EXPECT_NE(("\n" + all).find(std::string("\n") + table + " (src/"), std::string::npos) << table;
}

}  // namespace
}  // namespace veridyn
