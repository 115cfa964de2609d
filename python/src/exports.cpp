#include <pybind11/stl.h>

#include "bindings.hpp"
#include "model_handle.hpp"
#include "options.hpp"
#include "veridyn/files/c_code.hpp"
#include "veridyn/files/mjcf.hpp"
#include "veridyn/files/model_json.hpp"
#include "veridyn/identification/portable_model.hpp"
#include "veridyn/files/sdf.hpp"
#include "veridyn/files/simulation_file.hpp"
#include "veridyn/files/urdf.hpp"

namespace veridyn::python {
namespace {

const char* const kExport =
    "As a string. Torques determine combinations of masses: an identified model's single values are "
    "chosen near `prior` (a Model of the same frames) or near small rods, no torque changed. `into`: a simulation's file of "
    "this format whose values are replaced while all else of it stays.";

std::optional<Model> model_or_nothing(const py::object& given) {
  if (given.is_none()) return std::nullopt;
  return model_of(given);
}

}  // namespace

// Methods of the class that bind_models() makes.
void bind_exports(py::module_& m) {
  py::class_<SharedModel, Model, std::shared_ptr<SharedModel>>(m.attr("Model"))
      .def("to_json", [](const Model& arm) { return model_json(arm); },
           "The robot file as JSON, which read_model() reads, too.")
      .def("to_urdf",
           [](const Model& arm, const py::object& prior, const std::string& meshes_from) {
             const ExportedModel out = exported_model(arm, model_or_nothing(prior), meshes_from);
             return to_urdf(out.arm, out.extras);
           },
           py::arg("prior") = py::none(), py::arg("meshes_from") = "", kExport)
      .def("to_mjcf",
           [](const Model& arm, const py::object& prior, const std::string& into) {
             const ExportedModel out = exported_model(arm, model_or_nothing(prior), {},
                                                      into.empty() ? RotorPlace::kArmatures : RotorPlace::kBodies);
             return into.empty() ? to_mjcf(out.arm, out.extras.remarks) : updated_mjcf(out.arm, into).xml;
           },
           py::arg("prior") = py::none(), py::arg("into") = "", kExport)
      .def("to_sdf",
           [](const Model& arm, const py::object& prior, const std::string& meshes_from, const std::string& into) {
             const ExportedModel out = exported_model(arm, model_or_nothing(prior), meshes_from);
             return into.empty() ? to_sdf(out.arm, out.extras) : updated_sdf(out.arm, into).xml;
           },
           py::arg("prior") = py::none(), py::arg("meshes_from") = "", py::arg("into") = "", kExport)
      .def("to_c_code", [](const Model& arm) { return to_c_code(arm); },
           "One file of C and C++: inverse dynamics, regressor, friction. No dependencies.");
}

}  // namespace veridyn::python
