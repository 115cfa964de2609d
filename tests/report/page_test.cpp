#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include "report/pages/page_files.hpp"
#include "support/browser.hpp"
#include "veridyn/regressor/standard_parameters.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/report/diagnosis_json.hpp"
#include "veridyn/report/pages.hpp"
#include "veridyn/report/robot_info.hpp"

// Pages of results that are out of the ordinary.

namespace veridyn {
namespace {

using nlohmann::json;

constexpr double kStep = 0.01;  // [s]

double measured_at(double t) {
  return 10.0 + std::sin(3.0 * t);
}

double modelled_at(double t) {
  return 10.0 + 0.9 * std::sin(3.0 * t + 0.1);
}

// A recording of planar-2r; where the predicate holds, there are no samples.
RecordingError recording(const std::string& source, int samples, bool (*in_gap)(double)) {
  RecordingError out;
  out.source = source;
  out.error.relative = out.error.maximum = out.error.moving_relative = VectorXd::Constant(2, 0.1);
  PredictionSeries& s = out.series;
  for (auto* table : {&s.q, &s.dq, &s.ddq, &s.measured, &s.modelled}) table->resize(2);
  for (int k = 0; k < samples; ++k) {
    const double t = kStep * k;
    if (in_gap(t)) continue;
    s.time.push_back(t);
    for (std::size_t i = 0; i < 2; ++i) {
      const double phase = 10.0 * t + 1.0 * static_cast<double>(i);
      s.q[i].push_back(std::sin(phase));
      s.dq[i].push_back(10.0 * std::cos(phase));
      s.ddq[i].push_back(-100.0 * std::sin(phase));
      s.measured[i].push_back(measured_at(t));
      s.modelled[i].push_back(modelled_at(t));
    }
  }
  return out;
}

bool nowhere(double) {
  return false;
}

Identification identification(const std::vector<RecordingError>& test) {
  Identification id;
  id.status = IdentificationStatus::kDone;
  id.robot = "planar-2r";
  id.model = read_model("planar-2r");
  id.train = {recording("train.csv", 800, nowhere)};
  id.test = test;
  id.train_error = id.test_error = id.train[0].error;
  const auto count = static_cast<Eigen::Index>(standard_parameters(*id.model).size());
  id.parameters = id.parameter_deviations = VectorXd::Ones(count);
  id.base = {{"m", "m_upper - 2 m_fore", "kg", 1.25, 0.031}};
  return id;
}

// A change of the second joint's model that a finding brought about.
Diagnosis diagnosis() {
  Diagnosis d;
  d.baseline = identification({recording("test.csv", 900, nowhere)});
  d.extended = d.baseline;
  for (double& tau : d.extended.test[0].series.modelled[1]) tau += 0.01;
  Finding f;
  f.rank = 1;
  f.cause = NewEffect{"joint_spring", {1}};
  f.joint = JointIndex{1};
  f.parameters = {{"stiffness", "N m/rad", 0.5, 0.4, 0.6}};
  f.p_value = 1e-9;
  f.test_before = VectorXd::Constant(2, 0.2);
  f.test_after = VectorXd::Constant(2, 0.1);
  f.phrase = "a spring of 0.5 N m/rad";
  d.findings = {f};
  return d;
}

json series_of(const std::string& page) {
  return embedded(page, "series");
}

// Opens a page that is not written by the tool.
class OpenedInMemory : public testing::Test {
 protected:
  void SetUp() override {
    if (browser().empty()) GTEST_SKIP() << "no browser: chromium is not installed";
  }

