#include <fstream>

#include "veridyn/recordings/recording.hpp"

int main() {
  std::ofstream("two-rows.csv") << "t,q1,tau1\n0,0,1\n0.01,0.1,1\n";
  return veridyn::read_recording("two-rows.csv").q.rows() == 2 ? 0 : 1;
}
