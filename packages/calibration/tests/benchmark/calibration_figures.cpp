// Figures of calibration on simulated motion capture: errors and how often intervals hold, over seeds.
//
//   veridyn-calibration-figures [SEEDS]

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>

#include "calibration/closed_forms.hpp"
#include "calibration/simulated_capture.hpp"
#include "veridyn/calibration/axes.hpp"
#include "veridyn/calibration/hand_eye.hpp"
#include "veridyn/calibration/links.hpp"
#include "veridyn/calibration/remote_center.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

constexpr double kDegrees = 180.0 / M_PI;

// Errors against their intervals.
struct Tally {
  const char* name;
  double scale;
  const char* unit;
  std::vector<double> errors{};
  int inside = 0;

  void add(double error, double interval) {
    errors.push_back(std::abs(error));
    inside += std::abs(error) <= interval ? 1 : 0;
  }
  void print() {
    std::sort(errors.begin(), errors.end());
    const auto at = [&](double share) {
      return scale * errors[share * static_cast<double>(errors.size() - 1)];
    };
    fmt::print("{:<34} median {:8.4f} {}, 95 % {:8.4f}, worst {:8.4f}; interval holds in {:5.1f} % of {}\n",
               name, at(0.5), unit, at(0.95), at(1.0), 100.0 * inside / errors.size(), errors.size());
  }
};

void axes(unsigned seeds) {
  const Model arm = read_model("psm-3dof");
  const double truth[] = {0.0, 0.0430 / std::sin(std::atan(0.0430 / 0.1437)), 0.516, 0.516};
  Tally lengths{"link lengths", 1e3, "mm"};
  Tally twists{"angles between axes", kDegrees, "deg"};
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    AxesOptions options;
    options.most_frames = 400;
    const AxesCalibration found = calibrate_axes(captured_psm(arm, 800, {}, seed), options);
    for (size_t k = 0; k < found.links.size() && k < 4; ++k) {
      const CalibratedLink& l = found.links[k];
      lengths.add(l.distance - truth[k], l.distance_half_width);
      twists.add(l.twist - (k == 0 ? 0.5 * M_PI : 0.0), l.twist_half_width);
    }
  }
  lengths.print();
  twists.print();
}

// The closed double parallelogram, and the same recordings without the pairs that close it.
void loops(unsigned seeds) {
  Tally closed{"lengths of a closed loop", 1e3, "mm"};
  Tally open{"the same without its closure", 1e3, "mm"};
  Tally closed_angles{"angles in a closed loop", kDegrees, "deg"};
  Tally open_angles{"the same without its closure", kDegrees, "deg"};
  size_t answered = 0;
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    const MarkerCapture capture = captured_ladder(seed, 800, 1e-4);
    AxesOptions options;
    options.most_frames = 400;
    options.between = ladder_pairs();
    const AxesCalibration with = calibrate_axes(capture, options);
    answered += with.axes.size();
    options.between.erase(options.between.begin() + 6);
    options.between.erase(options.between.begin() + 4);
    const AxesCalibration without = calibrate_axes(capture, options);
    for (const CalibratedLink& l : without.links) {
      const CalibratedAxis& a = without.axes[l.first];
      const CalibratedAxis& b = without.axes[l.second];
      const double angle = ladder_pair(a) == 0 || ladder_pair(b) == 0 ? 0.5 * M_PI : 0.0;
      open.add(l.distance - ladder_distance(a, b), l.distance_half_width);
      open_angles.add(l.twist - angle, l.twist_half_width);
      for (const CalibratedLink& same : with.links) {
        if (ladder_pair(with.axes[same.first]) != ladder_pair(a) ||
            ladder_pair(with.axes[same.second]) != ladder_pair(b))
          continue;
        closed.add(same.distance - ladder_distance(a, b), same.distance_half_width);
        closed_angles.add(same.twist - angle, same.twist_half_width);
      }
    }
  }
  fmt::print("closed double parallelogram: {} of {} pairs answered\n", answered, 7 * seeds);
  closed.print();
  open.print();
  closed_angles.print();
  open_angles.print();
}

// A body with three markers 60 mm from their mean: 0.1 mm of noise turns it by about 1.2 mrad.
constexpr double kPosition = 1e-4 / 1.7320508;
constexpr double kAngle = 1.2e-3;

