#include "veridyn/export/mjcf.hpp"
#include "veridyn/model/model_file.hpp"

int main() {
  return veridyn::read_model("planar-2r").joints() == 2 ? 0 : 1;
}
