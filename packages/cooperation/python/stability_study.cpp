#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include "bindings.hpp"
#include "model_handle.hpp"
#include "options.hpp"
#include "report/json/stability_json.hpp"
#include "study.hpp"
#include "veridyn/cooperation/stability.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::python {
namespace {

SharedStudy stability_call(const std::string& path, const py::dict& words) {
  Keywords keywords("stability", words);
  StabilityModelOptions of_model;
  std::map<std::string, double> changes;
  std::vector<std::string> map;
  std::string locus;
  double recommend = 0.0;
  int bounds = 0, threads = 0;
  keywords.read("frame", of_model.frame);
  keywords.read("pose", of_model.pose);
  keywords.read("set", changes);
  keywords.read("map", map);
  keywords.read("locus", locus);
  keywords.read("recommend", recommend);
  keywords.read("bounds", bounds);
  keywords.read("threads", threads);
  keywords.expect_all_taken();
  require(map.empty() || map.size() == 2, "stability: found a map over ", map.size(),
          " parameters, expected two, each as \"NAME=FROM:TO:COUNT\".");
  return interruptible(Progress(py::none()), [=] {
    auto study = std::make_shared<StabilityStudy>();
    study->scenario = read_scenario_or_model(path, of_model);
    for (const auto& [name, value] : changes) study->scenario = with_parameter(study->scenario, name, value);
    const Scenario& s = study->scenario;
    study->analysis = analyse_stability(s);
    if (!map.empty()) study->map = map_stability(s, parse_range(map[0]), parse_range(map[1]), threads);
    if (!locus.empty()) study->locus = root_locus(s, parse_range(locus));
    if (recommend > 0.0) study->recommendation = recommend_gains(s, recommend);
    if (bounds > 0) study->bounds = bound_stability(s, bounds, threads);
    return std::make_shared<Study>(Study{to_json(*study), study->report(), [study](const std::string& call) {
                                           StabilityStudy whole = *study;
                                           if (!whole.steps) whole.steps = step_responses(whole.scenario);
                                           return to_page(whole, call);
                                         }});
  });
}

}  // namespace

void bind_stability(py::module_& m) {
  m.def("stability", &stability_call);
}

}  // namespace veridyn::python
