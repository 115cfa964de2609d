#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "hide_and_seek/bench.hpp"
#include "hide_and_seek/swept_room.hpp"
#include "identification/check/check_thresholds.hpp"
#include "veridyn/identification/identification.hpp"
#include "veridyn/identification/robot_check.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/fixed_coordinates.hpp"
#include "veridyn/recordings/recording.hpp"

namespace veridyn::seek {
namespace {

constexpr double kLargestGain = 12.0;  // [N m/A] of the first joint; each of the others has one less
constexpr int kFewRows = 400;
constexpr double kScale = 3.0;

// A mistake of the signals, and the findings that say it.
struct Mistake {
  const char* name;
  std::vector<std::string> findings;
  void (*make)(Recording&);
  bool of_model = false;  // the arm has values
};

void to_currents(Recording& r) {
  for (int i = 0; i < r.joints(); ++i) r.tau.col(i) /= kLargestGain - i;
}

void swap_columns(MatrixXd& m) { m.col(1).swap(m.col(2)); }

const std::vector<Mistake>& mistakes() {
  static const std::vector<Mistake> kAll = {
      {"sound", {}, [](Recording&) {}},
      {"one sign", {"torque_sign:2"}, [](Recording& r) { r.tau.col(1) *= -1.0; }},
      {"all signs", {}, [](Recording& r) { r.tau *= -1.0; }},
      {"swapped torques", {"swapped_joints:2"}, [](Recording& r) { swap_columns(r.tau); }},
      {"swapped motion", {"swapped_joints:2"},
       [](Recording& r) {
         swap_columns(r.q);
         swap_columns(r.dq);
       }},
      {"degrees", {"degrees:0"},
       [](Recording& r) {
         r.q *= 180.0 / M_PI;
         r.dq *= 180.0 / M_PI;
       }},
      {"currents", {"current:0"}, to_currents},
      {"few rows", {}, [](Recording& r) { r = rows_of(r, 0, kFewRows); }},
      {"sound beside a MODEL", {}, [](Recording&) {}, true},
      {"currents beside a MODEL", {"current:0"}, to_currents, true},
      {"scaled beside a MODEL", {"torque_scale:0"}, [](Recording& r) { r.tau *= kScale; }, true}};
  return kAll;
}

// A robot file that knows the gains of its drives.
Model with_gains(const Model& arm) {
  std::vector<double> gains;
  for (int i = 0; i < arm.joints(); ++i) gains.push_back(kLargestGain - i);
  return with_drive_gains(arm, gains);
}

std::vector<std::string> expected_of(const Mistake& one, const Model& arm) {
  if (std::string(one.name) != "all signs") return one.findings;
  std::vector<std::string> out;
  for (int i = 1; i <= arm.joints(); ++i) out.push_back(fmt::format("torque_sign:{}", i));
  return out;
}

TableCase<CheckThresholds> mistaken(const Mistake& mistake, const std::string& name, const Model& arm, Recording r) {
  mistake.make(r);
  const Model robot = std::string(mistake.name).rfind("currents", 0) == 0 ? with_gains(arm) : arm;
  const std::vector<std::string> expected = expected_of(mistake, arm);
  const auto ask = [robot, r, expected](const CheckThresholds& limits) {
    std::vector<std::string> found, faults;
    for (const QualityFinding& f : check_against(robot, r, {}, limits)) {
      found.push_back(fmt::format("{}:{}", f.finding, f.joint));
      if (f.finding != "not_compared" && f.finding != "hardly_moves") faults.push_back(found.back());
    }
    return SweepAnswer{faults == expected, found.empty() ? "nothing" : fmt::format("{}", fmt::join(found, " "))};
  };
  return {name, ask};
}

}  // namespace

SweptRoom check_room(unsigned seed, const std::string& folder) {
  std::vector<TableCase<CheckThresholds>> cases;
  std::filesystem::create_directories(folder);
  for (const char* arm : {"psm-3dof", "pick-scara"}) {
    const Bench bench = make_bench(arm, seed);
    const std::string path = fmt::format("{}/{}.csv", folder, arm);
    write_recording(bench, ideal_recording(bench, {}, Motion(bench.robot, seed, 1), 1), seed, 1, path);
    const Recording sound = read_recording(path);
    const Identification known = identify(bench.robot, {path}, {}, {});
    require(known.model.has_value(), "sweeps: ", arm, " is not identified: ", known.reason);
    for (const Mistake& one : mistakes())
      cases.push_back(mistaken(one, fmt::format("{} {}", one.name, arm), one.of_model ? *known.model : bench.robot, sound));
  }
  return room_of(check_numbers(), cases);
}

}  // namespace veridyn::seek
