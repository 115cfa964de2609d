#include <pybind11/stl.h>

#include "bindings.hpp"
#include "model_handle.hpp"
#include "options.hpp"
#include "veridyn/report/watch_json.hpp"
#include "veridyn/diagnosis/watch.hpp"

namespace veridyn::python {
namespace {

using SharedWatch = std::shared_ptr<Watch>;

// Events as JSON, one each.
std::vector<std::string> lines_of(const std::vector<WatchEvent>& events, const std::string& source) {
  std::vector<std::string> out;
  for (const WatchEvent& event : events) out.push_back(json_line(event, source));
  return out;
}

SharedWatch watch_of(const py::object& model, const py::dict& words) {
  Keywords keywords("watch", words);
  WatchOptions options;
  keywords.read("learn", options.learn);
  keywords.read("false_alarms", options.false_alarms);
  keywords.read("links", options.links);
  options.learn_more = std::max(options.learn_more, options.learn);
  const Model arm = with_fix(keywords, model_of(model));
  keywords.expect_all_taken();
  return std::make_shared<Watch>(arm, options);
}

}  // namespace

void bind_watching(py::module_& m) {
  py::class_<Watch, SharedWatch>(m, "NativeWatch")
      .def("learn", &Watch::learn, py::call_guard<py::gil_scoped_release>())
      .def("add",
           [](Watch& watch, const Recording& rows) { return lines_of(watch.add(rows), rows.source); },
           py::call_guard<py::gil_scoped_release>())
      .def("finish", [](Watch& watch) { return lines_of(watch.finish(), ""); },
           py::call_guard<py::gil_scoped_release>());
  m.def("watch", &watch_of);
}

}  // namespace veridyn::python
