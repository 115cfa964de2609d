#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <array>
#include <limits>

#include "bindings.hpp"
#include "math/numbers.hpp"
#include "model_handle.hpp"
#include "options.hpp"
#include "veridyn/excitation/excitation.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/report/pages.hpp"
#include "veridyn/report/motion_json.hpp"
#include "veridyn/simulation/plausible_model.hpp"
#include "veridyn/simulation/resampled_motion.hpp"
#include "simulation/rotors_at_zero.hpp"
#include "veridyn/simulation/simulate_controlled.hpp"
#include "veridyn/simulation/simulate_recording.hpp"

namespace veridyn::python {
namespace {

std::shared_ptr<Recording> recording_of(const MotionSamples& motion, const MatrixXd& tau,
                                        const std::string& source) {
  auto out = std::make_shared<Recording>();
  out->source = source;
  out->time = motion.time;
  out->q = motion.q;
  out->dq = motion.dq;
  out->tau = tau;
  return out;
}

// What a simulation shows in Python.
struct Simulated {
  std::shared_ptr<Recording> recording, actual;
  Model truth;
  std::string json;
};

// Plausible values say how an arm behaves, and nothing about how strong it must be.
Model without_efforts(const Model& arm) {
  ModelDescription d = arm.description();
  for (Coordinate& c : d.coordinates) c.limits.effort = std::numeric_limits<double>::infinity();
  return Model(std::move(d));
}

void read_between(const py::object& given, const Model& arm, ExcitationOptions& o) {
  const auto both = given.cast<std::pair<std::string, std::string>>();
  o.between = {parse_cause(arm, both.first), parse_cause(arm, both.second)};
  o.criterion = ExcitationCriterion::kDiscriminate;
}

Obstacle obstacle_of(const std::array<double, 6>& b) {
  return {"box", {b[0], b[2], b[4]}, {b[1], b[3], b[5]}};
}

// Links keep apart where their shapes are known: of a URDF file, or along lines of a given radius.
CollisionLimits read_collisions(Keywords& keywords, const py::object& robot, const Model& arm) {
  bool collisions = true;
  double radius = 0.0, clearance = kLinkClearance;
  std::string shapes;
  std::vector<std::array<double, 6>> keep_out;
  std::optional<double> floor;
  keywords.read("collisions", collisions);
  keywords.read("link_radius", radius);
  keywords.read("clearance", clearance);
  keywords.read("shapes", shapes);
  keywords.read("keep_out", keep_out);
  if (keywords.given("floor")) keywords.read("floor", floor.emplace());
  if (!collisions) return {};
  const bool is_path = py::isinstance<py::str>(robot) || py::hasattr(robot, "__fspath__");
  if (shapes.empty() && is_path) shapes = py::str(robot).cast<std::string>();
  const bool urdf = shapes.size() > 5 && shapes.compare(shapes.size() - 5, 5, ".urdf") == 0;
  std::vector<std::string> remarks;
  const std::vector<Capsule> capsules = radius > 0.0 ? capsules_along_links(arm, radius)
                                        : urdf       ? collision_capsules(shapes, remarks)
                                                     : std::vector<Capsule>();
  for (const std::string& remark : remarks) PyErr_WarnEx(PyExc_UserWarning, remark.c_str(), 1);
  std::vector<Obstacle> around;
  if (floor) around.push_back({"floor", {-kInfinity, -kInfinity, -kInfinity}, {kInfinity, kInfinity, *floor}});
  for (const auto& box : keep_out) around.push_back(obstacle_of(box));
  require(!capsules.empty() || around.empty(), "excite: the links of '", arm.name(),
          "' have no shapes; expected link_radius=, or shapes= with a URDF file.");
  return collision_limits(arm, capsules, around, clearance);
}

std::shared_ptr<Excitation> excite_call(const py::object& model, const py::dict& words) {
  Keywords keywords("excite", words);
  const py::object callback = keywords.value_of("progress");
  const Progress progress(callback ? callback : py::none());
  const Model arm = model_of(model);
  ExcitationOptions o;
  keywords.read("frequency", o.frequency);
  keywords.read("harmonics", o.harmonics);
  keywords.read("duration", o.duration);
  keywords.read("rate", o.rate);
  keywords.read("slow_passes", o.slow_passes);
  const std::vector<ExcitationCriterion> criteria = {
      ExcitationCriterion::kCondition, ExcitationCriterion::kDOptimal,
      ExcitationCriterion::kAOptimal, ExcitationCriterion::kDiscriminate};
  keywords.read_choice("criterion", o.criterion, criteria,
                       [](ExcitationCriterion c) { return name_of(c); });
  const py::object between = keywords.value_of("between");
  keywords.read("essential", o.essential);
  keywords.read("starts", o.starts);
  keywords.read("iterations", o.iterations);
  if (keywords.given("limit_share")) keywords.read("limit_share", o.limit_share.emplace());
  keywords.read_choice("friction", o.friction,
                       {JointFriction::kAuto, JointFriction::kPlain, JointFriction::kFile},
                       [](JointFriction f) { return name_of(f); });
  keywords.read("seed", o.seed);
  keywords.read("threads", o.threads);
  if (const py::object powered = keywords.value_of("model")) o.powered = model_of(powered);
  if (between) read_between(between, o.powered.value_or(arm), o);
  if (const py::object identified = keywords.value_of("noise_of")) {
    const Model left = model_of(identified);
    require(left.description().identified && left.description().identified->noise.size() == arm.joints(),
            "excite: noise_of= is '", left.name(), "', expected an identified model of ", arm.name(), ".");
    o.noise = usual_noise(left);
  }
  o.workspace.collisions = read_collisions(keywords, model, arm);
  keywords.expect_all_taken();
  if (!o.powered && !arm.inertial_values())
    o.valued = plausible_model(with_friction(arm, o.friction), 1).arm;
  if (o.criterion == ExcitationCriterion::kDiscriminate && !o.powered && o.valued)
    o.powered = without_efforts(*o.valued);
  o.progress = [progress](const std::string& what, double share) { progress(what, share); };
  o.stop = [progress] { return progress.stopped(); };
  return interruptible(progress, [arm, o] {
    return std::make_shared<Excitation>(optimise_excitation(arm, o));
  });
}

MotionSamples motion_of(const py::object& given) {
  const Recordings one = recordings_of(given);
  RecordingsInMemory memory;
  const std::vector<std::string> names = one.register_in(memory);
  require(names.size() == 1, "simulate: found ", names.size(), " motions, expected one.");
  const Recording* there = find_in_memory(memory, names.front());
  const Recording rows = there != nullptr ? *there : read_recording(names.front());
  return with_derivatives({rows.time, rows.q, rows.dq, rows.ddq});
}

std::shared_ptr<Simulated> led_by_pid(const Model& arm, const MotionSamples& wanted,
                                      const SimulationOptions& options, const std::string& engine) {
  const ControlledRecording done =
      simulate_controlled(with_movable_rotors(arm).arm, wanted, {options, {}, engine});
  require(done.run.complete(), "simulate: the run ", done.run.stop_reason(arm));
  const SimulatedRecording& r = done.recording;
  return std::make_shared<Simulated>(
      Simulated{recording_of(r.measured, r.tau, "simulated " + arm.name()),
                recording_of(r.actual, r.actual_tau, "actual " + arm.name()), r.truth,
                to_json(done, wanted)});
}

std::shared_ptr<Simulated> simulate_call(const py::object& model, const py::object& motion,
                                         const py::dict& words) {
  Keywords keywords("simulate", words);
  Model arm = model_of(model);
  SimulationOptions o;
  std::vector<std::string> effects;
  std::string noise = "low", engine = "veridyn", controller = "none", name;
  unsigned arm_seed = 1;
  double rate = 0.0;
  if (const py::object given = keywords.value_of("effects")) {
    effects = py::isinstance<py::str>(given)
                  ? std::vector<std::string>{given.cast<std::string>()}
                  : given.cast<std::vector<std::string>>();
  }
  keywords.read("noise", noise);
  keywords.read("engine", engine);
  keywords.read("controller", controller);
  keywords.read("seed", o.seed);
  keywords.read("arm_seed", arm_seed);
  keywords.read("sample_rate", rate);
  keywords.expect_all_taken();
  require(controller == "none" || controller == "pid", "simulate: controller is '", controller,
          "', expected none or pid.");
  o.noise = sensor_noise(noise);
  for (const std::string& asked : effects) {
    if (asked != "none") o.hidden.push_back(parse_hidden_effect(asked));
  }
  MotionSamples wanted = motion_of(motion);
  require(wanted.q.cols() == arm.joints(), "simulate: the motion has ", wanted.q.cols(),
          " joints, expected the ", arm.joints(), " of ", arm.name(), ".");
  return interruptible(Progress(py::none()), [=]() mutable {
    arm = plausible_model(arm, arm_seed).arm;
    if (rate > 0.0) wanted = resampled(wanted, rate);
    if (controller == "pid") return led_by_pid(arm, wanted, o, engine);
    const SimulatedRecording r = simulate_recording(arm, wanted, o);
    return std::make_shared<Simulated>(
        Simulated{recording_of(r.measured, r.tau, "simulated " + arm.name()),
                  recording_of(r.actual, r.actual_tau, "actual " + arm.name()), r.truth,
                  to_json(r)});
  });
}

}  // namespace

void bind_motion(py::module_& m) {
  py::class_<Excitation, std::shared_ptr<Excitation>>(m, "NativeExcitation")
      .def("json", [](const Excitation& e) { return to_json(e); })
      .def("report", [](const Excitation& e) { return e.report(); })
      .def("page", [](const Excitation& e, const std::string& call) { return to_page(e, call); },
           py::arg("call"))
      .def_property_readonly("interrupted", [](const Excitation& e) { return e.interrupted; })
      .def_property_readonly("motion", [](const Excitation& e) {
        auto out = recording_of(e.motion, MatrixXd(), "motion of " + e.robot);
        out->ddq = e.motion.ddq;
        return out;
      });
  py::class_<Simulated, std::shared_ptr<Simulated>>(m, "NativeSimulation")
      .def("json", [](const Simulated& s) { return s.json; })
      .def_property_readonly("recording", [](const Simulated& s) { return s.recording; })
      .def_property_readonly("actual", [](const Simulated& s) { return s.actual; })
      .def_property_readonly(
          "truth", [](const Simulated& s) { return std::make_shared<SharedModel>(s.truth); });
  m.def("excite", &excite_call);
  m.def("simulate", &simulate_call);
}

}  // namespace veridyn::python
