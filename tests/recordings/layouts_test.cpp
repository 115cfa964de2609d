#include <gtest/gtest.h>

#include "recordings/csv/csv_header.hpp"
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <regex>
#include <sstream>

#include "recordings/samples.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/recordings/recording.hpp"

namespace veridyn {
namespace {

// One of the list in docs/recordings.md: a file as some program writes it, and what comes of it.
//
// Where nothing else is said, the file holds five rows, 10 ms apart, of the joints shoulder and
// elbow: q = 0.1 + 0.01 k and -0.2 + 0.02 k, tau = 1 + k and 2 - k.
struct Layout {
  const char* name;               // as in the list
  std::string content;            // of a file of its own; empty: `file`
  std::string file = "";          // a sample
  RecordingOptions options = {};
  std::string refused = "";       // part of the message; empty: it is read
  std::string remark = "";        // part of a remark; empty: there is none
  std::vector<std::string> joints = {"shoulder", "elbow"};
  int rows = 5;
  bool standard = true;           // the values are those above
};

using Cell = std::function<std::string(int)>;

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.12g", value);
  return text;
}

double q(int joint, int k) {
  return joint == 0 ? 0.1 + 0.01 * k : -0.2 + 0.02 * k;
}

double tau(int joint, int k) {
  return joint == 0 ? 1.0 + k : 2.0 - k;
}

// A header and five rows: time, q and tau of both joints.
std::string table(const std::string& header, const std::string& separator = ",",
                  double time_factor = 1.0, double start = 0.0, double angle = 1.0) {
  std::string out = header + "\n";
  for (int k = 0; k < 5; ++k) {
    char time[40];
    std::snprintf(time, sizeof time, "%.15g", (start + 0.01 * k) * time_factor);
    out += time;
    for (int j = 0; j < 2; ++j) out += separator + number(angle * q(j, k));
    for (int j = 0; j < 2; ++j) out += separator + number(tau(j, k));
    out += "\n";
  }
  return out;
}

std::string with_commas(std::string text) {
  for (char& c : text) c = c == '.' ? ',' : c;
  return text;
}

RecordingOptions asking(const std::map<std::string, std::string>& map,
                        const std::map<std::string, std::string>& units = {},
                        const std::vector<std::string>& joints = {}) {
  RecordingOptions options;
  options.signals.map = map;
  options.signals.units = units;
  for (const std::string& joint : joints) options.signals.joints.push_back({joint, false});
  return options;
}

RecordingOptions columns(const std::vector<std::string>& names, double rate) {
  RecordingOptions options;
  options.columns = names;
  options.rate = rate;
  return options;
}

RecordingOptions rate(double hertz) {
  RecordingOptions options;
  options.rate = hertz;
  return options;
}

const std::vector<std::string> kNumbers = {"1", "2"};
const std::vector<std::string> kFromZero = {"0", "1"};
const std::vector<std::string> kUr = {"elbow_joint", "shoulder_lift_joint", "shoulder_pan_joint"};
const double kDegrees = 180.0 / std::acos(-1.0);

std::string without_first_line(const std::string& text) {
  return text.substr(text.find('\n') + 1);
}

std::string sparse() {
  std::string out =
      "__time,/arm/shoulder/position,/arm/elbow/position,/arm/shoulder/effort,/arm/elbow/effort,"
      "/tool/temperature\n";
  for (int k = 0; k < 5; ++k) {
    out += number(0.01 * k) + "," + number(q(0, k)) + "," + number(q(1, k)) + "," +
           number(tau(0, k)) + "," + number(tau(1, k)) + ",\n";
    out += number(0.01 * k + 0.003) + ",,,,,30\n";
  }
  return out;
}

std::string repeated(bool same_values) {
  std::string out = "time,shoulder_pos,elbow_pos\n";
  for (int k = 0; k < 5; ++k) {
    out += number(same_values ? 0.01 * k : 0.02 * (k / 2)) + "," + number(q(0, k)) + "," +
           number(q(1, k)) + "\n";
    if (same_values && k == 2) out += number(0.02) + "," + number(q(0, 2)) + "," + number(q(1, 2)) + "\n";
  }
  return out;
}

std::string stamped_pairs() {
  std::string out = "header.stamp.sec,header.stamp.nanosec,position.shoulder,position.elbow\n";
  for (int k = 0; k < 5; ++k)
    out += "1700000000," + std::to_string(10000000 * k) + "," + number(q(0, k)) + "," + number(q(1, k)) + "\n";
  return out;
}

std::string encrypted_bag() {
  const auto field = [](const std::string& text) {
    std::string out(4, '\0');
    out[0] = static_cast<char>(text.size());
    return out + text;
  };
  const std::string header = field(std::string("op=\x03")) + field("encryptor=rosbag/AesCbcEncryptor");
  return "#ROSBAG V2.0\n" + field(header) + std::string(4, '\0');
}

std::vector<Layout> layouts() {
  return {
      {"t, q1..qn, tau1..taun", table("t,q1,q2,tau1,tau2"), "", {}, "", "", kNumbers},
      {"the same between semicolons", table("t;q1;q2;tau1;tau2", ";"), "", {}, "", "", kNumbers},
      {"the same between tabs", table("t\tq1\tq2\ttau1\ttau2", "\t"), "", {}, "", "", kNumbers},
      {"the same between blanks", table("t q1 q2 tau1 tau2", " "), "", {}, "", "", kNumbers},
      {"header behind #", table("# t,q1,q2,tau1,tau2"), "", {}, "", "", kNumbers},
      {"numbers without a header", without_first_line(table("")), "",
       columns({"t", "q", "tau"}, 0.0), "", "", kNumbers},
      {"a header that --columns overrules", table("a,b,c,d,e"), "", columns({"t", "q", "tau"}, 0.0),
       "", "", kNumbers},
      {"decimal commas", with_commas(table("t;q1;q2;tau1;tau2", ";")), "", {}, "", "", kNumbers},
      {"joints' names and decimal commas",
       with_commas(table("Zeitstempel [s];shoulder_pos;elbow_pos;shoulder_tau;elbow_tau", ";")), ""},
      {"a column time", table("time,q1,q2,tau1,tau2"), "", {}, "", "", kNumbers},
      {"quotes, byte-order mark, CRLF",
       "\xEF\xBB\xBF\"time\",\"shoulder/position\",\"elbow/position\",\"shoulder/effort\",\"elbow/"
       "effort\"\r\n" +
           without_first_line(table("")),
       ""},
      {"milliseconds by name", table("time_ms,shoulder_pos,elbow_pos,shoulder_tau,elbow_tau", ",", 1e3), ""},
      {"milliseconds by size", table("time,shoulder_pos,elbow_pos,shoulder_tau,elbow_tau", ",", 1e3), "",
       {}, "", "times are taken for milliseconds"},
      {"microseconds by size", table("time,shoulder_pos,elbow_pos,shoulder_tau,elbow_tau", ",", 1e6), "",
       {}, "", "times are taken for microseconds"},
      {"nanoseconds since 1970",
       "timestamp,shoulder_pos,elbow_pos\n1700000000000000000,0.1,-0.2\n1700000000010000000,0.11,-0.18\n"
       "1700000000020000000,0.12,-0.16\n1700000000030000000,0.13,-0.14\n1700000000040000000,0.14,-0.12\n",
       "", {}, "", "nanoseconds"},
      {"milliseconds by --units", table("t,q1,q2,tau1,tau2", ",", 1e3), "", asking({}, {{"t", "ms"}}),
       "", "", kNumbers},
      {"stamps in two columns", stamped_pairs(), ""},
      {"seconds since 1970", table("t,shoulder.q,elbow.q,shoulder.tau,elbow.tau", ",", 1.0, 1.7e9), ""},
      {"PlotJuggler 3", "", "csv_plotjuggler3_handmade.csv", {}, "", "",
       {"elbow_joint", "shoulder_pan_joint"}, 10, false},
      {"PlotJuggler, newer", "", "csv_plotjuggler_toolbox_handmade.csv", {}, "", "",
       {"elbow_joint", "shoulder_pan_joint"}, 10, false},
      {"PlotJuggler, one topic a row", sparse(), ""},
      {"rostopic echo -p", "", "csv_rostopic_p.csv", {}, "", "", kUr, 30, false},
      {"RTDE, its Python client", "", "csv_ur_rtde_python.csv", {}, "", "",
       {"0", "1", "2", "3", "4", "5"}, 20, false},
      {"RTDE, commas",
       table("timestamp,actual_q_0,actual_q_1,actual_joint_torque_0,actual_joint_torque_1"), "", {}, "", "", kFromZero, 5, false},
      {"MuJoCo", table("time,qpos[0],qpos[1],qfrc_actuator[0],qfrc_actuator[1]"), "", {}, "", "", kFromZero},
      {"joints' names in front", table("time,shoulder_pos,elbow_pos,shoulder_torque,elbow_torque"), ""},
      {"joints' names behind", table("time,pos.shoulder,pos.elbow,eff.shoulder,eff.elbow"), ""},
      {"joints in another order", table("time,pos_elbow,pos_shoulder,tau_elbow,tau_shoulder"), "",
       asking({}, {}, {"shoulder", "elbow"}), "", "", {"shoulder", "elbow"}, 5, false},
      {"words and units", table("Time [s],Shoulder position [deg],Elbow position [deg],Shoulder torque [Nm],"
             "Elbow torque [Nm]", ",", 1.0, 0.0, kDegrees),
       "", {}, "", "q in deg", {"Shoulder", "Elbow"}},
      {"a second line of units",
       table("time,shoulder_pos,elbow_pos,shoulder_tau,elbow_tau\ns,deg,deg,Nm,Nm", ",", 1.0, 0.0, kDegrees), "",
       {}, "", "q in deg"},
      {"degrees by --units", table("t,q1,q2,tau1,tau2", ",", 1.0, 0.0, kDegrees), "",
       asking({}, {{"q", "deg"}}), "", "", kNumbers},
      {"joints' names alone", table("time,shoulder,elbow,a,b"), "",
       asking({{"tau1", "a"}, {"tau2", "b"}}, {}, {"shoulder", "elbow"})},
      {"lines in front of the header",
       "Robot: demo\nOperator: n/a\n" + table("time,shoulder_pos,elbow_pos,shoulder_tau,elbow_tau"), ""},
      {"a row twice", repeated(true), "", {}, "", "1 row repeats the row before"},
      {"a clock too coarse for its rows", repeated(false), "", {}, "", "spread evenly"},
      {"a last row that is cut", table("time,shoulder_pos,elbow_pos,shoulder_tau,elbow_tau") + "0.05,0.1", "",
       {}, "", "the last row is cut"},
      {"columns named by --map", table("clock,a,b,c,d"), "",
       asking({{"t", "clock"}, {"q1", "a"}, {"q2", "b"}, {"tau1", "c"}, {"tau2", "d"}}), "", "", kNumbers},
      {"columns by --map for all joints", table("time,x_1,x_2,y_1,y_2"), "",
       asking({{"q", "x"}, {"tau", "y"}}), "", "", kNumbers},
      {"no time but --rate",
       "shoulder_pos,elbow_pos\n0.1,-0.2\n0.11,-0.18\n0.12,-0.16\n0.13,-0.14\n0.14,-0.12\n", "", rate(100.0)},
      {"ROS 1 bag", "", "ros1_none.bag", {}, "", "", kUr, 200, false},
      {"ROS 1 bag, bz2", "", "ros1_bz2.bag", {}, "", "", kUr, 200, false},
      {"ROS 1 bag, lz4", "", "ros1_lz4.bag", {}, "", "", kUr, 200, false},
      {"ROS 1 bag of a crash", "", "ros1_crash_none.bag", {}, "", "no sound index", kUr, 162, false},
      {"ROS 2 folder, split", "", "rb2_humble_split", {}, "", "", kUr, 200, false},
      {"ROS 2 folder, zstd by file", "", "rb2_zstd_file", {}, "", "", kUr, 200, false},
      {"ROS 2 folder, zstd by message", "", "rb2_zstd_message", {}, "", "", kUr, 100, false},
      {"ROS 2 database alone", "", "rb2_jazzy/rb2_jazzy_0.db3", {}, "", "", kUr, 200, false},
      {"MCAP of ROS 2, zstd", "", "mcap_cdr_zstd.mcap", {}, "", "", kUr, 200, false},
      {"MCAP of ROS 1, lz4", "", "mcap_ros1_lz4.mcap", {}, "", "", kUr, 200, false},
      {"MCAP with JSON", "", "mcap_json.mcap", {}, "", "", kUr, 20, false},
      {"MCAP that is cut", "", "mcap_cdr_truncated.mcap", {}, "", "ends early", kUr, 142, false},
      {"NumPy .npz", "", "numpy.npz", {}, "", "", kFromZero},
      {"NumPy .npz, deflated, with names", "", "numpy_compressed.npz"},
      {"MATLAB 5", "", "matlab5.mat", {}, "", "", kFromZero},
      {"MATLAB 7.3, a struct", "", "matlab73.mat", {}, "", "", kFromZero},
      {"HDF5, a group with names", "", "hdf5.h5"},
      // refused
      {"numbers without a header or --columns", "0,1,2\n1,2,3\n", "", {}, "name them with --columns and --rate"},
      {"a table without positions", "time,a,b\n0,1,2\n", "", {}, "found columns time, a, b, expected a header"},
      {"a table without a time", "shoulder_pos,elbow_pos\n1,2\n", "", {}, "found no column of time"},
      {"text in a joint's column", "time,elbow_pos\n0,1\n0.01,off\n", "", {},
       ":3:2: found 'off' in column elbow_pos, expected a number."},
      {"ragged rows", "time,elbow_pos\n0,1\n0.01\n0.02,3\n", "", {}, ":3: found 1 fields, expected 2."},
      {"a bag without the arm's joints", "", "ros1_none.bag", asking({}, {}, {"yaw"}),
       "none that is yaw, expected --map yaw=NAME, or --fix yaw=VALUE"},
      {"ROS 1 bag before 2.0", "#ROSBAG V1.2\nrest\n", "", {}, "expected a ROS 1 bag of format 2.0"},
      {"ROS 1 bag, encrypted", encrypted_bag(), "", {}, "encrypted with rosbag/AesCbcEncryptor"},
      {"a single array (.npy)", "", "numpy.npy", {}, "expected .npz with t, q, dq and tau (numpy.savez)"},
      {"Parquet", "PAR1....", "", {}, "found a Parquet file, expected it saved as CSV or .npz"},
      {"Excel, old", "\xD0\xCF\x11\xE0....", "", {}, "found an Excel workbook, expected it saved as CSV"},
      {"gzip", "\x1F\x8B....", "", {}, "found a gzip file, expected it unpacked (gunzip)"},
      {"Python pickle", "\x80\x04....", "", {}, "found a Python pickle"},
      {"JSON", "{\"q\": [1, 2]}\n", "", {}, "found JSON, expected a table (CSV) or MCAP"},
      {"rostopic echo without -p", "header: \n  seq: 1\n", "", {}, "expected its table: rostopic echo -p"},
      {"UTF-16", std::string("\xFF\xFEt\0,\0q\0", 8), "", {}, "found text in UTF-16, expected UTF-8"},
      {"XML", "<?xml version=\"1.0\"?>\n", "", {}, "found XML"},
      {"an empty file", "\n", "", {}, "found no row"},
  };
}

class TheLayout : public testing::TestWithParam<Layout> {
 protected:
  void SetUp() override {
    if (GetParam().content.empty()) {
      path_ = sample(GetParam().file);
      return;
    }
    path_ = testing::TempDir() + "veridyn-layout-" + std::to_string(::getpid());
    std::ofstream(path_, std::ios::binary) << GetParam().content;
    made_ = true;
  }
  void TearDown() override {
    if (made_) std::filesystem::remove(path_);
  }
  std::string path_;
  bool made_ = false;
};

std::string name_of(const testing::TestParamInfo<Layout>& info) {
  std::string name;
  for (const char* c = info.param.name; *c != '\0'; ++c)
    name += std::isalnum(static_cast<unsigned char>(*c)) != 0 ? *c : '_';
  return name;
}

INSTANTIATE_TEST_SUITE_P(Of, TheLayout, testing::ValuesIn(layouts()), name_of);

TEST_P(TheLayout, IsReadOrRefusedWithItsMessage) {
  const Layout& layout = GetParam();
  try {
    RecordingReader reader(path_, layout.options);
    const Recording r = reader.next(1000);
    const RecordingFacts facts = reader.facts();
    ASSERT_EQ(layout.refused, "") << "was read";
    EXPECT_EQ(facts.joints, layout.joints);
    ASSERT_EQ(r.rows(), layout.rows);
    std::string remarks;
    for (const std::string& remark : facts.remarks) remarks += remark + "\n";
    EXPECT_NE(remarks.find(layout.remark), std::string::npos) << remarks;
    EXPECT_TRUE(!layout.remark.empty() || remarks.empty()) << remarks;
    if (!layout.standard) return;
    for (int k = 0; k < 5; ++k) {
      EXPECT_NEAR(r.time[k] - r.time[0], 0.01 * k, 1e-9);
      for (int j = 0; j < 2; ++j) {
        EXPECT_NEAR(r.q(k, j), q(j, k), 1e-11);
        if (r.tau.size() > 0) {
          EXPECT_NEAR(r.tau(k, j), tau(j, k), 1e-11);
        }
      }
    }
  } catch (const InvalidInput& error) {
    ASSERT_NE(layout.refused, "") << error.what();
    EXPECT_NE(std::string(error.what()).find(layout.refused), std::string::npos) << error.what();
    EXPECT_EQ(std::string(error.what()).rfind(path_, 0), 0u) << "names no file: " << error.what();
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
  }
}

// A topic of one number for each joint, beside topics of all joints.
TEST(ANameWithSlashes, IsSplitIntoTopicAndJoint) {
  using recordings::split_topic;
  EXPECT_EQ(split_topic("/shoulder/position").topic, "");
  EXPECT_EQ(split_topic("/shoulder/position").path, "shoulder/position");
  EXPECT_EQ(split_topic("/joint_states/position[1]").topic, "/joint_states");
  EXPECT_EQ(split_topic("/arm/shoulder/position").topic, "/arm");
  EXPECT_EQ(split_topic("/arm/shoulder/position").path, "shoulder/position");
}

// As in "[deg]", where the words of the line are units with or without brackets.
TEST(UnitsBelowTheHeader, MayBeWrittenInBrackets) {
  const std::string path = testing::TempDir() + "veridyn-brackets-" + std::to_string(::getpid());
  std::ofstream(path) << table("time,shoulder_pos,elbow_pos,shoulder_tau,elbow_tau\n[ms],[deg],(deg),[mNm],[Nm]", ",", 1e3, 0.0, kDegrees);
  const Recording r = read_recording(path);
  std::filesystem::remove(path);
  ASSERT_EQ(r.rows(), 5);
  EXPECT_NEAR(r.time[4], 0.04, 1e-9);
  EXPECT_NEAR(r.q(3, 1), q(1, 3), 1e-11);
  EXPECT_NEAR(r.tau(3, 0), 1e-3 * tau(0, 3), 1e-14);
}

Recording read_text(const std::string& content, const RecordingOptions& options = {}) {
  const std::string path = testing::TempDir() + "veridyn-text-" + std::to_string(::getpid());
  std::ofstream(path) << content;
  const Recording r = read_recording(path, options);
  std::filesystem::remove(path);
  return r;
}

std::string refusal(const std::string& content) {
  try {
    read_text(content);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

// Also below a header in this project's own names, and again where a logger repeats it; a second recording is refused.
TEST(UnitsBelowTheHeader, MayBeRepeatedWithIt) {
  const std::string header = "t,q1,q2,tau1,tau2\ns,deg,deg,Nm,Nm";
  std::string content = table(header, ",", 1.0, 0.0, kDegrees);
  const std::string later = table(header, ",", 1.0, 0.05, kDegrees);
  const Recording r = read_text(content + later);
  ASSERT_EQ(r.rows(), 10);
  EXPECT_NEAR(r.q(3, 1), q(1, 3), 1e-11);
  EXPECT_NEAR(r.time[9], 0.09, 1e-9);
  EXPECT_NE(refusal(later + content).find("found the header again and an earlier time"), std::string::npos) << refusal(later + content);
}

TEST(ACell, WithAnErrorOfASpreadsheetIsAGap) {
  const Recording r = read_text("t,q1,tau1\n0,0.1,#DIV/0!\n0.01,0.2,#REF!\n0.02,0.3,1\n");
  EXPECT_TRUE(std::isnan(r.tau(0, 0)));
  EXPECT_EQ(r.tau(2, 0), 1.0);
}

TEST(ARefusedTable, HasARemedy) {
  EXPECT_NE(refusal("t,q1,tau1\n0,00,0,10,1,50\n0,01,0,20,1,60\n").find("decimal commas between commas?"), std::string::npos);
  EXPECT_NE(refusal("t,q1,tau1,tau1\n0,0.1,1,2\n").find("rename the one that is not to be used"), std::string::npos);
}

// Positions from one, efforts from zero, as two publishers in one table.
TEST(EffortsCountedFromZero, BelongToPositionsCountedFromOne) {
  const Recording r = read_text(table("time,pos_1,pos_2,JointEffort[0],JointEffort[1]"));
  ASSERT_EQ(r.tau.cols(), 2);
  EXPECT_NEAR(r.tau(3, 0), tau(0, 3), 1e-11);
  EXPECT_NEAR(r.tau(3, 1), tau(1, 3), 1e-11);
}

// Numbers that begin elsewhere are those of other joints, and one with many digits is a name.
TEST(EffortsCountedFromTwo, BelongToOtherJoints) {
  const Recording r = read_text(table("time,pos_1,pos_2,effort_2,effort_3"));
  ASSERT_EQ(r.tau.cols(), 2);
  EXPECT_FALSE(std::isfinite(r.tau(3, 0)));
  const Recording named = read_text("time,pos_1,effort_99999999999999999999\n0,0.1,1\n0.01,0.2,1\n0.02,0.3,1\n");
  EXPECT_TRUE(named.tau.size() == 0 || !std::isfinite(named.tau(0, 0)));
}

// The smallest doubles are times like others.
TEST(ADenormalTime, IsReadAsZero) {
  const std::string path = testing::TempDir() + "veridyn-denormal-" + std::to_string(::getpid());
  std::ofstream(path) << "time,pos_a\n1e-320,0.1\n0.01,0.2\n0.02,0.3\n";
  const Recording r = read_recording(path);
  std::filesystem::remove(path);
  ASSERT_EQ(r.rows(), 3);
  EXPECT_EQ(r.time[0], 0.0);
}

TEST(JointsInAnotherOrder, AreReorderedForTheRobot) {
  const std::string path = testing::TempDir() + "veridyn-order-" + std::to_string(::getpid());
  std::ofstream(path) << table("time,pos_elbow,pos_shoulder,tau_elbow,tau_shoulder");
  const Recording r = read_recording(path, asking({}, {}, {"shoulder", "elbow"}));
  std::filesystem::remove(path);
  for (int k = 0; k < 5; ++k) {
    EXPECT_NEAR(r.q(k, 0), q(1, k), 1e-11);
    EXPECT_NEAR(r.q(k, 1), q(0, k), 1e-11);
    EXPECT_NEAR(r.tau(k, 0), tau(1, k), 1e-11);
  }
}

TEST(ATableOfRtde, HasPositionsVelocitiesAndCurrents) {
  const Recording r = read_recording(sample("csv_ur_rtde_python.csv"));
  ASSERT_EQ(r.rows(), 20);
  ASSERT_EQ(r.current.cols(), 6);
  EXPECT_EQ(r.tau.size(), 0);
  for (int k = 0; k < 20; ++k) {
    EXPECT_NEAR(r.time[k], 1234.5 + 0.008 * k, 1e-9);
    for (int j = 0; j < 6; ++j) {
      EXPECT_NEAR(r.q(k, j), k / 64.0 + j + 0.001, 1e-12);
      EXPECT_EQ(r.dq(k, j), 0.125);
      EXPECT_EQ(r.current(k, j), j / 8.0);
    }
  }
}

TEST(EffortsInAmperes, AreCurrents) {
  const std::string path = testing::TempDir() + "veridyn-amperes-" + std::to_string(::getpid());
  std::ofstream(path) << table("time,pos_a,pos_b,effort_a,effort_b");
  const Recording r = read_recording(path, asking({}, {{"tau", "mA"}}));
  std::filesystem::remove(path);
  EXPECT_EQ(r.tau.size(), 0);
  ASSERT_EQ(r.current.cols(), 2);
  EXPECT_NEAR(r.current(3, 0), 4e-3, 1e-15);
}

// The list that users read and the layouts above are the same; a remark in brackets does not count.
TEST(TheListOfLayouts, InTheDocumentationIsTheOneThatIsTested) {
  std::ifstream file(VERIDYN_SOURCE_DIR "/docs/recordings.md");
  const std::regex remark(R"( \((\([^)]*\)|[^()])*\))");
  std::vector<std::string> documented, tested;
  for (std::string line; std::getline(file, line) && line != "## Layouts";) continue;
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("- **", 0) != 0) continue;
    std::istringstream items(std::regex_replace(line.substr(line.find(": ") + 1, line.size() - line.find(": ") - 2), remark, ""));
    for (std::string item; std::getline(items, item, ';');) documented.push_back(item.substr(1));
  }
  for (const Layout& layout : layouts()) tested.push_back(std::regex_replace(layout.name, remark, ""));
  EXPECT_EQ(documented, tested);
  EXPECT_GE(tested.size(), 40u);
}

}  // namespace
}  // namespace veridyn
