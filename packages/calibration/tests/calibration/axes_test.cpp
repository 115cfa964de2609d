#include "veridyn/calibration/axes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "calibration/hinge_path.hpp"
#include "simulated_capture.hpp"
#include "veridyn/kinematics/kinematics.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

using Eigen::Vector3d;

constexpr double kDegree = M_PI / 180.0;

const Model& psm() {
  static const Model kArm = read_model("psm-3dof");
  return kArm;
}

// The distance of successive axes from the robot file: a of the row between them, and the common
// normal of yaw and pitch, which is zero. Arm and instrument are one link: both turn on the elbow.
const std::vector<double> kDistances = {0.0, 0.0430 / std::sin(std::atan(0.0430 / 0.1437)), 0.516,
                                        0.516};

AxesCalibration calibrated(unsigned seed, const CaptureNoise& noise = {}, int frames = 800) {
  AxesOptions options;
  options.most_frames = 400;
  return calibrate_axes(captured_psm(psm(), frames, noise, seed), options);
}

TEST(Axes, ExactMarkersGiveTheLinksOfTheRobotFile) {
  const AxesCalibration found = calibrated(1, {1e-9, 0.0, 0.0, 0.0}, 200);
  ASSERT_EQ(found.status, CalibrationStatus::kDone) << found.reason;
  ASSERT_EQ(found.axes.size(), 5U) << found.report();
  ASSERT_EQ(found.links.size(), 4U);
  for (size_t k = 0; k < 4; ++k) {
    EXPECT_NEAR(found.links[k].distance, kDistances[k], 1e-7) << k;
    EXPECT_NEAR(found.links[k].twist, k == 0 ? 0.5 * M_PI : 0.0, 1e-7) << k;
  }
}

// The thesis's set-up: 0.1 mm of noise, 2 % outliers, 5 % dropouts, eighteen markers.
TEST(Axes, LinkLengthsAndAxesOfANoisyPsmAreWithinTheirIntervals) {
  constexpr int kSeeds = 6;
  int inside = 0;
  int asked = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const AxesCalibration found = calibrated(seed);
    ASSERT_EQ(found.links.size(), 4U) << found.report();
    for (size_t k = 0; k < 4; ++k) {
      const CalibratedLink& link = found.links[k];
      const double miss = std::abs(link.distance - kDistances[k]);
      const double turn = std::abs(link.twist - (k == 0 ? 0.5 * M_PI : 0.0));
      EXPECT_LT(miss, 2e-4) << seed << ", link " << k;
      EXPECT_LT(turn, 0.05 * kDegree) << seed << ", link " << k;
      inside += miss <= link.distance_half_width;
      ++asked;
    }
  }
  EXPECT_GE(inside, 0.8 * asked);
}

// An axis in the cameras' frame, against the robot file's own pose of it.
TEST(Axes, TheFirstAxisIsFoundInTheFrameOfTheCameras) {
  const MarkerCapture capture = captured_psm(psm(), 800, {}, 4);
  AxesOptions options;
  options.most_frames = 400;
  const AxesCalibration found = calibrate_axes(capture, options);
  ASSERT_EQ(found.status, CalibrationStatus::kDone) << found.reason;
  RandomNumbers random(4, 3);
  const Eigen::Isometry3d camera = random_pose(random, 0.3);
  Eigen::Isometry3d mount;
  mount.matrix() = frame_pose(psm(), VectorXd::Zero(3), *psm().find_frame("mount")).matrix();
  const Vector3d z = (camera * mount).linear().col(2);
  const Vector3d off = (found.axes[0].point - (camera * mount).translation()).cross(z);
  EXPECT_GT(std::abs(found.axes[0].direction.dot(z)), std::cos(0.05 * kDegree));
  EXPECT_LT(off.norm(), 2e-4);
}

TEST(Axes, ExchangedMarkerNamesAreRestored) {
  MarkerCapture capture = captured_psm(psm(), 200, {1e-4, 0.0, 0.0, 0.0}, 2);
  for (Eigen::Index k = 20; k < 60; ++k) {
    const Vector3d kept = capture.markers[6].position.col(k);
    capture.markers[6].position.col(k) = capture.markers[7].position.col(k);
    capture.markers[7].position.col(k) = kept;
  }
  const AxesCalibration found = calibrate_axes(capture);
  ASSERT_EQ(found.links.size(), 4U) << found.report();
  EXPECT_GE(found.bodies[2].relabelled, 38);
  EXPECT_LE(found.bodies[2].relabelled, 40);
  EXPECT_NEAR(found.links[1].distance, kDistances[1], 2e-4);
}

