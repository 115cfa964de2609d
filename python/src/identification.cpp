#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <sstream>

#include "bindings.hpp"
#include "model_handle.hpp"
#include "options.hpp"
#include "veridyn/diagnosis/model_comparison.hpp"
#include "veridyn/diagnosis/payload.hpp"
#include "effects/effect_names.hpp"
#include "veridyn/identification/joint_score.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/report/comparison_json.hpp"
#include "veridyn/report/diagnosis_json.hpp"
#include "veridyn/report/pages.hpp"
#include "veridyn/report/json.hpp"
#include "veridyn/report/payload_json.hpp"

namespace veridyn::python {
namespace {

py::object model_or_none(const std::optional<Model>& model) {
  if (!model) return py::none();
  return py::cast(std::make_shared<SharedModel>(*model));
}

// A result with what is shown of it, made without the GIL.
template <typename Result>
void bind_result(py::class_<Result, std::shared_ptr<Result>>& type) {
  type.def("json", [](const Result& result) { return to_json(result); },
           py::call_guard<py::gil_scoped_release>());
  type.def("report", [](const Result& result) { return result.report(); },
           py::call_guard<py::gil_scoped_release>());
}

template <typename Result>
void bind_page(py::class_<Result, std::shared_ptr<Result>>& type) {
  type.def("page",
           [](const Result& result, const std::string& call) { return to_page(result, call); },
           py::arg("call"), py::call_guard<py::gil_scoped_release>());
}

// Torques of one recording, held-out ones first, as they are plotted.
py::dict series_of(const Identification& id, std::size_t recording) {
  std::vector<const RecordingError*> all;
  for (const auto* list : {&id.test, &id.train})
    for (const RecordingError& one : *list) all.push_back(&one);
  require(recording < all.size(), "series: found recording ", recording, ", expected one of ",
          all.size(), ", counted from 0.");
  const PredictionSeries& s = all[recording]->series;
  std::vector<std::string> joints;
  if (id.model)
    for (const Coordinate& c : id.model->coordinates()) joints.push_back(c.name);
  py::dict out;
  out["source"] = all[recording]->source;
  out["joints"] = joints;
  out["time"] = s.time;
  out["measured"] = s.measured;
  out["modelled"] = s.modelled;
  return out;
}

// Common arguments of the functions here: the model, the recordings, keywords and a progress callback.
struct Call {
  Call(const char* function, const py::object& model, const py::object& train_,
       const py::object& test_, const py::dict& words)
      : keywords(function, words),
        progress(callback(keywords)),
        arm(with_fix(keywords, model_of(model))),
        train(recordings_of(train_)),
        test(recordings_of(test_)) {}

  static py::object callback(Keywords& keywords) {
    const py::object given = keywords.value_of("progress");
    return given ? given : py::none();
  }

