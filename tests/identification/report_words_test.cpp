#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "veridyn/identification/parameters_text.hpp"
#include "veridyn/identification/drive_gains.hpp"
#include "veridyn/identification/fleet.hpp"
#include "veridyn/identification/identification.hpp"
#include "veridyn/files/model_file.hpp"

// Words of reports: what is there is said, and what is not there leaves no empty line.

namespace veridyn {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

testing::AssertionResult report_contains(const std::string& report, const std::string& words) {
  if (report.find(words) != std::string::npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "found no '" << words << "' in\n" << report;
}

Fleet fleet_of(int arms) {
  Fleet f;
  f.robot = "planar-2r";
  f.model = read_model("planar-2r");
  f.joints = 2;
  for (int a = 0; a < arms; ++a) {
    FleetMember m;
    m.name = "arm-" + std::to_string(a);
    m.relative_error = Eigen::Vector2d(0.01 * (a + 1), 0.02);
    m.alone_error = Eigen::Vector2d(0.005, 0.01);
    f.members.push_back(m);
  }
  return f;
}

TEST(TheFleetsReport, ListsOutliersAndExcludedArmsAndCountsTheRest) {
  Fleet f = fleet_of(3);
  EXPECT_TRUE(report_contains(f.report(), "no arm stands out"));
  EXPECT_TRUE(report_contains(f.report(), "joint 1: 2.00 % with the fleet's bodies, 0.50 % with its own"));
  for (const char* absent : {"left out", "more\n", "remark"}) EXPECT_FALSE(report_contains(f.report(), absent));
  f.undetermined.push_back({"arm-9", "joint elbow never moves"});
  f.unusable_recordings.push_back({"a.csv", "a.csv: found no such file."});
  f.remarks.push_back("b.csv: dq2 is no derivative");
  EXPECT_TRUE(report_contains(f.report(), "1 arm left out whose recordings leave the bodies open\n  arm-9: joint elbow never moves\n"));
  EXPECT_TRUE(report_contains(f.report(), "\n1 file left out\n"));
  EXPECT_TRUE(report_contains(f.report(), "remark: b.csv: dq2"));
  for (int k = 0; k < 40; ++k) {
    f.outliers.push_back({"arm-1", "torque_gain:elbow", JointIndex{1}, 1.1, 1.0, 9.0});
    f.other_bodies.push_back({"arm-2", {0}, 0.3, 0.1, 2.0, 0.1, 8.0});
    f.undetermined.push_back(f.undetermined.front());
    f.unusable_recordings.push_back(f.unusable_recordings.front());
  }
  const std::string many = f.report();
  EXPECT_TRUE(report_contains(many, "\n40 that stand out\n  arm-1: torque_gain:elbow is 1.1, the fleet's median 1; +9.0 deviations\n"));
  EXPECT_TRUE(report_contains(many, "40 of 3 arms left out of the shared bodies"));
  EXPECT_TRUE(report_contains(many, "41 arms left out whose recordings leave the bodies open"));
  EXPECT_TRUE(report_contains(many, "\n41 files left out\n"));
  size_t more = 0;
  for (size_t at = many.find("  and "); at != std::string::npos; at = many.find("  and ", at + 1)) ++more;
  EXPECT_EQ(more, 3U) << many;  // each list ends
}

TEST(TheFleetsReport, StatesTheReasonWhereThereIsNoModel) {
  Fleet f;
  f.robot = "scara";
  f.reason = "found 2 arms, expected 3 at least";
  EXPECT_EQ(f.report(), "scara: no fleet: found 2 arms, expected 3 at least.\n");
}

TEST(TheReportOfDriveGains, ListsEachGainOrTheReasonForNone) {
  DriveGains g;
  MountedLoad load;
  load.known = {2.0, "flange", {"lab/a.csv", "b.csv"}};
  load.identified = true;
  g.loads.push_back(load);
  load.identified = false;
  load.centre = Eigen::Vector3d(0.01, 0.02, 0.03);
  g.loads.push_back(load);
  DriveGain waist{"waist", "N m/A", true, "", 12.0, 0.1, 11.8, 12.2, 11.0, 0.2};
  DriveGain roll{"roll", "N m/A", false, "nothing ties its currents to the known mass", 3.0, kInf, -kInf, kInf, 0.0, 0.0};
  g.joints = {waist, roll};
  const std::string report = g.report();
  EXPECT_TRUE(report_contains(report, "2 kg on flange in a.csv, b.csv (identified)\n"));
  EXPECT_TRUE(report_contains(report, "2 kg on flange in a.csv, b.csv, its centre at [0.010, 0.020, 0.030] m +- [0.000, 0.000, 0.000]\n"));
  EXPECT_TRUE(report_contains(report, "12 N m/A (95 %: 11.8 to 12.2), 11 in the robot file\n"));
  EXPECT_TRUE(report_contains(report, "roll             not identifiable: nothing ties"));
  EXPECT_FALSE(report_contains(report, "inf"));
  g.problem = "the recordings do not show the known mass";
  EXPECT_TRUE(report_contains(g.report(), "  none: the recordings do not show the known mass\n"));
  EXPECT_FALSE(report_contains(g.report(), "12 N m/A"));
}

TEST(TheReport, ListsRemarksAndExcludedRows) {
  Identification id;
  id.robot = "planar-2r";
  id.reason = "it ended early";
  id.method = Method::kOls;
  EXPECT_TRUE(report_contains(id.report(), "planar-2r: ordinary least squares, 0 rows\nno model: it ended early\n"));
  id.model = read_model("planar-2r");
  id.method = Method::kDidim;
  id.train_error.relative = Eigen::Vector2d(0.1, kInf);
  id.active_constraints = {"m_fore <= 1"};
  id.base.push_back({"m_fore", "m_fore", "kg", 1.0, std::numeric_limits<double>::quiet_NaN()});
  RecordingError one;
  one.source = "one.csv";
  one.error.relative = Eigen::Vector2d(0.2, 0.3);
  one.rows = 1000;
  one.filled = {1, 0.001};
  RecordingError other = one;
  other.source = "other.csv";
  other.filled = {500, 5.0};
  id.test = {one};
  EXPECT_FALSE(report_contains(id.report(), "one.csv"));  // its errors are those of all
  id.test.push_back(other);
  const std::string report = id.report();
  EXPECT_TRUE(report_contains(report, "direct and inverse model"));
  EXPECT_TRUE(report_contains(report, "warning: it ended early\n"));
  EXPECT_TRUE(report_contains(report, "NOT physically possible"));
  EXPECT_TRUE(report_contains(report, "one.csv\n"));
  EXPECT_TRUE(report_contains(report, "other.csv: 50 % of the rows repeated the row before, 10.0 ms late"));
  EXPECT_FALSE(report_contains(report, "one.csv: 0.1 % of the rows"));
  EXPECT_TRUE(report_contains(report, "at the edge of what is physically possible: m_fore <= 1\n"));
  EXPECT_TRUE(report_contains(parameters_text(id), "            1           -  kg        m_fore\n"));
}

}  // namespace
}  // namespace veridyn