TEST(Axes, UndeterminedAxesAreReported) {
  MarkerCapture capture = captured_psm(psm(), 200, {1e-4, 0.0, 0.0, 0.0}, 2);
  MarkerCapture still = capture;
  for (CapturedMarker& m : still.markers)
    m.position = MatrixXd(m.position.col(0)).replicate(1, m.position.cols());
  const AxesCalibration none = calibrate_axes(still);
  EXPECT_EQ(none.status, CalibrationStatus::kCannotAnswer);
  EXPECT_NE(none.reason.find("shows no axis"), std::string::npos) << none.reason;

  MarkerCapture line = capture;
  for (int m = 3; m < 6; ++m)
    line.markers[m].position =
        capture.markers[3].position +
        (m - 3) * 0.3 * (capture.markers[4].position - capture.markers[3].position);
  AxesOptions pair;
  pair.between = {{"base", "yaw"}};
  const AxesCalibration collinear = calibrate_axes(line, pair);
  EXPECT_EQ(collinear.status, CalibrationStatus::kCannotAnswer);
  EXPECT_NE(collinear.reason.find("collinear"), std::string::npos) << collinear.reason;

  MarkerCapture few = capture;
  few.time = capture.time.head(5);
  for (CapturedMarker& m : few.markers) m.position = MatrixXd(m.position.leftCols(5));
  EXPECT_NE(calibrate_axes(few).reason.find("too few frames"), std::string::npos);
}

double ladder_distance(const CalibratedLink& link, const AxesCalibration& found) {
  return ladder_distance(found.axes[link.first], found.axes[link.second]);
}

enum class Loops { kClosed, kOpen };

AxesCalibration calibrated_ladder(unsigned seed, double noise, double play,
                                  Loops loops = Loops::kClosed) {
  AxesOptions options;
  options.most_frames = 300;
  options.between = ladder_pairs();
  if (loops == Loops::kOpen) {
    options.between.erase(options.between.begin() + 6);
    options.between.erase(options.between.begin() + 4);
  }
  return calibrate_axes(captured_ladder(seed, 400, noise, play), options);
}

