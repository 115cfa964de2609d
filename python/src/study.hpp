#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "bindings.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn::python {

// A result of calibrate, fleet, stability, kinematics or friction: what is shown of it.
struct Study {
  std::string json, report;
  std::function<std::string(const std::string& call)> page;
  std::optional<Model> model{};
};

using SharedStudy = std::shared_ptr<Study>;

// Of packages, where the module is built with them.
void bind_calibration(py::module_& m);
void bind_stability(py::module_& m);

}  // namespace veridyn::python
