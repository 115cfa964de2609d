#include <memory>
#include <nlohmann/json.hpp>

#include "veridyn/files/input_file.hpp"
#include "cli/calibration/calibrate_options.hpp"
#include "veridyn/tool/option_checks.hpp"
#include "veridyn/tool/sound_arguments.hpp"
#include "veridyn/calibration/links.hpp"
#include "veridyn/effects/cause.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "report/json/calibration_json.hpp"
#include "report/pages/calibration_page.hpp"

namespace veridyn::cli {
namespace {

struct CalibrateLinksRequest {
  std::string robot, poses, robot_out, diagnosis, base = "auto", tool = "auto";
  CaptureOptions capture;
  LinksOptions options;
  CommonOptions common;
};

// "known", "free"; else automatic.
AttachedPose parsed_attached_pose(const std::string& word) {
  if (word == "known") return AttachedPose::kKnown;
  return word == "free" ? AttachedPose::kFree : AttachedPose::kAutomatic;
}

// One line that compares the result with the wrong constant in the JSON of `diagnose`; empty without such a
// constant.
// Throws InvalidInput if the file has no findings.
std::string comparison_in(const std::string& file, const LinksCalibration& links) {
  const nlohmann::json diagnosis =
      nlohmann::json::parse(content_of_file(file, "what diagnose --json wrote"), nullptr, false);
  require(diagnosis.is_object() && diagnosis.contains("findings"), file,
          ": found no findings, expected what diagnose --json wrote.");
  std::string zero;
  for (const nlohmann::json& finding : diagnosis["findings"]) {
    const std::string effect = finding.value("effect", "");
    if (has_effect(effect) && find_effect(effect).traits().same_as_wrong_constant)
      zero = to_text(CauseText{effect, finding.value("coordinate", "")});
    if (effect != KinematicError::kName) continue;
    const nlohmann::json& value = finding.at("parameters").at("value");
    return compare_wrong_constant(links, finding.at("frame").get<std::string>(),
                                  finding.at("constant").get<std::string>(),
                                  value.at("value").get<double>(),
                                  value.at("ci95").at(0).get<double>(),
                                  value.at("ci95").at(1).get<double>());
  }
  if (zero.empty()) return "Torques ask for no other constant.";
  std::string named;
  for (const int k : links.named) {
    const LinkConstant& c = links.constants[k];
    named += (named.empty() ? "" : ", ") + c.name + (c.frame.empty() ? "" : " of frame " + c.frame);
  }
  return "Torques name a zero (" + zero + "), poses " +
         (named.empty() ? "no constant" : named) + ": only one of them is wrong, or both are off.";
}

// comparison_in(), with InvalidInput for JSON of another structure.
std::string comparison_with(const std::string& file, const LinksCalibration& links) {
  try {
    return comparison_in(file, links);
  } catch (const nlohmann::json::exception& error) {
    throw InvalidInput(text(file, ": found another structure (", error.what(),
                            "), expected what diagnose --json wrote."));
  }
}

ExitStatus run(CalibrateLinksRequest& request, const std::string& command_line) {
  require_writable(request.common.json, request.common.report, request.robot_out);
  const Model arm = read_model(request.robot);
  if (!request.options.frame.empty())
    expect_one_of("--frame", request.options.frame, frame_names(arm));
  request.options.base = parsed_attached_pose(request.base);
  request.options.tool = parsed_attached_pose(request.tool);
  request.options.threads = request.common.threads;
  const LinksCalibration found = while_busy(request.common, "calibrating", [&] {
    return calibrate_links(arm, read_poses(request.poses, request.capture), request.options);
  });
  const bool done = found.status == CalibrationStatus::kDone;
  const std::string comparison =
      done && !request.diagnosis.empty() ? comparison_with(request.diagnosis, found) : "";
  if (done && !request.robot_out.empty()) save_model(*found.model, request.robot_out);
  const std::string report = found.report() + (comparison.empty() ? "" : comparison + "\n");
  return finish_calibration(done, found.reason, report, request.common,
                            to_json(found, request.robot_out, comparison),
                            done ? to_page(found, command_line, comparison) : "");
}

}  // namespace

void add_calibrate_links(CLI::App& calibrate, Outcome& outcome) {
  const auto request = std::make_shared<CalibrateLinksRequest>();
  CLI::App& command = *calibrate.add_subcommand(
      "links", "Kinematic parameters of a robot, from poses of one frame and joint positions");
  add_robot_argument(command, request->robot);
  add_value(command, "POSES", request->poses, "t,q1..qn,x,y,z,qw,qx,qy,qz; orientation may miss")
      ->required();
  add_value(command, "--frame NAME", request->options.frame,
            "Frame that was tracked (default: the last)");
  add_output_option(command, "--robot-out", request->robot_out, "Write the calibrated robot file");
  const auto pose = [&](const char* option, std::string& target, const char* help) {
    command.add_option(option, target, help)
        ->option_text("auto|known|free")
        ->check(CLI::IsMember({"auto", "known", "free"}));
  };
  pose("--base", request->base,
       "Pose of the robot's base in the frame of the poses: known (identity), free, or chosen by "
       "fit (auto)");
  pose("--tool", request->tool, "Pose of the tracked body on the frame, likewise (auto)");
  add_value(command, "--diagnosis FILE", request->diagnosis,
            "Result of diagnose --json, whose wrong constant is comparison_in");
  add_body_option(command, request->capture);
  add_capture_options(command, request->capture);
  add_report_option(command, request->common);
  add_common_options(command, request->common);
  command.callback([request, &outcome] { outcome.status = run(*request, outcome.command_line); });
}

}  // namespace veridyn::cli
