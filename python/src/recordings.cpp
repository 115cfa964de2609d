#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include "bindings.hpp"
#include "interruptible.hpp"
#include "options.hpp"
#include "veridyn/identification/robot_check.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/recordings/recording_quality.hpp"
#include "veridyn/report/json.hpp"

namespace veridyn::python {
namespace {

using Signals = std::optional<MatrixXd>;

void require_size(const MatrixXd& values, const Recording& r, const char* name) {
  require(values.rows() == r.time.size() && values.cols() == r.q.cols(), "Recording: ", name,
          " is (", values.rows(), ", ", values.cols(), "), expected (", r.time.size(), ", ",
          r.q.cols(), ") as time and q.");
}

Recording from_arrays(const VectorXd& time, const MatrixXd& q, const Signals& dq,
                      const Signals& ddq, const Signals& tau, const Signals& current,
                      const std::string& source) {
  Recording r;
  r.source = source;
  r.time = time;
  r.q = q;
  require_size(r.q, r, "q");
  for (Eigen::Index k = 0; k < time.size(); ++k) {
    require(std::isfinite(time[k]) && (k == 0 || time[k] > time[k - 1]),
            "Recording: time is ", time[k], " in row ", k, ", expected numbers that rise.");
  }
  const auto set_signal = [&r](const Signals& given, MatrixXd& target, const char* name) {
    if (!given) return;
    require_size(*given, r, name);
    target = *given;
  };
  set_signal(dq, r.dq, "dq");
  set_signal(ddq, r.ddq, "ddq");
  set_signal(tau, r.tau, "tau");
  set_signal(current, r.current, "current");
  return r;
}

// A view without a copy where there is such a signal, else None.
template <MatrixXd Recording::*kSignal>
py::object view(py::object self) {
  const MatrixXd& values = self.cast<const Recording&>().*kSignal;
  if (values.size() == 0) return py::none();
  const auto step = static_cast<py::ssize_t>(sizeof(double));
  py::array_t<double> out({values.rows(), values.cols()}, {step, step * values.rows()},
                          values.data(), self);
  out.attr("flags").attr("writeable") = false;
  return std::move(out);
}

py::dict facts_of(const RecordingFacts& facts) {
  py::dict out;
  out["format"] = facts.format;
  out["joints"] = facts.joints;
  py::dict matched;
  for (const JointMatch& match : facts.matched) matched[py::str(match.joint)] = match.recorded;
  out["matched"] = matched;
  py::list topics;
  for (const TopicFacts& topic : facts.topics) {
    py::dict one;
    one["name"] = topic.name;
    one["type"] = topic.type;
    one["messages"] = topic.messages;
    one["rate"] = topic.rate;
    one["joints"] = topic.joints;
    one["used"] = topic.used;
    topics.append(one);
  }
  out["topics"] = topics;
  out["remarks"] = facts.remarks;
  out["start"] = facts.start;
  return out;
}

py::object time_view(py::object self) {
  const VectorXd& time = self.cast<const Recording&>().time;
  py::array_t<double> out(time.size(), time.data(), self);
  out.attr("flags").attr("writeable") = false;
  return std::move(out);
}

// The arm whose joints are looked for, if one is named.
std::optional<Model> robot_of(Keywords& keywords) {
  const py::object robot = keywords.value_of("robot");
  if (robot) return with_fix(keywords, model_of(robot));
  require(!keywords.value_of("fix"), keywords.function(), ": found fix without robot, expected both.");
  return std::nullopt;
}

RecordingOptions reading_options(Keywords& keywords, const std::optional<Model>& robot) {
  RecordingOptions options;
  keywords.read("columns", options.columns);
  keywords.read("rate", options.rate);
  read_signals(keywords, options.signals);
  if (robot) options.signals.joints = joints_of(*robot);
  if (const py::object given = keywords.value_of("rows")) {
    const auto both = given.cast<std::pair<long, std::optional<long>>>();
    options.first_row = both.first;
    if (both.second && *both.second >= 0) options.row_count = *both.second - both.first;
  }
  return options;
}

}  // namespace

void bind_recordings(py::module_& m) {
  py::class_<Recording, std::shared_ptr<Recording>>(m, "NativeRecording")
      .def(py::init(&from_arrays), py::arg("time"), py::arg("q"), py::arg("dq"), py::arg("ddq"),
           py::arg("tau"), py::arg("current"), py::arg("source"))
      .def(py::init<const Recording&>())
      .def_readonly("source", &Recording::source, "file name, for messages")
      .def_property_readonly("rows", &Recording::rows, "N, the number of rows")
      .def_property_readonly("joints", &Recording::joints, "n, the number of joints")
      .def_property_readonly("time", &time_view, "(N) [s], rising")
      .def_property_readonly("q", &view<&Recording::q>, "(N, n) [rad], [m] where prismatic")
      .def_property_readonly("dq", &view<&Recording::dq>, "(N, n) [rad/s], [m/s], or None")
      .def_property_readonly("ddq", &view<&Recording::ddq>, "(N, n) [rad/s^2], [m/s^2], or None")
      .def_property_readonly("tau", &view<&Recording::tau>, "(N, n) [N m], [N], or None")
      .def_property_readonly("current", &view<&Recording::current>, "(N, n) [A], or None")
      .def("write",
           [](const Recording& r, const py::object& path) {
             write_recording(r, py::str(py::module_::import("os").attr("fspath")(path)));
           },
           py::arg("path"), "Writes CSV with a header, whole or not at all.");
  m.def("read_recording", [](const std::string& path, const py::dict& given) {
    Keywords keywords("read_recording", given);
    const RecordingOptions options = reading_options(keywords, robot_of(keywords));
    keywords.expect_all_taken();
    const auto [recording, facts] = interruptible(Progress(py::none()), [path, options] {
      RecordingFacts found;
      auto read = std::make_shared<Recording>(read_recording(path, options, found));
      return std::make_pair(std::move(read), std::move(found));
    });
    return std::make_pair(recording, facts_of(facts));
  });
  m.def("check_json", [](const py::object& given, const py::dict& words) {
    Keywords keywords("check", words);
    const std::optional<Model> robot = robot_of(keywords);
    const RecordingOptions options = reading_options(keywords, robot);
    keywords.expect_all_taken();
    const Recordings recordings = recordings_of(given);
    return interruptible(Progress(py::none()), [recordings, options, robot] {
      RecordingsInMemory memory;
      std::vector<RecordingQuality> seen;
      for (const std::string& name : recordings.register_in(memory)) {
        const Recording* there = find_in_memory(memory, name);
        seen.push_back(there != nullptr ? check_recording(*there) : check_recording(name, options));
        seen.back().file = name;
        if (!robot) continue;
        std::vector<QualityFinding> findings =
            there != nullptr ? check_against(*robot, *there)
                             : check_against(*robot, read_recording(name, options));
        seen.back().findings = merged_findings(std::move(findings), seen.back().findings);
      }
      std::string report;
      for (const RecordingQuality& quality : seen) report += quality.report();
      return std::make_pair(to_json(seen), report);
    });
  });
}

}  // namespace veridyn::python
