#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include "bindings.hpp"
#include "model_handle.hpp"
#include "options.hpp"
#include "veridyn/regressor/standard_parameters.hpp"
#include "veridyn/kinematics/kinematics.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/fixed_coordinates.hpp"
#include "veridyn/files/model_file.hpp"
#include "model/suggestion.hpp"
#include "veridyn/files/urdf.hpp"
#include "veridyn/report/json.hpp"
#include "veridyn/simulation/plausible_model.hpp"

namespace veridyn::python {
namespace {

using Shared = std::shared_ptr<SharedModel>;

Shared shared(Model arm) {
  return std::make_shared<SharedModel>(std::move(arm));
}

FrameIndex frame_of(const Model& arm, const std::string& name) {
  std::vector<std::string> names;
  for (const Frame& frame : arm.frames()) names.push_back(frame.name);
  const std::optional<FrameIndex> found = arm.find_frame(name);
  require(found.has_value(), "found the frame '", name, "'", did_you_mean(name, names),
          ", expected one of: ", listed(names), ".");
  return *found;
}

py::dict coordinate(const Coordinate& c) {
  py::dict out;
  out["name"] = c.name;
  out["prismatic"] = c.prismatic;
  out["unit"] = position_unit(c);
  out["effort_unit"] = effort_unit(c);
  out["lower"] = c.limits.lower;
  out["upper"] = c.limits.upper;
  out["velocity"] = c.limits.velocity;
  out["acceleration"] = c.limits.acceleration;
  out["effort"] = c.limits.effort;
  out["drive_gain"] = c.drive_gain;
  return out;
}

py::list coordinates(const Model& arm) {
  py::list out;
  for (const Coordinate& c : arm.coordinates()) out.append(coordinate(c));
  return out;
}

py::list frames(const Model& arm) {
  py::list out;
  for (const Frame& frame : arm.frames()) out.append(frame.name);
  return out;
}

py::list effects(const Model& arm) {
  py::list out;
  for (const EffectTerm& term : arm.effects()) {
    py::dict one;
    one["effect"] = term.effect;
    one["axis"] = term.axis.coefficients;
    one["values"] = term.values;
    one["std"] = term.deviations;
    out.append(one);
  }
  return out;
}

// Values of all standard parameters; NaN where the file has none.
VectorXd parameters(const Model& arm) {
  const std::vector<StandardParameter> all = standard_parameters(arm);
  VectorXd out(all.size());
  const bool bodies = arm.inertial_values().has_value();
  for (size_t j = 0; j < all.size(); ++j) {
    const bool known = all[j].body
                           ? bodies || arm.frames()[arm.bodies()[*all[j].body].value].body->phi
                           : !arm.effects()[*all[j].effect].values.empty();
    out[static_cast<Eigen::Index>(j)] =
        known ? all[j].value : std::numeric_limits<double>::quiet_NaN();
  }
  return out;
}

}  // namespace

void bind_models(py::module_& m) {
  const py::class_<Model, std::shared_ptr<Model>> base(m, "BaseModel");
  py::class_<SharedModel, Model, Shared>(m, "Model",
                                         R"(An arm: frames, bodies and effects. It never changes.

Model(name) reads a YAML, JSON, URDF, MJCF or SDF file, or a robot that comes with veridyn by its bare name.
Shapes below: n coordinates, b bodies, p standard parameters.)")
      .def(py::init([](const py::object& given) { return shared(model_of(given)); }),
           py::arg("name"))
      .def_property_readonly("name", [](const Model& arm) { return arm.name(); })
      .def_property_readonly("joints", &Model::joints, "n, the number of coordinates")
      .def_property_readonly("bodies",
                             [](const Model& arm) {
                               std::vector<std::string> out;
                               for (const auto [k] : arm.bodies())
                                 out.push_back(arm.frames()[k].name);
                               return out;
                             },
                             "names of the frames that carry a body, in the order of `phi`")
      .def_property_readonly("coordinates", &coordinates,
                             "one dictionary per coordinate: name, units, limits, drive_gain")
      .def_property_readonly("frames", &frames, "names of all frames, parents first")
      .def_property_readonly("effects", &effects, "one dictionary per effect")
      .def_property_readonly("gravity", [](const Model& arm) { return arm.gravity(); },
                             "(3) in the world [m/s^2]")
      .def_property_readonly("phi", [](const Model& arm) { return arm.inertial_values(); },
                             "(10 b) m, m c (3), L (6: xx, xy, yy, xz, yz, zz about the frame's "
                             "origin) of every body, or None where one has no values")
      .def_property_readonly("parameter_names",
                             [](const Model& arm) {
                               return parameter_names(standard_parameters(arm));
                             },
                             "(p) names of all standard parameters, bodies first")
      .def_property_readonly("parameters", &parameters,
                             "(p) their values; NaN where the file has none")
      .def("with_parameters",
           [](const Model& arm, const VectorXd& values) {
             const auto p = static_cast<Eigen::Index>(standard_parameters(arm).size());
             require(values.size() == p, "with_parameters: found ", values.size(),
                     " values, expected ", p, ".");
             const double none = std::numeric_limits<double>::quiet_NaN();
             return shared(with_values(arm, values, VectorXd::Constant(p, none)));
           },
           py::arg("values"), "The same arm with other values of its standard parameters, (p).")
      .def("with_fixed",
           [](const Model& arm, const std::map<std::string, double>& positions) {
             return shared(with_fixed(arm, positions));
           },
           py::arg("positions"),
           "The arm with some joints where they are, {joint: position} [rad], [m]; without them.")
      .def("with_plausible_values",
           [](const Model& arm, unsigned seed) { return shared(plausible_model(arm, seed).arm); },
           py::arg("seed") = 1,
           "The same arm, with values that could be those of a real one where it has none.")
      .def("frame_pose",
           [](const Model& arm, const VectorXd& q, const std::string& frame) {
             return frame_pose(arm, q, frame_of(arm, frame)).matrix();
           },
           py::arg("q"), py::arg("frame"), "(4, 4) pose of a frame in the world, for q (n).")
      .def("frame_jacobian",
           [](const Model& arm, const VectorXd& q, const std::string& frame) {
             return frame_jacobian(arm, q, frame_of(arm, frame));
           },
           py::arg("q"), py::arg("frame"), "(6, n) [v; omega] = J dq, written in the world.")
      .def("info_json", [](const Model& arm) { return to_json(robot_info(arm)); })
      .def("report", [](const Model& arm) { return robot_info(arm).report(); },
           "Coordinates, frames, effects and base parameters as text.")
      .def("to_yaml", [](const Model& arm) { return to_yaml(arm); })
      .def("save", [](const Model& arm, const py::object& path) {
             save_model(arm, py::str(py::module_::import("os").attr("fspath")(path)));
           },
           py::arg("path"), "Writes the model as YAML, whole or not at all.")
      .def("__repr__",
           [](const Model& arm) {
             return text("<veridyn.Model '", arm.name(), "': ", arm.joints(), " joints, ",
                         arm.bodies().size(), " bodies",
                         arm.inertial_values() ? "" : " without values", ">");
           })
      .def(py::pickle([](const Model& arm) { return to_yaml(arm); },
                      [](const std::string& yaml) { return shared(read_yaml(yaml, "pickle")); }));
  m.def("read_model",
        [](const std::string& robot, const std::map<std::string, double>& constants) {
          ModelFileOptions options;
          options.constants = constants;
          return shared(read_model(robot, options));
        },
        py::arg("robot"), py::arg("constants"));
  m.def("read_model_text", [](const std::string& yaml) { return shared(read_yaml(yaml, "text")); });
  m.def("robot_names", &robot_names);
}

}  // namespace veridyn::python
