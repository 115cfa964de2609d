#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include "bindings.hpp"
#include "control/kinematics_table.hpp"
#include "model_handle.hpp"
#include "options.hpp"
#include "study.hpp"
#include "report/json/kinematics_json.hpp"
#include "veridyn/diagnosis/friction_study.hpp"
#include "veridyn/identification/fleet.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/report/diagnosis_json.hpp"
#include "veridyn/report/json.hpp"
#include "veridyn/report/pages.hpp"

namespace veridyn::python {
namespace {

Progress progress_of(Keywords& keywords) {
  const py::object callback = keywords.value_of("progress");
  return Progress(callback ? callback : py::none());
}

// ---- fleet ----

std::vector<FleetArm> arms_of(const py::object& given) {
  if (!py::isinstance<py::dict>(given)) return read_fleet(py::str(given).cast<std::string>());
  std::vector<FleetArm> out;
  for (const auto& [name, files] : given.cast<py::dict>()) {
    FleetArm arm{name.cast<std::string>(), {}};
    const bool one = py::isinstance<py::str>(files) || py::hasattr(files, "__fspath__");
    for (const py::handle file : one ? py::list(py::make_tuple(files)) : py::list(py::reinterpret_borrow<py::object>(files)))
      arm.files.push_back(py::str(file).cast<std::string>());
    out.push_back(std::move(arm));
  }
  return out;
}

SharedStudy fleet_call(const py::object& model, const py::object& arms, const py::dict& words) {
  Keywords keywords("fleet", words);
  const Model arm = model_of(model);
  const std::vector<FleetArm> all = arms_of(arms);
  const Progress progress = progress_of(keywords);
  FleetOptions o;
  keywords.read("significance", o.significance);
  keywords.read("threads", o.threads);
  read_preprocessing(keywords, o.preprocessing);
  keywords.expect_all_taken();
  o.progress = [progress](const std::string& what, double share) { progress(what, share); };
  return interruptible(progress, [=] {
    const Fleet found = identify_fleet(arm, all, o);
    return std::make_shared<Study>(Study{to_json(found), found.model ? found.report() : found.reason,
                                         [found](const std::string& call) { return to_page(found, call); }, found.model});
  });
}

// ---- friction ----

SharedStudy friction_call(const py::object& model, const py::object& recordings, const py::object& test,
                          const py::dict& words) {
  Keywords keywords("friction", words);
  const Progress progress = progress_of(keywords);
  const Model arm = with_fix(keywords, model_of(model));
  const Recordings train = recordings_of(recordings), held_out = recordings_of(test);
  DiagnosisOptions o;
  o.identification = read_identification(keywords, progress, o.identification);
  keywords.expect_all_taken();
  return interruptible(progress, [=] {
    const auto found = std::make_shared<FrictionStudy>(study_friction(arm, train, held_out, o));
    return std::make_shared<Study>(
        Study{to_json(*found), found->reason.empty() ? found->report() : found->reason,
              [found, arm](const std::string& call) { return to_page(*found, call, &arm); }, found->fitted.model});
  });
}

// ---- kinematics ----

MatrixXd rows_of(const py::object& given) {
  const auto array = py::array_t<double, py::array::c_style | py::array::forcecast>(given);
  require(array.ndim() == 1 || array.ndim() == 2, "kinematics: found an array of ", array.ndim(), " dimensions, expected one or two.");
  const auto cols = static_cast<Eigen::Index>(array.shape(array.ndim() - 1));
  const auto rows = array.ndim() == 1 ? 1 : static_cast<Eigen::Index>(array.shape(0));
  return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(array.data(), rows, cols);
}

InverseTask task_of(const MatrixXd& poses) {
  require(poses.cols() == 3 || poses.cols() == 7, "kinematics: found poses of ", poses.cols(),
          " numbers, expected x, y, z or x, y, z, qw, qx, qy, qz.");
  InverseTask task;
  task.has_orientation = poses.cols() == 7;
  for (Eigen::Index k = 0; k < poses.rows(); ++k) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = poses.row(k).head<3>().transpose();
    if (task.has_orientation) {
      const Eigen::Quaterniond q(poses(k, 3), poses(k, 4), poses(k, 5), poses(k, 6));
      require(q.norm() > 1e-6, "kinematics: found a quaternion of length zero in pose ", k, ".");
      pose.linear() = q.normalized().toRotationMatrix();
    }
    task.poses.push_back(pose);
  }
  return task;
}

SharedStudy kinematics_call(const py::object& model, const py::dict& words) {
  Keywords keywords("kinematics", words);
  const Model arm = model_of(model);
  std::string frame;
  int workspace = 1000;
  std::vector<double> start;
  const py::object forward = keywords.value_of("forward"), inverse = keywords.value_of("inverse");
  require(!forward || !inverse, "kinematics: found forward and inverse, expected one of them.");
  keywords.read("workspace", workspace);
  keywords.read("frame", frame);
  keywords.read("start", start);
  keywords.expect_all_taken();
  if (frame.empty()) {
    frame = arm.frames().back().name;
    for (const char* known : {"tool", "tip"})
      if (arm.find_frame(known)) frame = known;
  }
  require(arm.find_frame(frame).has_value(), "kinematics: found the frame '", frame, "', which '", arm.name(), "' does not have.");
  const MatrixXd given = forward ? rows_of(forward) : inverse ? rows_of(inverse) : MatrixXd();
  require(!forward || given.cols() == arm.joints(), "kinematics: found ", given.cols(), " joints, expected the ", arm.joints(), " of ",
          arm.name(), ".");
  require(start.empty() || static_cast<int>(start.size()) == arm.joints(), "kinematics: found a start of ", start.size(),
          " joints, expected the ", arm.joints(), " of ", arm.name(), ".");
  const bool has_forward = bool(forward), has_inverse = bool(inverse);
  return interruptible(Progress(py::none()), [=] {
    InverseTask task = has_inverse ? task_of(given) : InverseTask();
    task.start = Eigen::Map<const VectorXd>(start.data(), static_cast<Eigen::Index>(start.size()));
    const KinematicTable table = has_forward   ? forward_kinematics(arm, frame, given)
                                 : has_inverse ? inverse_kinematics(arm, frame, task)
                                               : sample_workspace(arm, frame, workspace);
    return std::make_shared<Study>(
        Study{to_json(table), table.report(), [table, arm](const std::string& call) { return to_page(table, arm, call); }});
  });
}

// A function of a package that the module was built without.
[[maybe_unused]] void bind_absent(py::module_& m, const char* name, const std::string& package) {
  m.def(name, [name, package](const py::args&, const py::kwargs&) {
    throw py::import_error(std::string(name) + " needs the package " + package + ", which this module was built without.");
  });
}

}  // namespace

