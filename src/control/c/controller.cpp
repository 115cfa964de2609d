#include "veridyn/c/controller.h"

#include <cstdio>
#include <exception>

#include "veridyn/control/joint_controller.hpp"
#include "veridyn/files/model_file.hpp"

struct veridyn_controller {
  veridyn::JointController controller;
  veridyn::Measured positions, with_velocities;  // the second one is for callers that measure velocities
  veridyn::JointReference wanted;
};

namespace {

using veridyn::VectorXd;

void copy_in(const double* from, VectorXd& to) noexcept {
  if (from == nullptr) {
    to.setZero();
  } else {
    to = Eigen::Map<const VectorXd>(from, to.size());
  }
}

}  // namespace

extern "C" {

veridyn_controller* veridyn_controller_load(const char* model, double kp, double kd, double torque, char* why,
                                            size_t size) {
  try {
    const veridyn::Model arm = veridyn::read_model(model);
    veridyn::JointControllerOptions options{kp, kd};
    options.cycle.torque = torque;
    auto* out = new veridyn_controller{veridyn::JointController(arm, options), veridyn::Measured(arm.joints()),
                                       veridyn::Measured(arm.joints()), veridyn::JointReference(arm.joints())};
    out->with_velocities.dq = VectorXd::Zero(arm.joints());
    return out;
  } catch (const std::exception& bad) {
    if (why != nullptr && size > 0) std::snprintf(why, size, "%s", bad.what());
    return nullptr;
  }
}

int veridyn_controller_joints(const veridyn_controller* controller) { return controller->controller.joints(); }

int veridyn_controller_update(veridyn_controller* controller, const double* q, const double* dq,
                              const double* q_wanted, const double* dq_wanted, const double* ddq_wanted, double dt,
                              double* tau) {
  veridyn::Measured& measured = dq == nullptr ? controller->positions : controller->with_velocities;
  copy_in(q, measured.q);
  if (dq != nullptr) copy_in(dq, measured.dq);
  copy_in(q_wanted, controller->wanted.q);
  copy_in(dq_wanted, controller->wanted.dq);
  copy_in(ddq_wanted, controller->wanted.ddq);
  const VectorXd& out = controller->controller.update(measured, controller->wanted, dt);
  Eigen::Map<VectorXd>(tau, out.size()) = out;
  return controller->controller.fault() ? 1 : 0;
}

const char* veridyn_controller_fault(const veridyn_controller* controller, int* joint, double* time) {
  const auto fault = controller->controller.fault();
  if (!fault) return nullptr;
  if (joint != nullptr) *joint = fault->joint ? fault->joint->value + 1 : 0;
  if (time != nullptr) *time = fault->time;
  return describe(fault->what);
}

int veridyn_controller_hold(veridyn_controller* controller) { return controller->controller.hold() ? 1 : 0; }
void veridyn_controller_limp(veridyn_controller* controller) { controller->controller.limp(); }
void veridyn_controller_resume(veridyn_controller* controller) { controller->controller.resume(); }
void veridyn_controller_reset(veridyn_controller* controller) { controller->controller.reset(); }
void veridyn_controller_free(veridyn_controller* controller) { delete controller; }

}  // extern "C"
