#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "cli/tool.hpp"
#include "support/browser.hpp"

// Every page of the tool in a browser, wide and narrow, light and dark: nothing is said on the
// console, nothing sticks out, the main figure is drawn, the slider moves the arm, buttons work.

namespace veridyn {
namespace {

using nlohmann::json;

struct PageCase {
  const char* name;
  std::vector<const char*> figures;  ///< plots that it must have
};

std::ostream& operator<<(std::ostream& out, const PageCase& one) {
  return out << one.name;
}

class EveryPage : public testing::TestWithParam<PageCase> {
 protected:
  static void SetUpTestSuite() {
    if (browser().empty()) return;
    folder_ = new TemporaryFolder;
    const Words quick = {"--evaluations", "40", "--quiet"};
    for (const std::string k : {"1", "2"}) {
      run(Words{"excite", "psm-3dof", "-o", path("motion" + k + ".csv"), "--frequency", "0.1" + k,
                "--seed", k, "--duration", "20", "--report", path("excite.html")} + quick);
      run({"simulate", "psm-3dof", "--trajectory", path("motion" + k + ".csv"), "-o",
           path("rec" + k + ".csv"), "--noise", "dvrk", "--seed", k, "--effect",
           "position_dependent_friction:yaw", "--quiet"});
    }
    const Words inputs = {"--train", path("rec1.csv"), "--test", path("rec2.csv"), "--quiet"};
    run(Words{"identify", "psm-3dof", "--model-out", path("id.yaml"), "--report",
              path("identify.html")} + inputs);
    run(Words{"diagnose", "psm-3dof", "--model-out", path("ext.yaml"), "--report",
              path("diagnose.html")} + inputs);
    run({"simulate", path("ext.yaml"), "--replay", path("rec2.csv"), "-o", path("replay.csv"),
         "--report", path("replay.html"), "--quiet"});
    const std::string scenario =
        std::string(VERIDYN_SOURCE_DIR) + "/examples/cooperate/two-arms-spring.yaml";
    run({"cooperate", scenario, "--report", path("cooperate.html"), "--quiet"});
    run({"stability", scenario, "--map", "stiffness=500:50000:8,delay=0:0.02:6", "--report",
         path("stability.html"), "--quiet"});
    run({"kinematics", "PSM1", "--workspace", "100", "--report", path("kinematics.html"), "--quiet"});
    run({"info", "ur10e", "--report", path("info.html")});
    run({"check", "psm-3dof", path("rec1.csv"), path("rec2.csv"), "--report", path("check.html")});
    run({"compare", path("id.yaml"), path("ext.yaml"), "--report", path("compare.html")});
    run({"payload", path("ext.yaml"), "--recording", path("rec2.csv"), "--report",
         path("payload.html"), "--quiet"});
    run({"watch", path("ext.yaml"), path("rec2.csv"), "--report", path("watch.html"), "--quiet"});
    run({"friction", "psm-3dof", path("rec1.csv"), path("rec2.csv"), "--report", path("friction.html"), "--quiet"});
    run({"page", path(""), "-o", path("index.html")});
  }

  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  void SetUp() override {
    if (browser().empty()) GTEST_SKIP() << "no browser: chromium is not installed";
  }

  static void run(const Words& words) {
    const ToolRun done = run_tool(words);
    ASSERT_EQ(done.status, 0) << words.front() << ": " << done.err;
  }

  static std::string path(const std::string& name) { return folder_->path(name); }

  std::string page() const { return path(std::string(GetParam().name) + ".html"); }

  // The page as all tests look at it, opened once; kUsed: its slider is moved, and its buttons are pressed.
  enum View { kWide, kNarrow, kUsed, kWideDark, kNarrowDark };
  const OpenedPage& opened(View view) const {
    std::vector<OpenedPage>& views = views_[GetParam().name];
    if (views.empty()) {
      views = open_pages({{page(), kWidest}, {page(), kNarrowest}, {page(), 1000, kUse}});
      for (OpenedPage& dark : open_pages({{page(), kWidest}, {page(), kNarrowest}}, Scheme::kDark)) views.push_back(std::move(dark));
    }
    return views[view];
  }

