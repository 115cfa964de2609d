#include <memory>

#include "cli/calibration/calibrate_options.hpp"
#include "veridyn/tool/messages.hpp"
#include "veridyn/calibration/remote_center.hpp"
#include "veridyn/math/require.hpp"
#include "report/json/calibration_json.hpp"
#include "report/pages/calibration_page.hpp"

namespace veridyn::cli {
namespace {

struct CalibrateRcmRequest {
  std::string poses;
  CaptureOptions capture;
  RemoteCenterOptions options;
  CommonOptions common;
};

ExitStatus run(const CalibrateRcmRequest& request, const std::string& command_line) {
  require_writable(request.common.json, request.common.report);
  const RemoteCenter found =
      calibrate_remote_center(read_poses(request.poses, request.capture), request.options);
  return finish_calibration(found.status == CalibrationStatus::kDone, found.reason, found.report(),
                            request.common, to_json(found),
                            found.status == CalibrationStatus::kDone ? to_page(found, command_line) : "");
}

}  // namespace

void add_calibrate_rcm(CLI::App& calibrate, Outcome& outcome) {
  const auto request = std::make_shared<CalibrateRcmRequest>();
  CLI::App& command =
      *calibrate.add_subcommand("rcm", "Remote centre of motion of a body, by pivot calibration");
  add_value(command, "POSES", request->poses,
            "t,x,y,z,qw,qx,qy,qz of one rigid body, or its markers")
      ->required();
  add_body_option(command, request->capture);
  add_capture_options(command, request->capture);
  add_report_option(command, request->common);
  add_common_options(command, request->common);
  command.callback([request, &outcome] { outcome.status = run(*request, outcome.command_line); });
}

}  // namespace veridyn::cli
