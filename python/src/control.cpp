#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <sstream>
#include <variant>

#include "bindings.hpp"
#include "model_handle.hpp"
#include "options.hpp"
#include "veridyn/control/computed_torque.hpp"
#include "veridyn/control/friction_compensation.hpp"
#include "veridyn/control/gravity_compensation.hpp"
#include "veridyn/control/impedance.hpp"
#include "veridyn/control/joint_controller.hpp"
#include "veridyn/control/model_error_observer.hpp"
#include "veridyn/control/momentum_observer.hpp"
#include "veridyn/control/tip_controller.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/simulation/engine.hpp"

namespace veridyn::python {
namespace {

// The loop's code asserts sizes; what comes from Python is checked.
void expect(const VectorXd& v, Eigen::Index n, const char* where, const char* name) {
  require(v.size() == n, where, ": ", name, " has ", v.size(), " entries, expected ", n, ".");
}

VectorXd or_zero(const std::optional<VectorXd>& given, Eigen::Index n, const char* where,
                 const char* name) {
  if (!given) return VectorXd::Zero(n);
  expect(*given, n, where, name);
  return *given;
}

// Three numbers count for x, y, z alone.
Vector6d six(const VectorXd& given, double rest, const char* where, const char* name) {
  require(given.size() == 3 || given.size() == 6, where, ": ", name, " has ", given.size(),
          " entries, expected 3 (position) or 6 (pose).");
  Vector6d out = Vector6d::Constant(rest);
  out.head(given.size()) = given;
  return out;
}

Vector6d six_or_zero(const std::optional<VectorXd>& given, const char* where, const char* name) {
  return given ? six(*given, 0.0, where, name) : Vector6d(Vector6d::Zero());
}

std::unique_ptr<Impedance> make_impedance(const Model& arm, const std::string& frame,
                                          const Eigen::Vector3d& offset, const VectorXd& mass,
                                          const VectorXd& damping, const VectorXd& stiffness,
                                          const std::optional<VectorXd>& posture) {
  ImpedanceGains gains;
  gains.mass = six(mass, 1.0, "Impedance", "mass");
  gains.damping = six(damping, 0.0, "Impedance", "damping");
  gains.stiffness = six(stiffness, 0.0, "Impedance", "stiffness");
  ImpedanceOptions options;
  if (mass.size() == 6) options.rows = TaskRows::kPose;
  if (posture) options.posture = *posture;
  return std::make_unique<Impedance>(arm, Tip{frame, offset}, gains, options);
}

void bind_state(py::module_& m) {
  py::class_<ArmState>(m, "ArmState",
                       "All that controllers ask of an arm at one instant: "
                       "tau = mass_matrix ddq + bias + friction.")
      .def(py::init([](const Model& arm, const std::string& frame, const Eigen::Vector3d& offset) {
             return std::make_unique<ArmState>(arm, Tip{frame, offset});
           }),
           py::arg("model"), py::arg("frame"), py::arg("offset") = Eigen::Vector3d(0, 0, 0),
           "The tip is the point `offset` (3) [m] of a frame.")
      .def("update",
           [](ArmState& state, const VectorXd& q, const VectorXd& dq) {
             expect(q, state.joints(), "ArmState.update", "q");
             expect(dq, state.joints(), "ArmState.update", "dq");
             state.update(q, dq);
           },
           py::arg("q"), py::arg("dq"), "q, dq (n) [rad, rad/s], metres where prismatic.")
      .def_property_readonly("q", [](const ArmState& s) { return s.q(); })
      .def_property_readonly("dq", [](const ArmState& s) { return s.dq(); })
      .def_property_readonly("mass_matrix", [](const ArmState& s) { return s.mass_matrix(); },
                             "(n, n) with rotors")
      .def_property_readonly("bias", [](const ArmState& s) { return s.bias(); },
                             "(n) C dq + g + springs, offsets, cables [N m], [N]")
      .def_property_readonly("position", [](const ArmState& s) { return s.tip().position(); },
                             "(3) of the tip in the world [m]")
      .def_property_readonly("rotation", [](const ArmState& s) { return s.tip().rotation(); },
                             "(3, 3) of the tip's frame in the world")
      .def_property_readonly("jacobian", [](const ArmState& s) { return s.tip().jacobian(); },
                             "(6, n) [v; omega] = J dq")
      .def_property_readonly("left_out", &ArmState::left_out,
                             "effects that no controller takes into account, in words");
}

void bind_laws(py::module_& m) {
  py::class_<ComputedTorque>(m, "ComputedTorque",
                             "tau = M (ddq_d + K_p (q_d - q) + K_d (dq_d - dq)) + bias")
      .def(py::init([](int joints, const VectorXd& p, const VectorXd& d) {
             return std::make_unique<ComputedTorque>(joints, JointGains{p, d});
           }),
           py::arg("joints"), py::arg("p"), py::arg("d"), "p (n) [1/s^2], d (n) [1/s].")
      .def("update",
           [](ComputedTorque& law, const ArmState& arm, const VectorXd& q,
              const std::optional<VectorXd>& dq, const std::optional<VectorXd>& ddq) {
             JointReference wanted(arm.joints());
             expect(q, arm.joints(), "ComputedTorque.update", "q");
             wanted.q = q;
             wanted.dq = or_zero(dq, arm.joints(), "ComputedTorque.update", "dq");
             wanted.ddq = or_zero(ddq, arm.joints(), "ComputedTorque.update", "ddq");
             return VectorXd(law.update(arm, wanted));
           },
           py::arg("state"), py::arg("q"), py::arg("dq") = py::none(),
           py::arg("ddq") = py::none(), "tau (n) for wanted q, dq, ddq (n).")
      .def_property_readonly("acceleration",
                             [](const ComputedTorque& law) { return law.acceleration(); });
  py::class_<Impedance>(m, "Impedance",
                        "The tip obeys M_d (ddx_d - ddx) + K_d (dx_d - dx) + K_p (x_d - x) = h.")
      .def(py::init(&make_impedance), py::arg("model"), py::arg("frame"),
           py::arg("offset") = Eigen::Vector3d(0, 0, 0), py::arg("mass"), py::arg("damping"),
           py::arg("stiffness"), py::arg("posture") = py::none(),
           "mass [kg], damping [N s/m], stiffness [N/m], (3) or (6) each.")
      .def("update",
           [](Impedance& law, const ArmState& arm, const VectorXd& x,
              const std::optional<VectorXd>& dx, const std::optional<VectorXd>& ddx,
              const std::optional<VectorXd>& wrench) {
             const char* const where = "Impedance.update";
             const TaskReference wanted{six(x, 0.0, where, "x"), six_or_zero(dx, where, "dx"),
                                        six_or_zero(ddx, where, "ddx")};
             return VectorXd(law.update(arm, wanted, six_or_zero(wrench, where, "wrench")));
           },
           py::arg("state"), py::arg("x"), py::arg("dx") = py::none(), py::arg("ddx") = py::none(),
           py::arg("wrench") = py::none(),
           "tau (n); x (3) or (6) [m, rad]; wrench that the tip exerts on the world [N, N m].")
      .def_property_readonly("acceleration", [](const Impedance& law) { return law.acceleration(); })
      .def_property_readonly("joint_error", [](const Impedance& law) { return law.joint_error(); });
  py::class_<GravityCompensation>(m, "GravityCompensation", "The torques that hold an arm still.")
      .def(py::init<const Model&>(), py::arg("model"))
      .def("update",
           [](GravityCompensation& hold, const Model& arm, const VectorXd& q) {
             expect(q, arm.joints(), "GravityCompensation.update", "q");
             return VectorXd(hold.update(q));
           },
           py::arg("model"), py::arg("q"));
}

void bind_compensation(py::module_& m) {
  py::class_<FrictionCompensation>(m, "FrictionCompensation",
                                   "Torque against the friction that a model has identified.")
      .def(py::init([](const Model& arm, const std::string& rule, double share) {
             FrictionOptions options;
             const std::map<std::string, FrictionRule> rules = {
                 {"velocity", FrictionRule::kVelocity},
                 {"stick-slip", FrictionRule::kStickSlip},
                 {"presliding", FrictionRule::kPresliding},
                 {"measured", FrictionRule::kMeasured}};
             require(rules.count(rule) == 1, "FrictionCompensation: rule is '", rule,
                     "', expected velocity, stick-slip, presliding or measured.");
             options.rule = rules.at(rule);
             options.share = share;
             return std::make_unique<FrictionCompensation>(arm, options);
           }),
           py::arg("model"), py::arg("rule") = "stick-slip", py::arg("share") = 0.8)
      .def("update",
           [](FrictionCompensation& friction, const ArmState& arm, const VectorXd& dq_wanted,
              const VectorXd& error, double dt) {
             expect(dq_wanted, arm.joints(), "FrictionCompensation.update", "dq_wanted");
             expect(error, arm.joints(), "FrictionCompensation.update", "error");
             return VectorXd(friction.update(arm, dq_wanted, error, dt));
           },
           py::arg("state"), py::arg("dq_wanted"), py::arg("error"), py::arg("dt"),
           "tau (n) to be added; error (n) wanted minus measured position; dt [s].")
      .def("reset", &FrictionCompensation::reset);
  py::class_<ModelErrorObserver>(m, "ModelErrorObserver",
                                 "Integral action within the model: torque that it lacks.")
      .def(py::init([](const VectorXd& limit, double bandwidth) {
             return std::make_unique<ModelErrorObserver>(static_cast<int>(limit.size()),
                                                         ModelErrorOptions{bandwidth, limit});
           }),
           py::arg("limit"), py::arg("bandwidth") = 10.0, "limit (n) [N m], [N]; bandwidth [1/s].")
      .def("update",
           [](ModelErrorObserver& observer, const ArmState& arm, const VectorXd& y, double dt) {
             expect(y, arm.joints(), "ModelErrorObserver.update", "y");
             expect(observer.torque(), arm.joints(), "ModelErrorObserver.update", "limit");
             return VectorXd(observer.update(arm, y, dt));
           },
           py::arg("state"), py::arg("acceleration"), py::arg("dt"), "tau (n) to be added.")
      .def("sent",
           [](ModelErrorObserver& observer, const VectorXd& asked, const VectorXd& sent) {
             expect(asked, static_cast<int>(observer.torque().size()), "ModelErrorObserver.sent", "asked");
             expect(sent, static_cast<int>(observer.torque().size()), "ModelErrorObserver.sent", "sent");
             observer.set_sent_torques(asked, sent);
           },
           py::arg("asked"), py::arg("sent"),
           "Torques (n) asked of the motors and sent to them, after every limit.")
      .def("reset", &ModelErrorObserver::reset);
  py::class_<MomentumObserver>(m, "MomentumObserver",
                               "What touches the arm, without a force sensor.")
      .def(py::init([](const Model& arm, const std::string& frame, const Eigen::Vector3d& offset,
                       double bandwidth) {
             MomentumObserverOptions options;
             options.bandwidth = bandwidth;
             return std::make_unique<MomentumObserver>(arm, Tip{frame, offset}, options);
           }),
           py::arg("model"), py::arg("frame"), py::arg("offset") = Eigen::Vector3d(0, 0, 0),
           py::arg("bandwidth") = 30.0)
      .def("update",
           [](MomentumObserver& touch, const ArmState& arm, const VectorXd& tau,
              const VectorXd& ddq, double dt) {
             expect(tau, arm.joints(), "MomentumObserver.update", "tau");
             expect(ddq, arm.joints(), "MomentumObserver.update", "ddq");
             return VectorXd(touch.update(arm, tau, ddq, dt));
           },
           py::arg("state"), py::arg("tau"), py::arg("ddq"), py::arg("dt"),
           "Residual torque (n); tau (n) of the motors since the last update, ddq (n) wanted.")
      .def("reset", &MomentumObserver::reset)
      .def_property_readonly("contact", &MomentumObserver::contact)
      .def_property_readonly("force", &MomentumObserver::force, "(3) at the tip, in the world [N]")
      .def_property_readonly("threshold", [](const MomentumObserver& o) { return o.threshold(); });
}

using GivenGain = std::variant<double, VectorXd>;

Gain gain(const GivenGain& given) {
  const VectorXd* each = std::get_if<VectorXd>(&given);
  return each != nullptr ? Gain(*each) : Gain(std::get<double>(given));
}

CycleOptions cycle_options(double torque, double friction, double error_bandwidth,
                           const std::optional<GivenGain>& error_limit) {
  CycleOptions out;
  out.torque = torque;
  out.friction.share = friction;
  out.error_bandwidth = error_bandwidth;
  if (error_limit) out.error_limit = gain(*error_limit);
  return out;
}

Measured measured_of(int joints, const VectorXd& q, const std::optional<VectorXd>& dq, const char* where) {
  Measured out(joints);
  expect(q, joints, where, "q");
  out.q = q;
  if (dq) {
    expect(*dq, joints, where, "dq");
    out.dq = *dq;
  }
  return out;
}

// What both controllers have beside update().
template <typename Controller>
void bind_controller(py::class_<Controller>& type) {
  type.def("hold", &Controller::hold, "Brakes and holds the arm; False in a fault.")
      .def("limp", &Controller::limp, "Gravity compensation and a little damping alone.")
      .def("resume", &Controller::resume, "Ends hold() and limp().")
      .def("reset", &Controller::reset, "Clears a fault and all that was observed.")
      .def_property_readonly("fault",
                             [](const Controller& c) -> std::optional<std::string> {
                               if (!c.fault()) return std::nullopt;
                               std::ostringstream out;
                               out << *c.fault();
                               return out.str();
                             },
                             "What, where and when; None without a fault.")
      .def_property_readonly("q", [](const Controller& c) { return c.state().q(); }, "(n) true positions")
      .def_property_readonly("dq", [](const Controller& c) { return c.state().dq(); });
}

void bind_controllers(py::module_& m) {
  py::class_<JointController> joints(m, "JointController", "From encoder positions to torques of the drives, every cycle.");
  joints
      .def(py::init([](const Model& arm, const GivenGain& kp, const GivenGain& kd, const GivenGain& ki,
                       const std::string& law, double torque, double friction, double error_bandwidth,
                       const std::optional<GivenGain>& error_limit) {
             const std::map<std::string, JointLaw> laws = {{"computed-torque", JointLaw::kComputedTorque},
                                                           {"gravity", JointLaw::kGravity},
                                                           {"pid", JointLaw::kPid}};
             require(laws.count(law) == 1, "JointController: law is '", law,
                     "', expected computed-torque, gravity or pid.");
             return std::make_unique<JointController>(
                 arm, JointControllerOptions{gain(kp), gain(kd), gain(ki), laws.at(law),
                                             cycle_options(torque, friction, error_bandwidth, error_limit)});
           }),
           py::arg("model"), py::arg("kp") = 400.0, py::arg("kd") = 40.0, py::arg("ki") = 0.0,
           py::arg("law") = "computed-torque", py::arg("torque") = 0.0, py::arg("friction") = 0.8,
           py::arg("error_bandwidth") = 10.0, py::arg("error_limit") = py::none(),
           "Gains: a number, or one for each joint; torque: limit of drives for which the model gives none.")
      .def("update",
           [](JointController& c, const VectorXd& q, const VectorXd& q_wanted, double dt,
              const std::optional<VectorXd>& dq_wanted, const std::optional<VectorXd>& ddq_wanted,
              const std::optional<VectorXd>& dq) {
             const char* const where = "JointController.update";
             JointReference wanted(c.joints());
             expect(q_wanted, c.joints(), where, "q_wanted");
             wanted.q = q_wanted;
             wanted.dq = or_zero(dq_wanted, c.joints(), where, "dq_wanted");
             wanted.ddq = or_zero(ddq_wanted, c.joints(), where, "ddq_wanted");
             return VectorXd(c.update(measured_of(c.joints(), q, dq, where), wanted, dt));
           },
           py::arg("q"), py::arg("q_wanted"), py::arg("dt"), py::arg("dq_wanted") = py::none(),
           py::arg("ddq_wanted") = py::none(), py::arg("dq") = py::none(),
           "Torques (n) of the drives; q (n) as the encoders show it, dq (n) where it is measured.");
  bind_controller(joints);
  py::class_<TipController> tip(m, "TipController", "Impedance of the tip, from encoder positions to torques of the drives.");
  tip.def(py::init([](const Model& arm, const std::string& frame, const Eigen::Vector3d& offset, const GivenGain& mass,
                      const GivenGain& damping, const GivenGain& stiffness, bool pose, double torque, double friction,
                      double error_bandwidth, const std::optional<GivenGain>& error_limit) {
            TipControllerOptions options{gain(mass), gain(damping), gain(stiffness), {frame, offset}};
            if (pose) options.impedance.rows = TaskRows::kPose;
            options.cycle = cycle_options(torque, friction, error_bandwidth, error_limit);
            return std::make_unique<TipController>(arm, options);
          }),
          py::arg("model"), py::arg("frame") = "", py::arg("offset") = Eigen::Vector3d(0, 0, 0), py::arg("mass") = 2.0,
          py::arg("damping") = 80.0, py::arg("stiffness") = 800.0, py::arg("pose") = false, py::arg("torque") = 0.0,
          py::arg("friction") = 0.8, py::arg("error_bandwidth") = 10.0, py::arg("error_limit") = py::none(),
          "mass [kg], damping [N s/m], stiffness [N/m]: a number, or six; pose: orientation counts, too.")
      .def("update",
           [](TipController& c, const VectorXd& q, const VectorXd& x, double dt, const std::optional<VectorXd>& dx,
              const std::optional<VectorXd>& ddx, const std::optional<VectorXd>& wrench,
              const std::optional<VectorXd>& dq) {
             const char* const where = "TipController.update";
             Measured measured = measured_of(c.joints(), q, dq, where);
             measured.wrench = six_or_zero(wrench, where, "wrench");
             const TaskReference wanted{six(x, 0.0, where, "x"), six_or_zero(dx, where, "dx"),
                                        six_or_zero(ddx, where, "ddx")};
             return VectorXd(c.update(measured, wanted, dt));
           },
           py::arg("q"), py::arg("x"), py::arg("dt"), py::arg("dx") = py::none(), py::arg("ddx") = py::none(),
           py::arg("wrench") = py::none(), py::arg("dq") = py::none(),
           "Torques (n) of the drives; x (3) or (6) wanted [m, rad]; wrench that the tip exerts [N, N m].")
      .def("reference_at", [](const TipController& c, const VectorXd& q) {
             return Vector6d(c.reference_at(measured_of(c.joints(), q, std::nullopt, "TipController.reference_at")).x);
           }, py::arg("q"), "(6) where the tip is at these positions.");
  bind_controller(tip);
}

void bind_engine(py::module_& m) {
  py::class_<Engine, std::shared_ptr<Engine>>(m, "Plant", "Forward dynamics, step by step.")
      .def(py::init([](const Model& arm, const std::string& name) {
             return std::shared_ptr<Engine>(make_engine(name, arm));
           }),
           py::arg("model"), py::arg("name") = "veridyn", "name: veridyn or mujoco.")
      .def("set_state",
           [](Engine& engine, const VectorXd& q, const VectorXd& dq) { engine.set_state(q, dq); },
           py::arg("q"), py::arg("dq"), "q, dq (n); time restarts, friction forgets.")
      .def("step",
           [](Engine& engine, const VectorXd& tau, double dt) {
             expect(tau, engine.joints(), "Engine.step", "tau");
             StepStatus status;
             {
               const py::gil_scoped_release free;
               status = engine.step(tau, dt);
             }
             require(status == StepStatus::kOk, "Engine.step: at ", engine.time(), " s joint ",
                     engine.failed_joint().value_or(JointIndex{-1}).value + 1, " ", describe(status), ".");
           },
           py::arg("tau"), py::arg("dt"), "Moves on by dt [s] under tau (n).")
      .def_property_readonly("time", &Engine::time)
      .def_property_readonly("q", [](const Engine& engine) { return engine.q(); })
      .def_property_readonly("dq", [](const Engine& engine) { return engine.dq(); })
      .def_property_readonly("left_out", &Engine::left_out);
  m.attr("Engine") = m.attr("Plant");  // the name that it had
}

}  // namespace

void bind_control(py::module_& m) {
  bind_state(m);
  bind_laws(m);
  bind_compensation(m);
  bind_controllers(m);
  bind_engine(m);
}

}  // namespace veridyn::python