void centre(unsigned seeds) {
  Tally distance{"remote centre", 1e3, "mm"};
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    RandomNumbers random(seed);
    const Eigen::Vector3d centre(0.1, -0.5, 0.02);
    const Eigen::Vector3d tip(0.05, 0.02, -0.3);
    std::vector<Eigen::Isometry3d> poses;
    for (int k = 0; k < 1000; ++k) {
      const double phase = 2.0 * M_PI * k / 500.0;
      Eigen::Isometry3d T(Eigen::AngleAxisd(k < 500 ? 1.2 * std::sin(phase) : 0.0, Eigen::Vector3d::UnitZ()));
      T.rotate(Eigen::AngleAxisd(k < 500 ? 0.0 : 0.8 * std::sin(phase), Eigen::Vector3d::UnitY()));
      T.translation() = centre - T.linear() * tip;
      poses.push_back(with_noise(T, kPosition, kAngle, random));
      if (random.uniform() < 0.02) poses.back().translation() += Eigen::Vector3d(0.02, 0.01, -0.02);
    }
    const RemoteCenter found = calibrate_remote_center(capture_of(poses));
    distance.add((found.rcm - centre).norm(), found.rcm_radius);
  }
  distance.print();
}

void solve_hand_eye(unsigned seeds) {
  Tally shift{"hand-eye, translation", 1e3, "mm"};
  Tally turn{"hand-eye, rotation", kDegrees, "deg"};
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    RandomNumbers random(seed, 9);
    const Eigen::Isometry3d T = random_pose(random, 0.4);
    const Eigen::Isometry3d tool = random_pose(random, 0.05);
    std::vector<Eigen::Isometry3d> A;
    std::vector<Eigen::Isometry3d> B;
    for (int k = 0; k < 30; ++k) {
      const Eigen::Isometry3d a = random_pose(random, 0.15);
      A.push_back(with_noise(a, 2e-5, 1e-5, random));  // the arm's own encoders
      B.push_back(with_noise(T.inverse() * a * tool, kPosition, 4e-4, random));  // a body 0.2 m wide
    }
    HandEyeOptions options;
    options.form = HandEyeForm::kTwoBases;
    const HandEye found = calibrate_hand_eye(capture_of(A), capture_of(B), options);
    shift.add((found.transform.translation() - T.translation()).norm(), found.radius);
    turn.add(internal::rotation_vector(found.transform.linear().transpose() * T.linear()).norm(),
             found.radius_angle);
  }
  shift.print();
  turn.print();
}

void constants(unsigned seeds) {
  Tally beta{"beta, 1 deg wrong in the file", kDegrees, "deg"};
  int named = 0;
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    const Model truth = read_model("psm-3dof");
    ModelFileOptions wrong;
    wrong.constants["beta"] = truth.description().constants.at("beta") + 1.0 / kDegrees;
    LinksOptions options;
    options.frame = "tool";
    const LinksCalibration found =
        calibrate_links(read_model("psm-3dof", wrong),
                        captured_poses(truth, "tool", 200, 0.9, kPosition, kAngle, seed), options);
    for (const LinkConstant& c : found.constants) {
      if (c.name == "beta")
        beta.add(c.found - truth.description().constants.at("beta"), 0.5 * (c.high - c.low));
    }
    if (found.named.size() == 1)
      named += found.constants[found.named[0]].name == "beta" ? 1 : 0;
  }
  beta.print();
  fmt::print("beta alone is named in {} of {}\n", named, seeds);
}

void print_speed() {
  const Model arm = read_model("kuka-lwr4");
  RandomNumbers random(3);
  const PoseCapture poses = captured_poses(arm, "link7", 10000, 0.9, 1e-4, 1e-3, 1,
                                           random_pose(random, 0.5), random_pose(random, 0.1));
  const std::clock_t began = std::clock();
  const LinksCalibration found = calibrate_links(arm, poses);
  fmt::print("10,000 poses of kuka-lwr4: {:.2f} s of processor time, held out {:.3f} mm\n",
             static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC, 1e3 * found.held_out_rms);
}

}  // namespace
}  // namespace veridyn

int main(int argc, char** argv) {
  const auto seeds = static_cast<unsigned>(argc > 1 ? std::atoi(argv[1]) : 200);
  veridyn::axes(seeds);
  veridyn::loops(std::min(seeds, 50U));
  veridyn::centre(seeds);
  veridyn::solve_hand_eye(seeds);
  veridyn::constants(std::min(seeds, 50U));
  veridyn::print_speed();
  return 0;
}
