#include "cli/motions/excite_poses.hpp"

#include <fmt/format.h>

#include <iostream>
#include <memory>

#include "veridyn/files/output_file.hpp"
#include "veridyn/tool/messages.hpp"
#include "veridyn/tool/option_checks.hpp"
#include "veridyn/calibration/pose_design.hpp"
#include "veridyn/files/model_file.hpp"
#include "report/json/calibration_json.hpp"

namespace veridyn::cli {
namespace {

struct PosesRequest {
  std::string purpose = "identification";
  std::string frame;
  int poses = 30;
};

// Rows t [s], q1..qn of the poses.
std::string poses_as_csv(const PoseDesign& design) {
  std::string out = "t";
  for (Eigen::Index i = 0; i < design.q.cols(); ++i) out += fmt::format(",q{}", i + 1);
  out += "\n";
  for (Eigen::Index k = 0; k < design.q.rows(); ++k) {
    out += fmt::format("{:.3f}", design.time[k]);
    for (Eigen::Index i = 0; i < design.q.cols(); ++i) out += fmt::format(",{:.9g}", design.q(k, i));
    out += "\n";
  }
  return out;
}

void add_poses_options(CLI::App& command, PosesRequest& request) {
  const char* const group = "Poses (--for calibration)";
  add_value(
      command, "--for identification|calibration", request.purpose,
      "Design a trajectory for identification, or poses for kinematic calibration (identification)",
      CLI::IsMember({"identification", "calibration"}))
      ->group(group);
  add_value(command, "--frame NAME", request.frame, "Frame tracked by cameras (default: the last)")
      ->group(group);
  add_value(command, "--poses N", request.poses, "Number of poses (30)", CLI::Range(1, 10000))
      ->group(group);
}

void expect_no_motion_options(const CLI::App& command) {
  for (const char* option :
       {"--frequency", "--harmonics", "--duration", "--slow-passes", "--rate", "--criterion",
        "--between", "--given", "--coefficients", "--solver", "--model", "--box", "--sphere",
        "--obstacle", "--insertion", "--report", "--torque-noise", "--noise-of", "--resume",
        "--columns", "--given-rate", "--topic", "--map", "--units", "--rows", "--fix", "--speed"}) {
    if (command.count(option) > 0)
      throw CLI::ValidationError(option, "shapes a motion, and --for calibration asks for poses");
  }
}

ExitStatus run(const ExciteExtension::Request& call, const PosesRequest& request) {
  const CommonOptions& common = call.common;
  const Model arm = read_model(call.robot);
  if (!request.frame.empty()) expect_one_of("--frame", request.frame, frame_names(arm));
  PoseDesignOptions options;
  options.frame = request.frame;
  options.poses = request.poses;
  options.limit_share = call.limit_share.value_or(0.95);
  options.seed = call.seed;
  const PoseDesign design =
      while_busy(common, "choosing poses", [&] { return design_poses(arm, options); });
  if (design.status != CalibrationStatus::kDone) {
    print_message(design.reason + ".");
    return kDataCannotAnswer;
  }
  write_file(call.output, poses_as_csv(design));
  if (!common.json.empty()) write_file(common.json, to_json(design));
  std::cout << design.report();
  return kDone;
}

}  // namespace

ExciteExtension excite_poses() {
  const auto request = std::make_shared<PosesRequest>();
  const auto run_poses = [request](const ExciteExtension::Request& call) -> std::optional<ExitStatus> {
    if (request->purpose == "calibration") {
      expect_no_motion_options(*call.command);
      return run(call, *request);
    }
    expect_prerequisites(*call.command, {{"--poses", false, "--for calibration"}, {"--frame", false, "--for calibration"}});
    return std::nullopt;
  };
  return {[request](CLI::App& command) { add_poses_options(command, *request); }, run_poses};
}

}  // namespace veridyn::cli
