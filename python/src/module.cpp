#include <cctype>
#include <string>

#include "bindings.hpp"
#include "interruptible.hpp"
#include "veridyn/math/require.hpp"

namespace py = pybind11;

namespace {

// Options are called as in Python: --filter-cutoff is filter_cutoff.
std::string in_python(const std::string& message) {
  std::string out;
  for (std::size_t k = 0; k < message.size(); ++k) {
    const bool begins = message.compare(k, 2, "--") == 0 && k + 2 < message.size() &&
                        std::islower(static_cast<unsigned char>(message[k + 2])) != 0 &&
                        (k == 0 || message[k - 1] == ' ' || message[k - 1] == '(');
    if (!begins) {
      out += message[k];
      continue;
    }
    for (k += 2; k < message.size() && (std::islower(static_cast<unsigned char>(message[k])) != 0 || message[k] == '-'); ++k)
      out += message[k] == '-' ? '_' : message[k];
    --k;
  }
  return out;
}

}  // namespace

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
      invalid_input(in_python(error.what()).c_str());
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
  veridyn::python::bind_studies(m);
}