  Keywords keywords;
  Progress progress;
  Model arm;
  Recordings train, test;
};

std::shared_ptr<Identification> identify_call(const py::object& model, const py::object& train,
                                              const py::object& test, const py::dict& words) {
  Call call("identify", model, train, test, words);
  const IdentificationOptions options = read_identification(call.keywords, call.progress);
  call.keywords.expect_all_taken();
  return interruptible(call.progress, [arm = call.arm, train = call.train, test = call.test,
                                       options] {
    return std::make_shared<Identification>(identify(arm, train, test, options));
  });
}

std::shared_ptr<Identification> evaluate_call(const py::object& model, const py::object& train,
                                              const py::object& test, const py::dict& words) {
  Call call("evaluate", model, train, test, words);
  const IdentificationOptions options = read_identification(call.keywords, call.progress);
  call.keywords.expect_all_taken();
  return interruptible(call.progress, [arm = call.arm, train = call.train, test = call.test,
                                       options] {
    return std::make_shared<Identification>(evaluate(arm, train, test, options));
  });
}

DiagnosisOptions read_diagnosis(Keywords& keywords, const Progress& progress) {
  DiagnosisOptions options;
  keywords.read("effects", options.effects);
  keywords.read("max_effects", options.max_effects);
  RobotValues values = RobotValues::kPrior;
  if (keywords.given("values")) {
    keywords.read_choice("values", values, {RobotValues::kFacts, RobotValues::kPrior},
                         [](RobotValues v) { return name_of(v); });
    options.values = values;
  }
  options.identification = read_identification(keywords, progress, options.identification);
  keywords.expect_all_taken();
  return options;
}

std::shared_ptr<Diagnosis> diagnose_fit_call(const std::shared_ptr<Identification>& fit, const py::object& test,
                                             const py::dict& words) {
  Keywords keywords("diagnose", words);
  const Progress progress(Call::callback(keywords));
  const DiagnosisOptions options = read_diagnosis(keywords, progress);
  return interruptible(progress, [fit, test = recordings_of(test), options] {
    return std::make_shared<Diagnosis>(diagnose(*fit, test, options));
  });
}

std::shared_ptr<Diagnosis> diagnose_call(const py::object& model, const py::object& train,
                                         const py::object& test, const py::dict& words) {
  Call call("diagnose", model, train, test, words);
  const DiagnosisOptions options = read_diagnosis(call.keywords, call.progress);
  return interruptible(call.progress, [arm = call.arm, train = call.train, test = call.test,
                                       options] {
    return std::make_shared<Diagnosis>(diagnose(arm, train, test, options));
  });
}

std::shared_ptr<PayloadReport> payload_call(const py::object& model, const py::object& recordings,
                                            const std::string& link, const py::dict& words) {
  Call call("find_payload", model, recordings, py::none(), words);
  const IdentificationOptions options = read_identification(call.keywords, call.progress);
  call.keywords.expect_all_taken();
  return interruptible(call.progress, [arm = call.arm, train = call.train, options, link] {
    return std::make_shared<PayloadReport>(find_payload(arm, train, options, link));
  });
}

}  // namespace

void bind_identification(py::module_& m) {
  py::class_<Identification, std::shared_ptr<Identification>> id(m, "NativeIdentification");
  bind_result(id);
  bind_page(id);
  id.def("save",
         [](const Identification& r, const std::string& path, const std::string& command) {
           save(r, path, command);
         },
         py::arg("path"), py::arg("command"));
  id.def("series", &series_of, py::arg("recording"));
  id.def_property_readonly("model",
                           [](const Identification& r) { return model_or_none(r.model); });
  py::class_<Diagnosis, std::shared_ptr<Diagnosis>> diagnosis(m, "NativeDiagnosis");
  bind_result(diagnosis);
  bind_page(diagnosis);
  diagnosis.def("save",
                [](const Diagnosis& d, const std::string& path, const std::string& command) {
                  save(d, path, command);
                },
                py::arg("path"), py::arg("command"));
  diagnosis.def_property_readonly(
      "model", [](const Diagnosis& d) { return model_or_none(d.extended.model); });
  py::class_<PayloadReport, std::shared_ptr<PayloadReport>> payload(m, "NativePayload");
  bind_result(payload);
  payload.def_property_readonly("found", &PayloadReport::found);
  py::class_<ModelComparison, std::shared_ptr<ModelComparison>> comparison(m, "NativeComparison");
  bind_result(comparison);
  m.def("identify", &identify_call);
  m.def("evaluate", &evaluate_call);
  m.def("diagnose", &diagnose_call);
  m.def("diagnose_fit", &diagnose_fit_call);
  py::class_<JointScore>(m, "JointScore", "Errors of a model on the torque of one joint, relative to it.")
      .def_property_readonly("joint", [](const JointScore& s) { return s.joint.value + 1; }, "from 1")
      .def_readonly("name", &JointScore::name)
      .def_readonly("error", &JointScore::error)
      .def_readonly("maximum", &JointScore::maximum)
      .def_readonly("moving", &JointScore::moving)
      .def_readonly("floor", &JointScore::floor, "between repeats of the motion; nan where nothing repeats")
      .def("__repr__", [](const JointScore& score) {
        std::ostringstream out;
        out << score;
        return out.str();
      });
  m.def("validate", [](const std::shared_ptr<Identification>& fit, const py::object& recordings) {
    const Recordings list = recordings_of(recordings);
    const py::gil_scoped_release free;
    return validate(*fit, list);
  });
  m.def("find_payload", &payload_call);
  m.def("compare",
        [](const py::object& before, const py::object& after, double significance) {
          const Model first = model_of(before);
          const Model second = model_of(after);
          ComparisonOptions options;
          options.significance = significance;
          const py::gil_scoped_release free;
          return std::make_shared<ModelComparison>(compare(first, second, options));
        },
        py::arg("before"), py::arg("after"), py::arg("significance"));
  m.def("effect_names", [] { return effect_names(); });
}

}  // namespace veridyn::python
