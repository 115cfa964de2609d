#include "interruptible.hpp"

namespace veridyn::python {

struct Progress::Shared {
  py::object callback;
  PyObject *type = nullptr, *value = nullptr, *trace = nullptr;  // of what it raised

  ~Shared() {
    if (!Py_IsInitialized()) {
      callback.release();
      return;
    }
    const py::gil_scoped_acquire held;
    callback = py::object();
    Py_XDECREF(type);
    Py_XDECREF(value);
    Py_XDECREF(trace);
  }
};

Progress::Progress(const py::object& callback)
    : stop_(std::make_shared<std::atomic<bool>>(false)) {
  if (callback.is_none()) return;
  shared_ = std::make_shared<Shared>();
  shared_->callback = callback;
}

void Progress::operator()(const std::string& what, double share) const {
  if (*stop_) throw Interrupted();
  if (!shared_) return;
  const py::gil_scoped_acquire held;
  try {
    shared_->callback(what, share);
  } catch (py::error_already_set& raised) {
    raised.restore();
    PyErr_Fetch(&shared_->type, &shared_->value, &shared_->trace);
    *stop_ = true;
    throw Interrupted();
  }
}

void Progress::rethrow() const {
  if (!shared_ || shared_->type == nullptr) return;
  PyErr_Restore(std::exchange(shared_->type, nullptr), std::exchange(shared_->value, nullptr),
                std::exchange(shared_->trace, nullptr));
  throw py::error_already_set();
}

namespace detail {

bool wait(const std::function<bool(double)>& ready) {
  constexpr double kBetweenLooks = 0.05;  // [s]
  while (true) {
    bool done = false;
    {
      const py::gil_scoped_release free;
      done = ready(kBetweenLooks);
    }
    if (done) return false;
    if (PyErr_CheckSignals() != 0) return true;
  }
}

}  // namespace detail
}  // namespace veridyn::python
