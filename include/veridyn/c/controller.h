#ifndef VERIDYN_C_CONTROLLER_H
#define VERIDYN_C_CONTROLLER_H

/* Control of an arm by its MODEL, for programs in C, LabVIEW and S-functions of Simulink: computed torque with all
 * that JointController has around it (errors of sensors, velocities, friction, errors of the model, supervisor,
 * limits). Link veridyn::simulation.
 *
 *   char why[256];
 *   veridyn_controller* arm = veridyn_controller_load("arm.yaml", 400.0, 40.0, 0.0, why, sizeof why);
 *   if (!arm) { puts(why); return 1; }
 *   every cycle: if (veridyn_controller_update(arm, q, NULL, q_wanted, dq_wanted, ddq_wanted, 1e-3, tau)) ...fault
 *   veridyn_controller_free(arm);
 *
 * Arrays have an entry for each joint: [rad], [rad/s], [N m], or [m], [m/s], [N] where the joint slides. An object
 * serves one thread at a time. After loading nothing allocates or blocks. */

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct veridyn_controller veridyn_controller;

/* kp [1/s^2], kd [1/s]: gains of all joints. torque: limit of drives for which the MODEL gives none; 0 if it gives all.
 * Returns NULL where the MODEL cannot be used; `why` (of `size` bytes) then says why, in one line. */
veridyn_controller* veridyn_controller_load(const char* model, double kp, double kd, double torque, char* why,
                                            size_t size);

int veridyn_controller_joints(const veridyn_controller* controller);

/* One cycle, dt [s] after the previous one. q: as the encoders show it; dq: measured velocities, or NULL. Wanted
 * positions, velocities and accelerations are true ones; NULL: zero velocity, acceleration. Writes the torques as the
 * drives count them to tau: always finite and within limits. Returns 0, or another number from a fault until a reset. */
int veridyn_controller_update(veridyn_controller* controller, const double* q, const double* dq,
                              const double* q_wanted, const double* dq_wanted, const double* ddq_wanted, double dt,
                              double* tau);

/* Fixed words for the fault, such as "position limit", or NULL without one. joint: its number from 1, 0 for none; time:
 * [s] since loading or the last reset. Both may be NULL. */
const char* veridyn_controller_fault(const veridyn_controller* controller, int* joint, double* time);

/* Brakes and holds the arm; returns 0 in a fault. */
int veridyn_controller_hold(veridyn_controller* controller);
/* Gravity compensation and a little damping alone. */
void veridyn_controller_limp(veridyn_controller* controller);
/* Ends both; what is wanted then begins where the arm is. */
void veridyn_controller_resume(veridyn_controller* controller);
/* Clears a fault and all that was observed. */
void veridyn_controller_reset(veridyn_controller* controller);

void veridyn_controller_free(veridyn_controller* controller);

#ifdef __cplusplus
}
#endif

#endif
