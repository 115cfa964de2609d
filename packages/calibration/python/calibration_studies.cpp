#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include "bindings.hpp"
#include "model_handle.hpp"
#include "options.hpp"
#include "report/json/calibration_json.hpp"
#include "report/pages/calibration_page.hpp"
#include "study.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn::python {
namespace {

CaptureOptions read_capture_options(Keywords& keywords) {
  CaptureOptions o;
  keywords.read("unit", o.unit);
  keywords.read("body", o.body);
  keywords.read("rate", o.rate);
  return o;
}

// A calibration with its JSON, report and page, as Python shows it.
template <typename Found>
SharedStudy study_of(const Found& found) {
  const bool done = found.status == CalibrationStatus::kDone;
  return std::make_shared<Study>(Study{to_json(found), done ? found.report() : found.reason,
                                       [found](const std::string& call) { return to_page(found, call); }});
}

SharedStudy calibrate_links_call(const py::object& model, const std::string& poses, const py::dict& words) {
  Keywords keywords("calibrate_links", words);
  const Model arm = model_of(model);
  const CaptureOptions capture = read_capture_options(keywords);
  LinksOptions o;
  keywords.read("frame", o.frame);
  keywords.read("threads", o.threads);
  const auto attached = [&](const char* name, AttachedPose& pose) {
    keywords.read_choice(name, pose, {AttachedPose::kAutomatic, AttachedPose::kKnown, AttachedPose::kFree}, [](AttachedPose p) {
      return std::string(p == AttachedPose::kAutomatic ? "auto" : p == AttachedPose::kKnown ? "known" : "free");
    });
  };
  attached("base", o.base);
  attached("tool", o.tool);
  keywords.expect_all_taken();
  return interruptible(Progress(py::none()), [=] {
    const LinksCalibration found = calibrate_links(arm, read_poses(poses, capture), o);
    SharedStudy out = study_of(found);
    out->model = found.model;
    return out;
  });
}

SharedStudy calibrate_axis_call(const std::string& markers, const py::dict& words) {
  Keywords keywords("calibrate_axis", words);
  const CaptureOptions capture = read_capture_options(keywords);
  AxesOptions o;
  keywords.read("between", o.between);
  keywords.read("frames", o.most_frames);
  keywords.read("threads", o.threads);
  keywords.expect_all_taken();
  return interruptible(Progress(py::none()), [=] { return study_of(calibrate_axes(read_markers(markers, capture), o)); });
}

SharedStudy calibrate_rcm_call(const std::string& poses, const py::dict& words) {
  Keywords keywords("calibrate_rcm", words);
  const CaptureOptions capture = read_capture_options(keywords);
  keywords.expect_all_taken();
  return interruptible(Progress(py::none()), [=] { return study_of(calibrate_remote_center(read_poses(poses, capture))); });
}

SharedStudy calibrate_handeye_call(const std::string& a, const std::string& b, const py::dict& words) {
  Keywords keywords("calibrate_handeye", words);
  const CaptureOptions capture = read_capture_options(keywords);
  HandEyeOptions o;
  HandEyeForm form = HandEyeForm::kTwoBases;
  if (keywords.given("form")) {
    keywords.read_choice("form", form,
                         {HandEyeForm::kCommonPoses, HandEyeForm::kCommonPoints, HandEyeForm::kHandEye,
                          HandEyeForm::kEyeInHand, HandEyeForm::kTwoBases},
                         [](HandEyeForm f) { return name_of(f); });
    o.form = form;
  }
  keywords.expect_all_taken();
  return interruptible(Progress(py::none()),
                       [=] { return study_of(calibrate_hand_eye(read_poses(a, capture), read_poses(b, capture), o)); });
}

}  // namespace

void bind_calibration(py::module_& m) {
  m.def("calibrate_links", &calibrate_links_call);
  m.def("calibrate_axis", &calibrate_axis_call);
  m.def("calibrate_rcm", &calibrate_rcm_call);
  m.def("calibrate_handeye", &calibrate_handeye_call);
}

}  // namespace veridyn::python
