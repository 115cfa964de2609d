#include "pendulum.hpp"
#include "veridyn/report/json.hpp"
#include "veridyn/report/robot_info.hpp"

int main() {
  return veridyn::to_json(veridyn::robot_info(pendulum())).find("pendulum") != std::string::npos ? 0 : 1;
}
