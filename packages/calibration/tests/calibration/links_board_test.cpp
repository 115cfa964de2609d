#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "veridyn/calibration/links.hpp"
#include "calibration/simulated_capture.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kMetres = 1e-4, kRadians = 5e-4;  // noise of a pose
constexpr double kShare = 0.8;                     // of every joint's range

// An arm whose file has a wrong constant or another base, and the constants that a calibration must report.
struct WrongFile {
  const char* name;
  const char* robot;
  const char* frame;
  std::set<std::string> named = {};  // empty: nothing differs, or the poses are refused
  bool free = false;            // base and tool are not the file's
  std::string constant = "";    // of the true arm that differs from the file
  double by = 0.0;
  std::string zero = "";  // coordinate whose encoder has a wrong zero
  double zero_by = 0.0;
  double base_by = 0.0;  // [m] by which the base stands beside that of the file
  int poses = 150;
  bool orientation = true;
  AttachedPose attached = AttachedPose::kAutomatic;
};

void wrong_beta(WrongFile& w, double degrees) {
  w.constant = "beta";
  w.by = -degrees * kDegree;
  w.named = {"beta"};
}

void wrong_zero(WrongFile& w, const char* coordinate, double by) {
  w.zero = coordinate;
  w.zero_by = by;
  w.named = {std::string("zero of ") + coordinate};
}

void move_base(WrongFile& w, double metres) {
  w.base_by = metres;
  w.free = true;
}

std::vector<WrongFile> wrong_files() {
  struct Entry {
    const char *name, *robot, *frame;
    void (*how)(WrongFile&);
  };
  static const std::vector<Entry> kAll = {
      {"nothing", "psm-3dof", "tool", [](WrongFile&) {}},
      {"nothing of a six-joint arm", "ur10e", "flange", [](WrongFile&) {}},
      {"nothing in positions alone", "psm-3dof", "tool", [](WrongFile& w) { w.orientation = false; }},
      {"nothing in few poses", "psm-3dof", "tool", [](WrongFile& w) { w.poses = 14; }},
      {"too few poses", "psm-3dof", "tool", [](WrongFile& w) { w.poses = 8; }},
      {"base elsewhere by 20 mm", "ur10e", "flange", [](WrongFile& w) { move_base(w, 0.02); }},
      {"base elsewhere by 300 mm", "ur10e", "flange", [](WrongFile& w) { move_base(w, 0.3); }},
      {"beta by 1 deg", "psm-3dof", "tool", [](WrongFile& w) { wrong_beta(w, 1.0); }},
      {"beta by 0.2 deg", "psm-3dof", "tool", [](WrongFile& w) {
         wrong_beta(w, 0.2);
         w.named = {"zero of insertion"};  // fails: the error is too small to be distinguished
       }},
      {"beta by 1 deg in positions alone", "psm-3dof", "tool", [](WrongFile& w) { wrong_beta(w, 1.0), w.orientation = false; }},
      {"delta with base and tool unknown", "psm-3dof", "counterweight", [](WrongFile& w) {
         w.constant = "delta";
         w.by = 0.02;
         w.named = {"delta"};
         move_base(w, 0.5);
       }},
      {"printed counterweight", "psm-3dof-printed", "counterweight",
       [](WrongFile& w) {
         w.named = {"theta counterweight_rail"};
         w.free = true;  // wrong as it is: base and tool are where the file has them
       }},
      {"zero of pitch on the tool", "psm-3dof", "tool", [](WrongFile& w) { wrong_zero(w, "pitch", 0.02); }},
      {"zero of pitch on the wrist", "psm-3dof", "wrist", [](WrongFile& w) { wrong_zero(w, "pitch", 0.02); }},
      {"zero of pitch on the counterweight", "psm-3dof", "counterweight", [](WrongFile& w) { wrong_zero(w, "pitch", 0.02); }},
      {"zero of pitch with base and tool unknown", "psm-3dof", "tool", [](WrongFile& w) {
         wrong_zero(w, "pitch", 0.02);
         w.attached = AttachedPose::kFree;
         w.free = true;
       }},
      {"zero of insertion by 3 mm", "psm-3dof", "tool", [](WrongFile& w) { wrong_zero(w, "insertion", 0.003); }},
      {"zero of an elbow by 0.4 deg", "ur10e", "flange", [](WrongFile& w) { wrong_zero(w, "elbow", 0.4 * kDegree); }},
      {"zero of an elbow by 0.05 deg", "ur10e", "flange", [](WrongFile& w) { wrong_zero(w, "elbow", 0.05 * kDegree); }}};
  std::vector<WrongFile> out;
  for (const Entry& one : kAll) {
    out.push_back({one.name, one.robot, one.frame});
    one.how(out.back());
  }
  return out;
}

PoseCapture poses_of(const WrongFile& one, unsigned seed) {
  ModelFileOptions options;
  const std::string robot = one.robot == std::string("psm-3dof-printed") ? "psm-3dof" : one.robot;
  if (!one.constant.empty()) options.constants[one.constant] = read_model(robot).description().constants.at(one.constant) + one.by;
  const Model truth = read_model(robot, options);
  Eigen::Isometry3d base = Eigen::Isometry3d::Identity(), tool = base;
  RandomNumbers random(seed, 9);
  if (one.base_by > 0.1) base = random_pose(random, one.base_by);
  else base.translation().y() = one.base_by;
  if (one.named.count("delta") != 0) tool = random_pose(random, 0.05);
  PoseCapture out = captured_poses(truth, one.frame, one.poses, kShare, kMetres, kRadians, seed, base, tool);
  for (int i = 0; i < truth.joints(); ++i)
    if (truth.coordinates()[i].name == one.zero) out.q.col(i).array() += one.zero_by;
  out.has_orientation = one.orientation;
  return out;
}

TEST(LinksBoard, OnlyTheWrongConstantOfAFileIsReported) {
  constexpr unsigned kSeed = 811;
  for (const WrongFile& one : wrong_files()) {
    LinksOptions options;
    options.frame = one.frame;
    options.base = options.tool = one.attached;
    const LinksCalibration found = calibrate_links(read_model(one.robot), poses_of(one, kSeed), options);
    const bool done = found.status == CalibrationStatus::kDone;
    EXPECT_EQ(done, one.poses >= 10) << one.name;
    if (!done) continue;
    std::set<std::string> named;
    for (const int k : found.named) {
      const LinkConstant& c = found.constants[k];
      named.insert(c.name + (c.frame.empty() ? "" : " " + c.frame));
    }
    EXPECT_EQ(named, one.named) << one.name;
    EXPECT_TRUE(found.explained) << one.name;
    EXPECT_EQ(found.base_free, one.free) << one.name;
  }
}

}  // namespace
}  // namespace veridyn