  static constexpr int kWidest = 1400, kNarrowest = 400;
  static const char* const kUse;
  static TemporaryFolder* folder_;
  static std::map<std::string, std::vector<OpenedPage>> views_;
};

TemporaryFolder* EveryPage::folder_ = nullptr;
std::map<std::string, std::vector<OpenedPage>> EveryPage::views_;

const char* const EveryPage::kUse = R"(
    const data = page.document.documentElement.dataset;
    const arm = page.document.querySelector('[data-plot=arm] svg');
    if (arm) {
      const drawn = () => [...arm.querySelectorAll('line, path, polygon')].map((shape) => {
        const box = shape.getBoundingClientRect();
        return [box.left, box.top, box.right, box.bottom];
      });
      const before = drawn();
      const slider = page.document.querySelector('.scrubber');
      slider.value = 0.37 * slider.max;
      slider.dispatchEvent(new page.Event('input'));
      data.moved = Math.round(Math.max(...drawn().map(
          (box, k) => Math.max(...box.map((edge, e) => Math.abs(edge - (before[k] || box)[e]))))));
    }
    page.HTMLAnchorElement.prototype.click = () => 0;
    const saved = [];
    for (const button of page.document.querySelectorAll('.tools button')) {
      if (button.textContent !== 'SVG' && button.textContent !== 'CSV') continue;
      data.saved = '';
      button.click();
      saved.push(data.saved.split(' ').pop() > 60 ? 1 : 0);
    }
    for (const button of page.document.querySelectorAll('.all-rows')) button.click();
    data.saves = saved.length;
    data.good = saved.reduce((a, b) => a + b, 0);
    data.folded = [...page.document.querySelectorAll('tr.more')].filter((row) => row.getBoundingClientRect().height === 0).length;
)";

INSTANTIATE_TEST_SUITE_P(
    Of, EveryPage,
    testing::Values(PageCase{"identify", {"verdict", "torque", "friction", "intervals", "time"}},
                    PageCase{"diagnose", {"verdict", "cause", "friction", "arm", "waterfall", "time"}},
                    PageCase{"excite", {"used", "arm", "error"}},
                    PageCase{"replay", {"verdict", "arm", "time", "error"}},
                    PageCase{"cooperate", {"verdict", "arm", "time"}},
                    PageCase{"stability", {"plane", "map", "steps"}},
                    PageCase{"kinematics", {"condition", "arm"}}, PageCase{"info", {"arm"}},
                    PageCase{"check", {}}, PageCase{"compare", {"differences"}},
                    PageCase{"friction", {"friction"}},
                    PageCase{"payload", {"verdict"}}, PageCase{"watch", {"time", "arm"}},
                    PageCase{"index", {"history"}}),
    [](const testing::TestParamInfo<PageCase>& test) { return std::string(test.param.name); });

std::map<std::string, int> kinds_of(const OpenedPage& page) {
  std::map<std::string, int> kinds;
  for (const PageElement& plot : page.with("data-plot")) ++kinds[plot.at("data-plot")];
  return kinds;
}

PageElement arm_of(const OpenedPage& page) {
  for (const PageElement& plot : page.with("data-plot"))
    if (plot.at("data-plot") == "arm") return plot;
  return {};
}

TEST_P(EveryPage, RendersWithoutErrorsInEveryWidthAndColourScheme) {
  for (const View view : {kWide, kNarrow, kWideDark, kNarrowDark}) {
    const OpenedPage& opened = this->opened(view);
    const bool dark = view == kWideDark || view == kNarrowDark;
    const int width = view == kWide || view == kWideDark ? kWidest : kNarrowest;
    EXPECT_EQ(opened.root().at("data-scheme"), dark ? "dark" : "light");
    EXPECT_EQ(opened.root().at("data-errors"), "0");
    EXPECT_EQ(opened.root().at("data-overflow"), "0") << opened.root().at("data-overflow-by");
    EXPECT_EQ(opened.console, "");
    EXPECT_GE(std::stoi(opened.root().at("data-words")), 75);  // of 11.5 pixels
    if (!GetParam().figures.empty()) expect_faultless(opened, width);
    std::map<std::string, int> kinds = kinds_of(opened);
    for (const char* figure : GetParam().figures) EXPECT_GE(kinds[figure], 1) << figure;
    const std::string text = without_scripts(opened.html);
    for (const char* word : {"NaN", "undefined", "[object"})
      EXPECT_EQ(text.find(word), std::string::npos)
          << word << ": " << text.substr(text.find(word) - 120, 200);
    const json result = embedded(opened.html, "result");
    for (const PageElement& n : opened.with("data-from"))
      if (n.at("data-from") != "/frequency") expect_number(n, result);  // shown as a period
    // What it is, whether it is good, and what comes next stand first.
    EXPECT_NE(text.find("class=\"lead"), std::string::npos);
    EXPECT_LT(text.find("id=\"verdict\""), text.find("id=\"run\""));
  }
  EXPECT_LT(content_of(page()).size(), 2000000u);
}

TEST_P(EveryPage, ButtonsSaveFiguresAndUnfoldTables) {
  const OpenedPage& opened = this->opened(kUsed);
  const PageElement root = opened.root();
  EXPECT_EQ(root.at("data-errors"), "0");
  EXPECT_EQ(root.at("data-saves"), root.at("data-good"));
  EXPECT_EQ(root.at("data-folded"), "0");
  if (!GetParam().figures.empty()) {
    EXPECT_NE(root.at("data-saves"), "0");
  }
}

TEST_P(EveryPage, TheTimeSliderMovesTheDrawnArmAndTheTimeMark) {
  const OpenedPage& still = opened(kWide);
  if (arm_of(still).tag.empty()) GTEST_SKIP() << "a page without an arm";
  const OpenedPage& moved = opened(kUsed);
  EXPECT_GT(std::stod(moved.root().at("data-moved")), 3.0) << "pixels on the screen";
  EXPECT_EQ(moved.root().at("data-errors"), "0");
  EXPECT_FALSE(arm_of(still).at("data-pose").empty());
  EXPECT_NE(arm_of(still).at("data-pose"), arm_of(moved).at("data-pose"));
  EXPECT_NE(arm_of(still).at("data-moment"), arm_of(moved).at("data-moment"));
  if (kinds_of(moved)["error"] > 0) {
    const std::string text = without_scripts(moved.html);
    EXPECT_NE(text.find("class=\"moment\" style=\"left:"), std::string::npos);
  }
}

// ---- a folder

TEST(ProjectPage, ListsModelsInOrderWithTheirChanges) {
  const TemporaryFolder folder;
  const std::string recording = folder.write("a.csv", planar_recording(20.0));
  for (const char* name : {"one.yaml", "two.yaml"})
    ASSERT_EQ(run_tool({"identify", "planar-2r", "--train", recording, "--model-out",
                        folder.path(name), "--quiet"})
                  .status,
              0);
  folder.write("odd.json", R"({"veridyn": "0", "command": "check", "joints": [{"significant": 2, "severity": 3, "sentence": "odd"}]})");
  const ToolRun made = run_tool({"page", folder.path(""), "--json", folder.path("index.json")});
  ASSERT_EQ(made.status, 0) << made.err;
  const json result = embedded(content_of(folder.path("index.html")), "result");
  EXPECT_EQ(json_of(folder.path("index.json")), result);
  ASSERT_EQ(result["pages"].size(), 1u);
  EXPECT_EQ(result["pages"][0]["sentences"][0], "odd");
  ASSERT_EQ(result["models"].size(), 2u);
  EXPECT_EQ(result["models"][0]["inputs"].back(), "a.csv");  // behind the robot file
  EXPECT_EQ(result["recordings"].size(), 1u);
  ASSERT_EQ(result["changes"].size(), 1u);
  EXPECT_NE(result["changes"][0]["verdict"], "differ");  // the same recording twice
}

TEST(ProjectPage, AFolderWithoutResultsIsRefused) {
  const TemporaryFolder folder;
  EXPECT_EQ(run_tool({"page", folder.path("")}).status, 3);
  EXPECT_EQ(run_tool({"page", folder.path("nowhere")}).status, 3);
  EXPECT_TRUE(folder.files().empty());
}

// ---- a page that is served

// What a server on this machine answers within a few seconds, or until it has said `enough`.
std::string answer_of(int port, const std::string& place, const std::string& enough) {
  const int line = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in where{};
  where.sin_family = AF_INET;
  where.sin_port = htons(static_cast<std::uint16_t>(port));
  where.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::string out;
  if (::connect(line, reinterpret_cast<sockaddr*>(&where), sizeof where) == 0) {
    const timeval patience{5, 0};
    ::setsockopt(line, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    const std::string words = "GET " + place + " HTTP/1.1\r\nHost: here\r\nConnection: close\r\n\r\n";
    if (::send(line, words.data(), words.size(), 0) > 0) {
      char part[4096];
      for (long n = 1; n > 0 && out.find(enough) == std::string::npos;) {
        n = ::recv(line, part, sizeof part, 0);
        if (n > 0) out.append(part, static_cast<std::size_t>(n));
      }
    }
  }
  ::close(line);
  return out;
}

int free_port() {
  const int line = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in where{};
  where.sin_family = AF_INET;
  where.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof where;
  EXPECT_EQ(::bind(line, reinterpret_cast<sockaddr*>(&where), size), 0);
  EXPECT_EQ(::getsockname(line, reinterpret_cast<sockaddr*>(&where), &size), 0);
  ::close(line);
  return ntohs(where.sin_port);
}

TEST(ServedPage, AConnectedBrowserReceivesThePageAndUpdateEvents) {
  const TemporaryFolder folder;
  const std::string recording = folder.write("a.csv", planar_recording(30.0));
  ASSERT_EQ(run_tool({"identify", "planar-2r", "--train", recording, "--model-out",
                      folder.path("m.yaml"), "--quiet"})
                .status,
            0);
  const int port = free_port();
  ToolRun watched;
  std::thread running([&] {
    watched = run_tool({"watch", folder.path("m.yaml"), recording, "--follow", "--idle", "9",
                        "--learn", "5", "--serve", std::to_string(port)});
  });
  std::string page;
  for (int k = 0; k < 40 && page.find("\"running\": true") == std::string::npos; ++k) {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    page = answer_of(port, "/", "</html>");
  }
  const std::string events = answer_of(port, "/events", "data: new");
  running.join();
  if (watched.err.find("without cpp-httplib") != std::string::npos) GTEST_SKIP() << watched.err;
  EXPECT_NE(page.find("\"command\": \"watch\""), std::string::npos) << watched.err;
  EXPECT_NE(page.find("\"running\": true"), std::string::npos);
  EXPECT_NE(events.find("text/event-stream"), std::string::npos) << events;
  EXPECT_NE(events.find("data: new"), std::string::npos) << events;
  EXPECT_NE(watched.err.find("http://127.0.0.1:" + std::to_string(port)), std::string::npos);
}

}  // namespace
}  // namespace veridyn
