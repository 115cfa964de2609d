#include "veridyn/cooperation/scenario.hpp"
#include "veridyn/math/require.hpp"

int main() {
  try {
    veridyn::parse_scenario("veridyn: 1\narms: 3\n", "scenario.yaml");
  } catch (const veridyn::InvalidInput&) {
    return 0;
  }
  return 1;
}
