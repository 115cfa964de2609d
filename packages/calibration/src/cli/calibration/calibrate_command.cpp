#include <iostream>
#include <memory>

#include "cli/calibration/calibrate_options.hpp"
#include "report/json/calibration_json.hpp"
#include "report/pages/calibration_page.hpp"
#include "veridyn/calibration/axes.hpp"
#include "veridyn/calibration/hand_eye.hpp"
#include "veridyn/calibration/remote_center.hpp"
#include "veridyn/files/output_file.hpp"
#include "veridyn/tool/choice.hpp"
#include "veridyn/tool/messages.hpp"
#include "veridyn/tool/program.hpp"

namespace veridyn::cli {
namespace {

template <typename Options>
struct CalibrateRequest {
  std::string file, second_file;
  CaptureOptions capture;
  Options options;
  CommonOptions common;
};

// Adds the options that all subcommands share; @param calibrate  computes the result of a request.
template <typename Options, typename Calibrate>
void finish_command(CLI::App& command, const std::shared_ptr<CalibrateRequest<Options>>& request, Outcome& outcome,
                    const Calibrate& calibrate) {
  add_capture_options(command, request->capture);
  add_report_option(command, request->common);
  add_common_options(command, request->common);
  command.callback([request, calibrate, &outcome] {
    require_writable(request->common.json, request->common.report);
    const auto found = calibrate(*request);
    const bool done = found.status == CalibrationStatus::kDone;
    outcome.status = finish_calibration(done, found.reason, found.report(), request->common, to_json(found),
                                        done ? to_page(found, outcome.command_line) : "");
  });
}

void add_calibrate_axis(CLI::App& calibrate, Outcome& outcome) {
  const auto request = std::make_shared<CalibrateRequest<AxesOptions>>();
  const auto between = std::make_shared<std::vector<std::string>>();
  CLI::App& command = *calibrate.add_subcommand(
      "axis", "Joint axes and links between tracked bodies, from markers");
  add_value(command, "MARKERS", request->file, "t,BODY/MARKER/x,BODY/MARKER/y,BODY/MARKER/z,...")
      ->required();
  add_value(
      command, "--between BODY,BODY", *between,
      "Pairs of bodies (default: all with one axis of rotation); 'world' is the camera system")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  add_value(command, "--frames N", request->options.most_frames,
            "Largest number of frames to use (1500)", CLI::Range(10, 1000000));
  finish_command(command, request, outcome, [between](CalibrateRequest<AxesOptions>& r) {
    for (const std::string& words : *between) {
      const auto comma = words.find(',');
      if (comma == std::string::npos || comma == 0 || comma + 1 == words.size())
        throw CLI::ValidationError("--between", "found '" + words + "', expected BODY,BODY");
      r.options.between.emplace_back(words.substr(0, comma), words.substr(comma + 1));
    }
    r.options.threads = r.common.threads;
    return calibrate_axes(read_markers(r.file, r.capture), r.options);
  });
}

void add_calibrate_rcm(CLI::App& calibrate, Outcome& outcome) {
  const auto request = std::make_shared<CalibrateRequest<RemoteCenterOptions>>();
  CLI::App& command =
      *calibrate.add_subcommand("rcm", "Remote centre of motion of a body, by pivot calibration");
  add_value(command, "POSES", request->file,
            "t,x,y,z,qw,qx,qy,qz of one rigid body, or its markers")
      ->required();
  add_body_option(command, request->capture);
  finish_command(command, request, outcome, [](CalibrateRequest<RemoteCenterOptions>& r) {
    return calibrate_remote_center(read_poses(r.file, r.capture), r.options);
  });
}

void add_calibrate_handeye(CLI::App& calibrate, Outcome& outcome) {
  const auto request = std::make_shared<CalibrateRequest<HandEyeOptions>>();
  const auto chosen = std::make_shared<HandEyeForm>(HandEyeForm::kTwoBases);
  CLI::App& command =
      *calibrate.add_subcommand("handeye", "Pose between two arms, or between an arm and a camera");
  add_value(command, "A", request->file, "t,x,y,z,qw,qx,qy,qz, or rx,ry,rz in place of the quaternion: axis times angle [rad]")->required();
  add_value(command, "B", request->second_file, "The same, each row paired with that of A")->required();
  CLI::Option* form = add_choice(
      command, "--form", *chosen,
      {HandEyeForm::kCommonPoses, HandEyeForm::kCommonPoints, HandEyeForm::kHandEye,
       HandEyeForm::kEyeInHand, HandEyeForm::kTwoBases},
      "A = T B; a = T b (positions); A T = T B; A T B = target; A tool = T B (default: the one "
      "with fewest unknowns that fits)");
  form->default_str("");
  finish_command(command, request, outcome, [form, chosen](CalibrateRequest<HandEyeOptions>& r) {
    if (form->count() > 0) r.options.form = *chosen;
    return calibrate_hand_eye(read_poses(r.file, r.capture), read_poses(r.second_file, r.capture), r.options);
  });
}

}  // namespace

void add_capture_options(CLI::App& command, CaptureOptions& options) {
  add_value(command, "--unit m|cm|mm", options.unit,
            "Unit of positions (default: as the file states, else m)",
            CLI::IsMember({"m", "cm", "mm"}))
      ->group("Recordings");
  add_value(command, "--rate HZ", options.rate, "Sample rate of files without a time column [Hz]",
            CLI::PositiveNumber)
      ->group("Recordings");
}

void add_body_option(CLI::App& command, CaptureOptions& options) {
  add_value(command, "--body NAME", options.body, "Rigid body to use, if a file has several")
      ->group("Recordings");
}

ExitStatus finish_calibration(bool done, const std::string& reason, const std::string& report,
                              const CommonOptions& common, const std::string& json,
                              const std::string& page) {
  if (!done) {
    print_message(reason + ".");
    return kDataCannotAnswer;
  }
  if (!common.json.empty()) write_file(common.json, json);
  if (!common.report.empty()) write_file(common.report, page);
  std::cout << report;
  return kDone;
}

void add_calibrate_command(CLI::App& tool, Outcome& outcome) {
  CLI::App& command = *tool.add_subcommand(
      "calibrate", "Kinematic calibration: axes, remote centre, links, hand-eye");
  command.require_subcommand(1);
  add_calibrate_axis(command, outcome);
  add_calibrate_rcm(command, outcome);
  add_calibrate_links(command, outcome);
  add_calibrate_handeye(command, outcome);
}

}  // namespace veridyn::cli
