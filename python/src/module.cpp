#include "bindings.hpp"
#include "interruptible.hpp"
#include "veridyn/math/require.hpp"

namespace py = pybind11;

PYBIND11_MODULE(_veridyn, m) {
  m.doc() = "The compiled part of veridyn; import veridyn instead.";
  m.attr("__version__") = VERIDYN_VERSION;
  static py::exception<veridyn::InvalidInput> invalid_input(m, "InvalidInput", PyExc_ValueError);
  invalid_input.attr("__doc__") =
      "A file or an argument that cannot be used; the message says where, what was found and what "
      "was expected.";
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const veridyn::InvalidInput& error) {
      invalid_input(error.what());
    } catch (const veridyn::Interrupted&) {
      PyErr_SetNone(PyExc_KeyboardInterrupt);
    }
  });
  veridyn::python::bind_models(m);
  veridyn::python::bind_exports(m);
  veridyn::python::bind_recordings(m);
  veridyn::python::bind_dynamics(m);
  veridyn::python::bind_identification(m);
#ifdef VERIDYN_WITH_FACTORS
  veridyn::python::bind_factors(m);
#endif
  veridyn::python::bind_motion(m);
  veridyn::python::bind_control(m);
  veridyn::python::bind_watching(m);
}