  static OpenedPage open(const std::string& page, const std::string& script = "") {
    const std::filesystem::path path =
        std::filesystem::temp_directory_path() /
        (std::string("veridyn-page-") +
         testing::UnitTest::GetInstance()->current_test_info()->name() + ".html");
    std::ofstream(path) << page;
    const OpenedPage opened = open_page(path.string(), 800, script);
    std::filesystem::remove(path);
    return opened;
  }
};

TEST_F(OpenedInMemory, PlottedLinesAreInterruptedAtGaps) {
  const auto gaps = [](double t) { return (t > 2.0 && t < 3.0) || (t > 5.0 && t < 5.5); };
  const OpenedPage page = open(to_page(identification({recording("gaps.csv", 800, gaps)})));
  expect_faultless(page, 800);
  int plots = 0;
  for (const PageElement& plot : page.with("data-gaps")) {
    EXPECT_EQ(plot.at("data-gaps"), "2");
    ++plots;
  }
  EXPECT_EQ(plots, 4);
}

TEST_F(OpenedInMemory, RecordingsOfAnyLengthWithMissingValuesAreDrawn) {
  RecordingError odd = recording("odd.csv", 40, nowhere);
  odd.series.modelled[0][7] = std::nan("");
  Identification id = identification({odd, recording("long.csv", 9000, nowhere)});
  id.base[0].std = std::nan("");
  id.rank_gap = INFINITY;
  const OpenedPage page = open(to_page(id));
  expect_faultless(page, 800);
  for (const PageElement& n : page.with("data-from"))
    expect_number(n, embedded(page.html, "result"));
  for (const PageElement& plot : page.with("data-plot")) {
    if (plot.at("data-plot") != "time") continue;
    const bool first = plot.at("data-joint") == "1";
    EXPECT_EQ(counts(plot.at("data-points"))["measured"], 40);
    EXPECT_EQ(counts(plot.at("data-points"))["identified model"], first ? 39 : 40);
  }
}

// As built where the plot library is not installed.
TEST_F(OpenedInMemory, WithoutThePlotLibraryCurvesAreStillDrawn) {
  std::string page = to_page(identification({recording("test.csv", 800, nowhere)}));
  const std::string library(page_file("dygraph.js"));
  if (library.empty()) GTEST_SKIP() << "built without it: every page is tested so";
  const auto at = page.find(library);
  ASSERT_NE(at, std::string::npos);
  page.erase(at, library.size());
  const OpenedPage opened = open(page);
  EXPECT_EQ(opened.root().at("data-errors"), "0") << opened.console;
  EXPECT_EQ(opened.console, "");
  int drawn = 0;
  for (const PageElement& plot : opened.with("data-plot")) {
    if (plot.at("data-plot") != "time") continue;
    ++drawn;
    EXPECT_EQ(counts(plot.at("data-points"))["measured"], 800);
  }
  EXPECT_EQ(drawn, 2);
}

TEST_F(OpenedInMemory, TheLeastCertainParametersShowTheirCorrelation) {
  Identification id = identification({recording("test.csv", 800, nowhere)});
  ModelDescription d = id.model->description();
  d.identified.emplace();
  d.identified->clusters = 3;
  const auto parameter = [](const char* name, double value, double first, double second) {
    IdentifiedParameter out;
    out.name = name;
    out.unit = "kg";
    out.value = value;
    out.scatter = Eigen::Vector2d(first, second);
    return out;
  };
  d.identified->parameters = {parameter("sure", 100.0, 0.0, 1.0), parameter("half", 1.0, 0.5, 0.0), parameter("vague", 1.0, 0.6, -0.8)};
  id.model = Model(std::move(d));
  const OpenedPage page = open(to_page(id));
  EXPECT_EQ(page.root().at("data-errors"), "0") << page.console;
  const json list = embedded(page.html, "series")["correlations"];
  EXPECT_EQ(list["names"], (json{"vague", "half", "sure"}));  // the least certain first
  EXPECT_EQ(list["matrix"], (json{{1.0, 0.6, -0.8}, {0.6, 1.0, 0.0}, {-0.8, 0.0, 1.0}}));
  int drawn = 0;
  for (const PageElement& plot : page.with("data-plot")) {
    if (plot.at("data-plot") != "correlations") continue;
    ++drawn;
    EXPECT_EQ(plot.at("data-points"), "cells:9");
  }
  EXPECT_EQ(drawn, 1);
  EXPECT_NE(page.html.find("Strongest: vague and sure"), std::string::npos);
}

// Shapes of a URDF in place of rods; a mesh that is too fine is thinned.
TEST_F(OpenedInMemory, LinksHaveTheShapesOfTheirUrdf) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("veridyn-shapes-" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  std::string fine = "solid fine\n";
  constexpr int kAround = 200, kAlong = 60;
  const auto vertex = [&](int i, int k) {
    const double angle = 2.0 * M_PI * i / kAround;
    fine += "vertex " + std::to_string(0.05 * std::cos(angle)) + " " + std::to_string(0.05 * std::sin(angle)) + " " + std::to_string(0.01 * k) + "\n";
  };
  for (int i = 0; i < kAround; ++i) {
    for (int k = 0; k < kAlong; ++k) {
      vertex(i, k), vertex(i + 1, k), vertex(i + 1, k + 1);
      vertex(i, k), vertex(i + 1, k + 1), vertex(i, k + 1);
    }
  }
  std::ofstream(folder / "fine.stl") << fine;
  std::ofstream(folder / "arm.urdf")
      << R"(<robot name="arm"><link name="base"><visual><geometry><cylinder radius="0.1" length="0.2"/></geometry></visual></link>
<link name="upper"><visual><geometry><mesh filename="fine.stl"/></geometry><material name="red"><color rgba="1 0 0 1"/></material></visual></link>
<joint name="lift" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" velocity="1" effort="9"/></joint></robot>)";
  const Model arm = read_model((folder / "arm.urdf").string());
  const std::string with = to_page(robot_info(arm));
  std::filesystem::remove_all(folder);
  const std::string without = to_page(robot_info(arm));  // the file is gone: rods
  const json meshes = embedded(with, "series")["arms"][0]["meshes"];
  ASSERT_EQ(meshes.size(), 2u);
  EXPECT_EQ(meshes[1]["colour"], "#ff0000");
  EXPECT_LT(with.size(), without.size() + 150000);
  EXPECT_EQ(embedded(without, "series")["arms"][0]["meshes"].size(), 0u);
  const OpenedPage page = open(with);
  EXPECT_EQ(page.root().at("data-errors"), "0") << page.console;
  EXPECT_EQ(page.console, "");
  EXPECT_NE(page.html.find("fill=\"#ff0000\""), std::string::npos);
}

// Triangles without common corners cannot be thinned: their bounding box is drawn, where they are.
TEST_F(OpenedInMemory, AMeshThatCannotBeThinnedIsItsBoundingBox) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("veridyn-soup-" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  std::string soup = "solid soup\n";
  std::mt19937 random(1);
  for (int k = 0; k < 30000; ++k)
    soup += "vertex " + std::to_string(5.0 + random() % 1000 / 1000.0) + " " +
            std::to_string(random() % 1000 / 1000.0) + " " + std::to_string(random() % 1000 / 1000.0) + "\n";
  std::ofstream(folder / "soup.stl") << soup;
  std::ofstream(folder / "arm.urdf")
      << R"(<robot name="arm"><link name="base"/>
<link name="upper"><visual><geometry><mesh filename="soup.stl"/></geometry></visual></link>
<joint name="lift" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" velocity="1" effort="9"/></joint></robot>)";
  const json meshes = embedded(to_page(robot_info(read_model((folder / "arm.urdf").string()))), "series")["arms"][0]["meshes"];
  std::filesystem::remove_all(folder);
  ASSERT_EQ(meshes.size(), 1u);
  const std::vector<double> x = column(meshes[0]["x"]);
  ASSERT_EQ(x.size(), 8u);
  EXPECT_NEAR(*std::min_element(x.begin(), x.end()), 5.0, 0.01);
  EXPECT_NEAR(*std::max_element(x.begin(), x.end()), 6.0, 0.01);
}

TEST_F(OpenedInMemory, AJointAtRestIsPlottedWithoutErrors) {
  Identification id = identification({});
  for (auto* table : {&id.train[0].series.q, &id.train[0].series.dq, &id.train[0].series.ddq}) {
    for (double& v : (*table)[1]) v = 0.0;
  }
  for (double& tau : id.train[0].series.measured[1]) tau = 0.5;
  for (double& tau : id.train[0].series.modelled[1]) tau = 0.5;
  const OpenedPage page = open(to_page(id));
  EXPECT_EQ(page.root().at("data-errors"), "0") << page.console;
  EXPECT_EQ(page.console, "");
  std::map<std::string, int> kinds;
  for (const PageElement& plot : page.with("data-plot")) ++kinds[plot.at("data-plot")];
  EXPECT_EQ(kinds["time"], 2);
  EXPECT_EQ(kinds["error"], 2);
  EXPECT_EQ(kinds["residual"], 6);
}

// Names of files and words of findings come from outside.
TEST_F(OpenedInMemory, MarkupInTheResultIsEscaped) {
  Diagnosis d = diagnosis();
  const std::string name = "</script><b data-planted=\"1\">&amp; \\ \xff \u00e9.csv";
  d.baseline.test[0].source = name;
  d.findings[0].phrase = "<b data-planted=\"1\">bold</b> {{result}}";
  d.findings[0].rivals = {{AddedLoad{{0}}, "<i data-planted=\"1\">"}};
  const OpenedPage page = open(to_page(d, "veridyn 'a</script>b'"));
  expect_faultless(page, 800);
  EXPECT_TRUE(page.with("data-planted").empty());
  EXPECT_EQ(embedded(page.html, "series")["command"].get<std::string>(), "veridyn 'a</script>b'");
  EXPECT_EQ(embedded(page.html, "result")["findings"][0]["sentence"].get<std::string>(),
            "Joint 2 (elbow): " + d.findings[0].phrase + ".");
}

// Parts of the result that most diagnoses do not have.
TEST_F(OpenedInMemory, ChangesAndExcludedRowsAreShown) {
  std::string page = to_page(diagnosis());
  const std::string before = "\"seconds\": ";
  const std::string added =
      R"("changes_since": true,
         "next_experiment": {"separates": ["payload on fore", "torque_gain on joint 2"],
                             "trajectory": "veridyn excite planar-2r"},
         "excluded_intervals": [{"file": "test.csv", "joint": 1, "from": 2.5, "to": 3.25, "why": "a contact"}],
         )";
  page.insert(page.rfind(before), added);
  const OpenedPage opened = open(page);
  expect_faultless(opened, 800);
  EXPECT_NE(opened.html.find("Since the model was made"), std::string::npos);
  EXPECT_NE(opened.html.find("payload on fore from torque gain on joint 2"), std::string::npos);
  EXPECT_NE(opened.html.find("<code>veridyn excite planar-2r</code>"), std::string::npos);
  const json result = embedded(opened.html, "result");
  int ends = 0;
  for (const PageElement& n : opened.with("data-from")) {
    expect_number(n, result);
    if (n.at("data-from").rfind("/excluded_intervals/0/", 0) == 0) ++ends;
  }
  EXPECT_EQ(ends, 2);
}

// What a joint's torque takes from another one is drawn over the torque that it is a share of.
TEST(DiagnosisJson, SmallFindingsAreListedSeparatelyUnlessAllAreRequested) {
  Diagnosis d = diagnosis();
  d.findings.push_back(d.findings.front());
  d.findings.back().main = false;
  for (const bool apart : {true, false}) {
    d.small_apart = apart;
    const json out = json::parse(to_json(d));
    EXPECT_EQ(out["findings"].size(), apart ? 1U : 2U);
    EXPECT_EQ(out.contains("small"), apart);
  }
}

TEST(DiagnosisPage, CrosstalkIsPlottedOverTheTorqueOfItsSource) {
  Diagnosis d = diagnosis();
  EXPECT_EQ(series_of(to_page(d))["causes"], json({"q2"}));
  d.findings[0].cause = ChannelError{"torque_crosstalk", JointIndex{1}};
  d.findings[0].from = JointIndex{0};
  EXPECT_EQ(series_of(to_page(d))["causes"], json({"tau1"}));
}

TEST_F(OpenedInMemory, AResultWithoutFindingsIsStated) {
  Diagnosis d = diagnosis();
  d.findings.clear();
  d.extended = d.baseline;
  const OpenedPage page = open(to_page(d));
  expect_faultless(page, 800);
  EXPECT_NE(page.html.find("Nothing found"), std::string::npos);
  d.joints.resize(1);
  d.joints[0].joint = JointIndex{0};
  d.joints[0].held_out = 0.4;
  d.joints[0].state = JointState::kAtFloor;
  EXPECT_NE(open(to_page(d)).html.find("No cause was found; joints with an error that no signal of the recordings predicts: 1 (40"), std::string::npos);
  for (const PageElement& plot : page.with("data-plot")) {
    EXPECT_NE(plot.at("data-plot"), "waterfall");
    EXPECT_NE(plot.at("data-model"), "extended");
  }
}

// A fault must not pass for an empty plot.
TEST_F(OpenedInMemory, AScriptErrorIsCountedAndShown) {
  const OpenedPage page =
      open(to_page(diagnosis()),
           "page.dispatchEvent(new page.ErrorEvent('error', {message: 'planted'}));");
  EXPECT_EQ(page.root().at("data-errors"), "1");
  EXPECT_NE(page.html.find("This page is incomplete: planted"), std::string::npos);
}

// The curve of the extended model is its distance from what it was fitted to, on the same samples.
TEST(PageSeries, TheExtendedModelIsDrawnAtTheSamplesOfTheRecording) {
  Diagnosis d = diagnosis();
  PredictionSeries& s = d.extended.test[0].series;
  const auto expected = [&](std::size_t joint, double t) {
    return modelled_at(t) + (joint == 1 ? 0.01 : 0.0);
  };
  const auto expect_curve = [&](const Diagnosis& it) {
    const json recordings = series_of(to_page(it))["recordings"];
    EXPECT_EQ(recordings[0]["role"], "held out");
    for (std::size_t joint : {0u, 1u}) {
      const std::vector<double> curve = column(recordings[0]["joints"][joint]["extended"]);
      ASSERT_EQ(curve.size(), 900u);
      for (std::size_t k = 1; k + 1 < curve.size(); ++k) {
        ASSERT_NEAR(curve[k], expected(joint, kStep * static_cast<double>(k)), 2e-4);
      }
    }
  };
  expect_curve(d);
  // A finding that corrects the torque (twice what was recorded) ...
  for (auto* table : {&s.measured, &s.modelled}) {
    for (auto& column : *table) {
      for (double& tau : column) tau += 5.0;
    }
  }
  expect_curve(d);
  // ... or that shifts the time grid (here by half a sample).
  for (std::size_t k = 0; k < s.time.size(); ++k) {
    s.time[k] += 0.5 * kStep;
    for (std::size_t joint : {0u, 1u}) {
      s.measured[joint][k] = measured_at(s.time[k]);
      s.modelled[joint][k] = expected(joint, s.time[k]);
    }
  }
  expect_curve(d);
}

TEST(PageSeries, LongRecordingsAreThinnedWithoutLossOfPrecision) {
  const Identification id = identification({recording("long.csv", 20000, nowhere)});
  const json shown = series_of(to_page(id))["recordings"][0];
  EXPECT_GT(shown["time"].size(), 2000u);
  EXPECT_LT(shown["time"].size(), 4500u);
  const std::vector<double> measured = column(shown["joints"][0]["measured"]);
  for (std::size_t k = 0; k < measured.size(); ++k) {
    ASSERT_NEAR(measured[k], measured_at(shown["time"][k].get<double>()), 2e-4);
  }
}

TEST(PageSeries, APageOf200RecordingsStaysBelowTwoMegabytes) {
  std::vector<RecordingError> many;
  for (int k = 0; k < 200; ++k) {
    many.push_back(recording("test-" + std::to_string(k) + ".csv", 6000, nowhere));
  }
  const std::string page = to_page(identification(many));
  EXPECT_LT(page.size(), 2000000u);
  const json series = series_of(page);
  const std::size_t shown = series["recordings"].size();
  EXPECT_GT(shown, 20u);
  EXPECT_EQ(shown + series["left_out"].get<std::size_t>(), 201u);
}

TEST(PageSeries, WithoutAModelThereIsNoPage) {
  EXPECT_THROW(to_page(Identification()), InvalidInput);
  EXPECT_THROW(to_page(Diagnosis()), InvalidInput);
}

}  // namespace
}  // namespace veridyn
