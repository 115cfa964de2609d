#include <memory>

#include "cli/calibration/calibrate_options.hpp"
#include "veridyn/calibration/axes.hpp"
#include "report/json/calibration_json.hpp"
#include "report/pages/calibration_page.hpp"

namespace veridyn::cli {
namespace {

struct CalibrateAxisRequest {
  std::string markers;
  std::vector<std::string> between;
  CaptureOptions capture;
  AxesOptions options;
  CommonOptions common;
};

ExitStatus run(CalibrateAxisRequest& request, const std::string& command_line) {
  require_writable(request.common.json, request.common.report);
  for (const std::string& words : request.between) {
    const auto comma = words.find(',');
    if (comma == std::string::npos || comma == 0 || comma + 1 == words.size())
      throw CLI::ValidationError("--between", "found '" + words + "', expected BODY,BODY");
    request.options.between.emplace_back(words.substr(0, comma), words.substr(comma + 1));
  }
  request.options.threads = request.common.threads;
  const AxesCalibration found =
      calibrate_axes(read_markers(request.markers, request.capture), request.options);
  return finish_calibration(found.status == CalibrationStatus::kDone, found.reason, found.report(),
                            request.common, to_json(found),
                            found.status == CalibrationStatus::kDone ? to_page(found, command_line) : "");
}

}  // namespace

void add_calibrate_axis(CLI::App& calibrate, Outcome& outcome) {
  const auto request = std::make_shared<CalibrateAxisRequest>();
  CLI::App& command = *calibrate.add_subcommand(
      "axis", "Joint axes and links between tracked bodies, from markers");
  add_value(command, "MARKERS", request->markers, "t,BODY/MARKER/x,BODY/MARKER/y,BODY/MARKER/z,...")
      ->required();
  add_value(
      command, "--between BODY,BODY", request->between,
      "Pairs of bodies (default: all with one axis of rotation); 'world' is the camera system")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  add_value(command, "--frames N", request->options.most_frames,
            "Largest number of frames to use (1500)", CLI::Range(10, 1000000));
  add_capture_options(command, request->capture);
  add_report_option(command, request->common);
  add_common_options(command, request->common);
  command.callback([request, &outcome] { outcome.status = run(*request, outcome.command_line); });
}

}  // namespace veridyn::cli
