#include "veridyn/dvrk/board_arm.hpp"
#include "veridyn/math/require.hpp"

int main() {
  try {
    veridyn::BoardArmOptions options;
    options.config = "no-such-arm";
    const veridyn::BoardArm arm(options);
  } catch (const veridyn::InvalidInput&) {
    return 0;
  }
  return 1;
}
