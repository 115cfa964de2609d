#pragma once

#include <pybind11/pybind11.h>

namespace veridyn::python {

namespace py = pybind11;

// One function for each source file of the module.
void bind_models(pybind11::module_& m);
void bind_exports(pybind11::module_& m);  // after bind_models()
void bind_recordings(pybind11::module_& m);
void bind_dynamics(pybind11::module_& m);
void bind_identification(pybind11::module_& m);
void bind_factors(pybind11::module_& m);
void bind_motion(pybind11::module_& m);
void bind_control(pybind11::module_& m);
void bind_watching(pybind11::module_& m);
void bind_studies(pybind11::module_& m);

}  // namespace veridyn::python