void bind_studies(py::module_& m) {
  py::class_<Study, SharedStudy>(m, "NativeStudy")
      .def("json", [](const Study& s) { return s.json; })
      .def("report", [](const Study& s) { return s.report; })
      .def("page", [](const Study& s, const std::string& call) { return s.page(call); }, py::arg("call"),
           py::call_guard<py::gil_scoped_release>())
      .def("save",
           [](const Study& s, const std::string& path, const std::string&) {
             require(s.model.has_value(), path, ": there is no model to save.");
             save_model(*s.model, path);
           },
           py::arg("path"), py::arg("command"))
      .def_property_readonly("model", [](const Study& s) -> py::object {
        if (!s.model) return py::none();
        return py::cast(std::make_shared<SharedModel>(*s.model));
      });
#ifdef VERIDYN_WITH_CALIBRATION
  bind_calibration(m);
#else
  for (const char* name : {"calibrate_links", "calibrate_axis", "calibrate_rcm", "calibrate_handeye"}) bind_absent(m, name, "calibration");
#endif
#ifdef VERIDYN_WITH_COOPERATION
  bind_stability(m);
#else
  bind_absent(m, "stability", "cooperation");
#endif
  m.def("fleet", &fleet_call);
  m.def("friction", &friction_call);
  m.def("kinematics", &kinematics_call);
}

}  // namespace veridyn::python
