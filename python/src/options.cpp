#include "options.hpp"

#include <pybind11/stl.h>

#include <limits>
#include <sstream>

#include "recordings/signals/units.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/fixed_coordinates.hpp"
#include "veridyn/files/model_file.hpp"
#include "model/suggestion.hpp"
#include "veridyn/report/setting_names.hpp"

namespace veridyn::python {
namespace {

bool is_path(const py::handle& given) {
  return py::isinstance<py::str>(given) || py::hasattr(given, "__fspath__");
}

std::string path_of(const py::handle& given) {
  return py::str(py::module_::import("os").attr("fspath")(given));
}

void add(Recordings& out, const py::handle& given) {
  if (is_path(given)) {
    out.add(path_of(given));
  } else if (py::isinstance<Recording>(given)) {
    out.add(given.cast<std::shared_ptr<Recording>>());
  } else if (py::hasattr(given, "recording")) {
    add(out, given.attr("recording"));
  } else if (py::hasattr(given, "motion")) {
    add(out, given.attr("motion"));
  } else if (py::hasattr(given, "columns")) {
    add(out, py::module_::import("veridyn").attr("Recording")(given));
  } else {
    throw py::type_error(text("expected a path, a Recording or a pandas frame, found ",
                              std::string(py::str(py::type::of(given).attr("__name__")))));
  }
}

// (first, end) of rows, end -1 or None: to the end.
void read_rows(Keywords& keywords, const std::string& name, PreprocessingOptions& options) {
  const py::object rows = keywords.value_of(name);
  if (!rows) return;
  const bool pair = py::isinstance<py::sequence>(rows) && py::len(rows) == 2;
  if (!pair) throw py::type_error(text(keywords.function(), ": ", name, " is (first, end)"));
  const auto both = py::reinterpret_borrow<py::sequence>(rows);
  options.first_row = both[0].is_none() ? 0 : both[0].cast<long>();
  const long end = both[1].is_none() ? -1 : both[1].cast<long>();
  if (end >= 0) options.row_count = end - options.first_row;
  require(options.first_row >= 0 && (end < 0 || end > options.first_row), keywords.function(), ": ",
          name, " = (", options.first_row, ", ", end, "), expected 0 <= first < end.");
}

// A dictionary, or "q=deg,t=ms".
std::map<std::string, std::string> words_by_name(Keywords& keywords, const std::string& name) {
  std::map<std::string, std::string> out;
  const py::object given = keywords.value_of(name);
  if (!given) return out;
  if (!py::isinstance<py::str>(given)) {
    try {
      return given.cast<std::map<std::string, std::string>>();
    } catch (const py::cast_error&) {
      throw py::type_error(text(keywords.function(), ": ", name,
                                " is a dictionary of texts, or a text as 'q=deg,t=ms'."));
    }
  }
  std::stringstream list(given.cast<std::string>());
  for (std::string one; std::getline(list, one, ',');) {
    const std::size_t equals = one.find('=');
    require(equals != std::string::npos && equals > 0 && equals + 1 < one.size(),
            keywords.function(), ": ", name, " has '", one, "', expected NAME=VALUE.");
    out[one.substr(0, equals)] = one.substr(equals + 1);
  }
  return out;
}

}  // namespace

Keywords::Keywords(std::string function, const py::dict& given) : function_(std::move(function)) {
  for (const auto& [name, value] : given)
    left_.emplace(py::str(name), py::reinterpret_borrow<py::object>(value));
}

py::object Keywords::value_of(const std::string& name) {
  asked_.push_back(name);
  const auto found = left_.find(name);
  if (found == left_.end()) return {};
  py::object value = found->second;
  left_.erase(found);
  return value.is_none() ? py::object() : value;
}

void Keywords::expect_all_taken() const {
  if (left_.empty()) return;
  const std::string& name = left_.begin()->first;
  throw py::type_error(text(function_, "() has no argument '", name, "'",
                            did_you_mean(name, asked_), "; it has: ", listed(asked_), "."));
}

void Keywords::refuse(const std::string& name, const std::string& found,
                      const std::vector<std::string>& expected) const {
  throw InvalidInput(text(function_, ": ", name, " is '", found, "'", did_you_mean(found, expected),
                          ", expected one of: ", listed(expected), "."));
}

void Keywords::refuse_type(const std::string& name, const py::object& value) const {
  throw py::type_error(text(function_, ": ", name, " is of type ",
                            std::string(py::str(py::type::of(value).attr("__name__"))),
                            ", which does not fit."));
}

Recordings recordings_of(const py::object& given) {
  Recordings out;
  if (given.is_none()) return out;
  const bool several = py::isinstance<py::list>(given) || py::isinstance<py::tuple>(given);
  if (!several) {
    add(out, given);
    return out;
  }
  for (const py::handle one : given) add(out, one);
  return out;
}

Model model_of(const py::object& given) {
  if (is_path(given)) return read_model(path_of(given));
  if (py::isinstance<Model>(given)) return given.cast<Model>();
  if (py::hasattr(given, "model") && py::isinstance<Model>(given.attr("model")))
    return given.attr("model").cast<Model>();
  throw py::type_error(text("expected a Model or the name of its file, found ",
                            std::string(py::str(py::type::of(given).attr("__name__"))), "."));
}

void read_signals(Keywords& keywords, SignalChoice& signals) {
  if (const py::object topics = keywords.value_of("topic")) {
    if (py::isinstance<py::str>(topics)) {
      signals.topics = {topics.cast<std::string>()};
    } else {
      for (const py::handle one : topics) signals.topics.push_back(one.cast<std::string>());
    }
  }
  signals.map = words_by_name(keywords, "map");
  signals.units = words_by_name(keywords, "units");
  recordings::require_known_units(signals);
}

Model with_fix(Keywords& keywords, const Model& arm) {
  std::map<std::string, double> fixed;
  keywords.read("fix", fixed);
  const Model kept = fixed.empty() ? arm : with_fixed(arm, fixed);
  std::vector<double> gains;
  keywords.read("drive_gains", gains);
  return gains.empty() ? kept : with_drive_gains(kept, gains);
}

void read_preprocessing(Keywords& keywords, PreprocessingOptions& o) {
  keywords.read("filter_cutoff", o.cutoff);
  keywords.read("filter_order", o.order);
  keywords.read_choice("filtering", o.filtering, {Filtering::kMatched, Filtering::kSignals},
                       [](Filtering f) { return name_of(f); });
  keywords.read_choice("velocity", o.velocity,
                       {VelocitySource::kRecorded, VelocitySource::kDerived},
                       [](VelocitySource v) { return name_of(v); });
  keywords.read_choice("stale_rows", o.stale_rows, {StaleRows::kFilled, StaleRows::kKept},
                       [](StaleRows s) { return name_of(s); });
  keywords.read("resample", o.rate);
  keywords.read("drop_start", o.drop_start);
  keywords.read("drop_end", o.drop_end);
  keywords.read("min_speed", o.min_speed);
  keywords.read("decimation", o.decimation);
  read_rows(keywords, "rows", o);
  keywords.read("columns", o.columns);
  keywords.read("rate", o.header_rate);
  read_signals(keywords, o.signals);
  require(o.cutoff >= 0.0 && o.order >= 1 && o.order <= 20 && o.drop_start >= 0.0 &&
              o.drop_end >= 0.0 && o.rate >= 0.0 && o.min_speed >= 0.0 && o.decimation >= 0,
          keywords.function(), ": found a number below zero (or filter_order beyond 1 to 20).");
}

IdentificationOptions read_identification(Keywords& keywords, const Progress& progress,
                                          IdentificationOptions o) {
  keywords.read_choice("method", o.method, {Method::kOls, Method::kWls, Method::kFeasible, Method::kIv, Method::kDidim},
                       [](Method m) { return name_of(m); });
  keywords.read_choice("weights", o.weights, {JointWeights::kRange, JointWeights::kResidual},
                       [](JointWeights w) { return name_of(w); });
  keywords.read_choice("condition", o.condition,
                       {PhysicalCondition::kPseudoInertia, PhysicalCondition::kPrincipalMoments},
                       [](PhysicalCondition c) { return name_of(c); });
  keywords.read_choice("signs", o.signs, {EffectSigns::kPhysical, EffectSigns::kAny},
                       [](EffectSigns s) { return name_of(s); });
  keywords.read_choice("friction", o.friction,
                       {JointFriction::kAuto, JointFriction::kPlain, JointFriction::kFile},
                       [](JointFriction f) { return name_of(f); });
  if (const py::object prior = keywords.value_of("prior")) o.prior = model_of(prior);
  if (const py::object masses = keywords.value_of("known_mass")) {
    const bool one = py::isinstance<py::str>(masses);
    for (const std::string& asked : one ? std::vector<std::string>{masses.cast<std::string>()}
                                        : masses.cast<std::vector<std::string>>())
      o.known_masses.push_back(parse_known_mass(asked));
  }
  keywords.read("threads", o.threads);
  o.choose_velocities = o.choose_velocities && !keywords.given("velocity");
  read_preprocessing(keywords, o.preprocessing);
  PreprocessingOptions test = o.preprocessing;
  read_rows(keywords, "test_rows", test);
  if (test.first_row != o.preprocessing.first_row || test.row_count != o.preprocessing.row_count)
    o.test_preprocessing = test;
  for (PreprocessingOptions* how :
       {&o.preprocessing, o.test_preprocessing ? &*o.test_preprocessing : nullptr}) {
    if (how != nullptr) how->interrupted = [progress] { return progress.stopped(); };
  }
  o.progress = [progress](const std::string& what, double share) { progress(what, share); };
  return o;
}

}  // namespace veridyn::python
