#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <set>

#include "cli/tool.hpp"
#include "support/browser.hpp"
#include "veridyn/recordings/recording.hpp"

// The HTML pages of the tool, opened in a browser: nothing fails, every plot shows its samples, and
// every number is the one in the JSON.

namespace veridyn {
namespace {

using nlohmann::json;

constexpr double kMostBytes = 2e6;

// A small arm with one thing hidden in it, diagnosed and identified once for all tests.
class ReportPage : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    std::vector<std::string> recordings;
    for (const char* k : {"1", "2", "3"}) {
      const std::string motion = path(std::string("motion") + k + ".csv");
      recordings.push_back(path(std::string("recording") + k + ".csv"));
      // The held-out one is shorter.
      run({"excite", "psm-3dof", "-o", motion, "--frequency", std::string("0.1") + k, "--seed", k,
           "--duration", std::string(k) == "3" ? "20" : "30", "--evaluations", "40", "--quiet"});
      run({"simulate", "psm-3dof", "--trajectory", motion, "-o", recordings.back(), "--noise",
           "dvrk", "--seed", k, "--effect", "rotor_inertia:insertion", "--quiet"});
    }
    const Words inputs = {"psm-3dof", "--train",     recordings[0], recordings[1],
                          "--test",   recordings[2], "--quiet"};
    run(Words{"diagnose"} + inputs +
        Words{"--report", path("why.html"), "--json", path("why.json")});
    run(Words{"identify"} + inputs + Words{"--report", path("id.html"), "--json", path("id.json")});
  }

  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  void SetUp() override {
    ASSERT_TRUE(std::filesystem::exists(path("why.html")));
    ASSERT_TRUE(std::filesystem::exists(path("id.html")));
  }

  static void run(const Words& words) {
    const ToolRun done = run_tool(words);
    ASSERT_EQ(done.status, 0) << words.front() << ": " << done.err;
  }

  static std::string path(const std::string& name) { return folder_->path(name); }

  static TemporaryFolder* folder_;
};

TemporaryFolder* ReportPage::folder_ = nullptr;

class OpenedReport : public ReportPage, public testing::WithParamInterface<int> {
 protected:
  void SetUp() override {
    if (browser().empty()) GTEST_SKIP() << "no browser: chromium is not installed";
    ReportPage::SetUp();
  }

  // A page at this test's width, opened once for both.
  const OpenedPage& opened(const std::string& name, const std::string& script = "") const {
    std::vector<OpenedPage>& both = pages_[name + script];
    if (both.empty()) both = open_pages({{path(name), kWidths[0], script}, {path(name), kWidths[1], script}});
    return both[GetParam() == kWidths[0] ? 0 : 1];
  }

  static constexpr int kWidths[] = {1280, 400};
  static std::map<std::string, std::vector<OpenedPage>> pages_;
};

std::map<std::string, std::vector<OpenedPage>> OpenedReport::pages_;

INSTANTIATE_TEST_SUITE_P(Width, OpenedReport, testing::Values(1280, 400));

std::set<std::string> places(const std::vector<PageElement>& numbers) {
  std::set<std::string> out;
  for (const PageElement& n : numbers) out.insert(n.at("data-from"));
  return out;
}

// Places of all numbers below one in the result.
std::set<std::string> numbers_below(const json& result, const std::string& place) {
  std::set<std::string> out;
  const json flat = result.at(json::json_pointer(place)).flatten();
  for (const auto& [key, value] : flat.items()) {
    if (value.is_number()) out.insert(place + key);
  }
  return out;
}

void expect_shown(const std::set<std::string>& shown, const std::set<std::string>& wanted) {
  EXPECT_FALSE(wanted.empty());
  for (const std::string& place : wanted) EXPECT_EQ(shown.count(place), 1u) << place;
}

// Cells of numbers hold nothing but numbers that say where they come from.
void expect_cells_hold_marked_numbers(const OpenedPage& page) {
  for (const PageElement& cell : page.with("data-label")) {
    if (cell.at("class").find("number") == std::string::npos) continue;
    static const std::regex kMarked("<span class=\"n\".*?</span>");
    const std::string rest = std::regex_replace(cell.content, kMarked, "");
    EXPECT_FALSE(std::regex_search(rest, std::regex("\\d"))) << cell.content;
  }
}

// Samples on each plot over time, and against the motion, are those of the recording.
void expect_all_samples(const OpenedPage& page, std::size_t recording) {
  const json series = embedded(page.html, "series");
  const auto samples = static_cast<long>(series["recordings"][recording]["time"].size());
  EXPECT_GT(samples, 1000);
  // Forward and backward together; samples at rest have no direction.
  std::set<long> moving;
  for (const json& joint : series["recordings"][recording]["joints"]) {
    const std::vector<double> speed = column(joint["dq"]);
    moving.insert(std::count_if(speed.begin(), speed.end(), [](double dq) { return dq != 0.0; }));
  }
  for (const PageElement& plot : page.with("data-plot")) {
    const std::string kind = plot.at("data-plot");
    if (kind != "time" && kind != "error" && kind != "residual") continue;
    long all = 0;
    for (const auto& [curve, count] : counts(plot.at("data-points"))) {
      EXPECT_TRUE(kind == "residual" || count == samples) << kind << ", " << curve << ": " << count;
      all += count;
    }
    EXPECT_TRUE(kind != "residual" || moving.count(all) == 1) << all << " of " << samples;
  }
}

