#include "veridyn/files/mjcf.hpp"
#include "veridyn/files/model_file.hpp"

int main() {
  return veridyn::read_model("planar-2r").joints() == 2 ? 0 : 1;
}
