#include <memory>

#include "cli/calibration/calibrate_options.hpp"
#include "veridyn/tool/choice.hpp"
#include "veridyn/calibration/hand_eye.hpp"
#include "report/json/calibration_json.hpp"
#include "report/pages/calibration_page.hpp"

namespace veridyn::cli {
namespace {

struct CalibrateHandeyeRequest {
  std::string a, b;
  HandEyeForm form = HandEyeForm::kTwoBases;
  bool has_form = false;
  CaptureOptions capture;
  HandEyeOptions options;
  CommonOptions common;
};

ExitStatus run(CalibrateHandeyeRequest& request, const std::string& command_line) {
  require_writable(request.common.json, request.common.report);
  if (request.has_form) request.options.form = request.form;
  const HandEye found =
      calibrate_hand_eye(read_poses(request.a, request.capture),
                         read_poses(request.b, request.capture), request.options);
  return finish_calibration(found.status == CalibrationStatus::kDone, found.reason, found.report(),
                            request.common, to_json(found),
                            found.status == CalibrationStatus::kDone ? to_page(found, command_line) : "");
}

}  // namespace

void add_calibrate_handeye(CLI::App& calibrate, Outcome& outcome) {
  const auto request = std::make_shared<CalibrateHandeyeRequest>();
  CLI::App& command =
      *calibrate.add_subcommand("handeye", "Pose between two arms, or between an arm and a camera");
  add_value(command, "A", request->a, "t,x,y,z,qw,qx,qy,qz, or rx,ry,rz in place of the quaternion: axis times angle [rad]")->required();
  add_value(command, "B", request->b, "The same, each row paired with that of A")->required();
  CLI::Option* form = add_choice(
      command, "--form", request->form,
      {HandEyeForm::kCommonPoses, HandEyeForm::kCommonPoints, HandEyeForm::kHandEye,
       HandEyeForm::kEyeInHand, HandEyeForm::kTwoBases},
      "A = T B; a = T b (positions); A T = T B; A T B = target; A tool = T B (default: the one "
      "with fewest unknowns that fits)");
  form->default_str("");
  add_capture_options(command, request->capture);
  add_report_option(command, request->common);
  add_common_options(command, request->common);
  command.callback([request, form, &outcome] {
    request->has_form = form->count() > 0;
    outcome.status = run(*request, outcome.command_line);
  });
}

}  // namespace veridyn::cli