TEST_P(OpenedReport, ADiagnosisShowsTheNumbersOfItsJson) {
  const OpenedPage& page = opened("why.html");
  expect_faultless(page, GetParam());
  const json result = json_of(path("why.json"));
  EXPECT_EQ(embedded(page.html, "result"), result);
  ASSERT_FALSE(result["findings"].empty());
  const std::vector<PageElement> numbers = page.with("data-from");
  for (const PageElement& n : numbers) expect_number(n, result);
  const std::set<std::string> shown = places(numbers);
  for (const char* part : {"/baseline/train/relative_error", "/baseline/test/relative_error",
                           "/extended/train/relative_error", "/extended/test/relative_error",
                           "/noise_floor/relative_error"}) {
    expect_shown(shown, numbers_below(result, part));
  }
  for (std::size_t k = 0; k < result["not_supported"].size(); ++k) {
    expect_shown(shown, {"/not_supported/" + std::to_string(k) + "/p_value"});
  }
  for (std::size_t k = 0; k < result["findings"].size(); ++k) {
    const std::string finding = "/findings/" + std::to_string(k);
    expect_shown(shown, {finding + "/p_value", finding + "/explains"});
    expect_shown(shown, numbers_below(result, finding + "/parameters"));
  }
  expect_cells_hold_marked_numbers(page);
}

TEST_P(OpenedReport, ADiagnosisDrawsEverySampleOfThreeJoints) {
  const OpenedPage& page = opened("why.html");
  std::map<std::string, int> kinds;
  for (const PageElement& plot : page.with("data-plot")) ++kinds[plot.at("data-plot")];
  EXPECT_EQ(kinds["waterfall"], 3);
  EXPECT_EQ(kinds["time"], 3);
  EXPECT_EQ(kinds["error"], 3);
  EXPECT_EQ(kinds["residual"], 3 * 6);  // two models against three quantities of motion
  EXPECT_EQ(kinds["verdict"], 1);
  EXPECT_EQ(kinds["arm"], 1);
  EXPECT_GE(kinds["cause"], 1);
  expect_all_samples(page, 0);
}

TEST_P(OpenedReport, AnIdentificationShowsTheNumbersOfItsJson) {
  const OpenedPage& page = opened("id.html");
  expect_faultless(page, GetParam());
  const json result = json_of(path("id.json"));
  EXPECT_EQ(embedded(page.html, "result"), result);
  const std::vector<PageElement> numbers = page.with("data-from");
  for (const PageElement& n : numbers) expect_number(n, result);
  const std::set<std::string> shown = places(numbers);
  for (const char* part :
       {"/train/relative_error", "/test/relative_error", "/test/max_error",
        "/test/moving/relative_error", "/train/recordings/0/relative_error",
        "/train/recordings/1/relative_error", "/base_parameters", "/noise_floor/relative_error"}) {
    expect_shown(shown, numbers_below(result, part));
  }
  expect_cells_hold_marked_numbers(page);
  expect_all_samples(page, 0);
}

// A reader chooses another recording, which has another length, and zooms into one plot.
TEST_P(OpenedReport, TheChosenRecordingAndTimeRangeAreDrawn) {
  const std::string choose =
      "const select = page.document.querySelector('#chooser select');"
      "select.value = 1; select.dispatchEvent(new page.Event('change'));";
  const OpenedPage& other = opened("why.html", choose);
  expect_faultless(other, GetParam());
  expect_all_samples(other, 1);
  const OpenedPage& zoomed = opened("why.html", "page.showTime([5, 10]); page.noteState();");
  expect_faultless(zoomed, GetParam());
  const json time = embedded(zoomed.html, "series")["recordings"][0]["time"];
  long inside = 0;
  for (const json& t : time) inside += t >= 5.0 && t <= 10.0 ? 1 : 0;
  for (const PageElement& plot : zoomed.with("data-plot")) {
    if (plot.at("data-plot") != "time") continue;
    for (const auto& [curve, count] : counts(plot.at("data-points"))) {
      EXPECT_EQ(count, inside) << curve;
    }
  }
}

TEST_F(ReportPage, IsSelfContainedAndSmall) {
  for (const char* name : {"why.html", "id.html"}) {
    const std::string page = content_of(path(name));
    EXPECT_LT(static_cast<double>(page.size()), kMostBytes);
    EXPECT_NE(page.find("Content-Security-Policy"), std::string::npos);
    EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
    EXPECT_NE(page.find("@license"), std::string::npos) << "the plot library's licence line";
    EXPECT_EQ(page.find("sourceMappingURL"), std::string::npos);
    // The plot library's code may speak of such things; tags and styles may not.
    const std::string own = without_scripts(page);
    for (const char* word : {"<link", " src=", " href=\"http", "@import", "url(", "{{"}) {
      EXPECT_EQ(own.find(word), std::string::npos) << name << " holds " << word;
    }
  }
}

TEST_F(ReportPage, ShowsTheCommandOfTheRun) {
  const json series = embedded(content_of(path("why.html")), "series");
  const std::string command = series["command"];
  EXPECT_EQ(command.rfind("veridyn diagnose psm-3dof --train /", 0), 0u) << command;
  const json settings = embedded(content_of(path("why.html")), "result")["settings"];
  EXPECT_EQ(settings["train"].size(), 2u);
  EXPECT_EQ(settings["test"][0].get<std::string>(), path("recording3.csv"));
  EXPECT_EQ(settings["filter_cutoff"].get<double>(), 5.0);
}

TEST_F(ReportPage, TwoOutputsToOneFileAreRefused) {
  const ToolRun same = run_tool({"identify", "psm-3dof", "--train", path("recording1.csv"),
                                 "--report", path("x"), "--json", path("x")});
  EXPECT_EQ(same.status, 2);
  EXPECT_NE(same.err.find("--report: found the same file as for --json"), std::string::npos)
      << same.err;
}

}  // namespace
}  // namespace veridyn