TEST(Axes, EveryRequestedPairOfADoubleParallelogramIsReported) {
  const AxesCalibration found = calibrated_ladder(1, 1e-7, 0.0);
  ASSERT_EQ(found.status, CalibrationStatus::kDone) << found.reason;
  ASSERT_EQ(found.axes.size(), 7U) << found.report();
  EXPECT_TRUE(found.cannot_tell.empty());
  std::vector<int> pairs;
  int closing = 0;
  for (const CalibratedAxis& axis : found.axes) {
    pairs.push_back(ladder_pair(axis));
    closing += axis.closes_loop;
    EXPECT_EQ(axis.loop_play, 0.0) << axis.a << ", " << axis.b;
  }
  std::sort(pairs.begin(), pairs.end());
  EXPECT_EQ(pairs, (std::vector<int>{0, 1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(closing, 2);
  // Two lengths of each crank, one of each coupler, and those of the yawing body.
  std::map<std::string, int> lengths;
  for (const CalibratedLink& link : found.links) {
    EXPECT_NEAR(link.distance, ladder_distance(link, found), 1e-6) << found.report();
    ++lengths[link.body];
  }
  for (const char* body : {"near", "far"}) EXPECT_GE(lengths[body], 2) << found.report();
  for (const char* body : {"coupler", "outer"}) EXPECT_EQ(lengths[body], 1) << found.report();
}

// With 0.1 mm of noise the lengths' intervals hold, and with the loops those of the angles between
// axes are narrower by a quarter or more.
TEST(Axes, LoopsReduceTheUncertainty) {
  constexpr int kSeeds = 4;
  int inside = 0;
  int asked = 0;
  double closed_width = 0.0;
  double open_width = 0.0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const AxesCalibration closed = calibrated_ladder(seed, 1e-4, 0.0);
    const AxesCalibration open = calibrated_ladder(seed, 1e-4, 0.0, Loops::kOpen);
    ASSERT_EQ(open.axes.size(), 5U) << open.report();
    ASSERT_EQ(closed.axes.size(), 7U) << closed.report();
    for (const CalibratedLink& link : closed.links) {
      const double miss = std::abs(link.distance - ladder_distance(link, closed));
      EXPECT_LT(miss, 2e-4) << closed.report();
      inside += miss <= link.distance_half_width;
      ++asked;
      for (const CalibratedLink& other : open.links) {
        if (ladder_pair(open.axes[other.first]) != ladder_pair(closed.axes[link.first]) ||
            ladder_pair(open.axes[other.second]) != ladder_pair(closed.axes[link.second]))
          continue;
        closed_width += link.twist_half_width;
        open_width += other.twist_half_width;
      }
    }
    for (const CalibratedAxis& axis : closed.axes) EXPECT_EQ(axis.loop_play, 0.0) << seed;
  }
  EXPECT_GE(inside, 0.85 * asked);
  EXPECT_LT(closed_width, 0.75 * open_width);
}

TEST(Axes, PlayInALoopIsMeasured) {
  const AxesCalibration found = calibrated_ladder(3, 1e-4, 5e-4);
  ASSERT_EQ(found.axes.size(), 7U) << found.report();
  double play = 0.0;
  for (const CalibratedAxis& axis : found.axes) play = std::max(play, axis.loop_play);
  EXPECT_GT(play, 2e-4) << found.report();
  EXPECT_LT(play, 7e-4) << found.report();
  for (const CalibratedLink& link : found.links)
    EXPECT_NEAR(link.distance, ladder_distance(link, found), 5e-4) << found.report();
}

TEST(Axes, DerivativesOfALoopMatchCentralDifferences) {
  RandomNumbers random(5);
  for (const bool rests : {false, true}) {
    internal::HingeClosure closure;
    const auto plane_of = [&](internal::Line& line, Eigen::Matrix<double, 3, 2>& plane) {
      const Eigen::Matrix3d R = random_pose(random, 0.0).linear();
      line = {R.col(0), 0.3 * R.col(1)};
      plane = R.rightCols<2>();
    };
    plane_of(closure.start, closure.plane);
    for (internal::HingePath* path : {&closure.a, &closure.b}) {
      path->root = random_pose(random, 0.5);
      path->root_rests = rests;
      path->local_size = (rests ? 0 : 6) + 3;
      path->hinges = path == &closure.a ? std::vector<int>{0} : std::vector<int>{1, 2};
      for (size_t j = 0; j < path->hinges.size(); ++j) {
        path->start.emplace_back();
        path->plane.emplace_back();
        plane_of(path->start.back(), path->plane.back());
      }
    }
    std::vector<VectorXd> x;
    for (const int size : {4, 4, 4, 4, closure.a.local_size}) {
      x.emplace_back(size);
      for (double& v : x.back()) v = 0.2 * random.normal();
    }
    std::vector<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> rows;
    std::vector<const double*> at;
    std::vector<double*> into;
    for (const VectorXd& v : x) rows.emplace_back(6, v.size());
    for (size_t k = 0; k < x.size(); ++k) {
      at.push_back(x[k].data());
      into.push_back(rows[k].data());
    }
    VectorXd r(6);
    closure.evaluate(at.data(), 1e-3, r.data(), into.data());
    for (size_t k = 0; k < x.size(); ++k) {
      for (Eigen::Index c = 0; c < x[k].size(); ++c) {
        VectorXd up(6);
        VectorXd down(6);
        const double was = x[k][c];
        x[k][c] = was + 1e-6;
        closure.evaluate(at.data(), 1e-3, up.data(), nullptr);
        x[k][c] = was - 1e-6;
        closure.evaluate(at.data(), 1e-3, down.data(), nullptr);
        x[k][c] = was;
        EXPECT_LT(((up - down) / 2e-6 - rows[k].col(c)).norm(), 1e-4 * (1.0 + rows[k].col(c).norm()))
            << rests << " block " << k << " column " << c;
      }
    }
  }
}

// The residual's derivatives against differences, for a root that moves and for one that rests.
TEST(Axes, DerivativesOfAMarkerMatchCentralDifferences) {
  RandomNumbers random(3);
  for (const bool rests : {false, true}) {
    internal::HingePath path;
    path.root = random_pose(random, 0.5);
    path.root_rests = rests;
    path.local_size = (rests ? 0 : 6) + 2;
    path.hinges = {0, 1};
    for (int j = 0; j < 2; ++j) {
      const Eigen::Matrix3d R = random_pose(random, 0.0).linear();
      path.start.push_back({R.col(0), R.col(1)});
      path.plane.emplace_back(R.rightCols<2>());
    }
    std::vector<VectorXd> x = {VectorXd::Random(3), 0.1 * VectorXd::Random(4),
                               0.1 * VectorXd::Random(4), 0.3 * VectorXd::Random(path.local_size)};
    std::vector<MatrixXd> J;
    std::vector<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> rows;
    std::vector<const double*> at;
    std::vector<double*> into;
    for (const VectorXd& v : x) rows.emplace_back(3, v.size());
    for (size_t k = 0; k < x.size(); ++k) {
      at.push_back(x[k].data());
      into.push_back(rows[k].data());
    }
    Vector3d r;
    path.evaluate(at.data(), 1e-3, r.data(), into.data());
    for (size_t k = 0; k < x.size(); ++k) {
      for (Eigen::Index c = 0; c < x[k].size(); ++c) {
        Vector3d up;
        Vector3d down;
        const double was = x[k][c];
        x[k][c] = was + 1e-6;
        path.evaluate(at.data(), 1e-3, up.data(), nullptr);
        x[k][c] = was - 1e-6;
        path.evaluate(at.data(), 1e-3, down.data(), nullptr);
        x[k][c] = was;
        EXPECT_LT(((up - down) / 2e-6 - rows[k].col(c)).norm(), 1e-4 * (1.0 + rows[k].col(c).norm()))
            << rests << " block " << k << " column " << c;
      }
    }
  }
}

}  // namespace
}  // namespace veridyn
