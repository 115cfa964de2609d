/* A controller in C holds a pendulum, says what went wrong, and goes on after a reset. */

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "veridyn/c/controller.h"

#define EXPECT(condition) \
  if (!(condition)) return printf("%s:%d: found " #condition " wrong\n", __FILE__, __LINE__), 1

int main(int argc, char** argv) {
  char why[200];
  EXPECT(argc == 2);
  EXPECT(veridyn_controller_load("no such file", 400, 40, 0, why, sizeof why) == NULL);
  EXPECT(strstr(why, "no such file") != NULL);
  EXPECT(veridyn_controller_load(argv[1], -1, 40, 10, why, sizeof why) == NULL);
  veridyn_controller* arm = veridyn_controller_load(argv[1], 400, 40, 100, why, sizeof why);
  if (arm == NULL) return puts(why), 1;
  EXPECT(veridyn_controller_joints(arm) == 2);
  double q[2] = {0.1, 0.2}, wanted[2] = {0.1, 0.2}, dq[2] = {0, 0}, at_rest[2], moved[2], time = 0;
  int joint = -1;
  EXPECT(veridyn_controller_update(arm, q, dq, wanted, NULL, NULL, 1e-3, at_rest) == 0);
  wanted[0] += 0.01;
  EXPECT(veridyn_controller_update(arm, q, dq, wanted, NULL, NULL, 1e-3, moved) == 0);
  EXPECT(moved[0] > at_rest[0]);
  EXPECT(veridyn_controller_fault(arm, &joint, &time) == NULL);
  EXPECT(veridyn_controller_hold(arm) == 1);
  veridyn_controller_resume(arm);
  q[1] = NAN;
  EXPECT(veridyn_controller_update(arm, q, NULL, wanted, NULL, NULL, 1e-3, moved) != 0);
  EXPECT(isfinite(moved[0]) && isfinite(moved[1]));
  EXPECT(veridyn_controller_fault(arm, &joint, &time) != NULL);
  EXPECT(joint == 2 && fabs(time - 3e-3) < 1e-9);
  EXPECT(veridyn_controller_hold(arm) == 0);
  veridyn_controller_reset(arm);
  q[1] = 0.2;
  EXPECT(veridyn_controller_update(arm, q, NULL, wanted, NULL, NULL, 1e-3, moved) == 0);
  veridyn_controller_free(arm);
  return 0;
}
