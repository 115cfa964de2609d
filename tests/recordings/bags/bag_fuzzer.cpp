#include <cstdint>

#include "recordings/bags/bag_probe.hpp"

// libFuzzer target, built with clang and VERIDYN_FUZZ=ON. Seeds: tests/recordings/samples.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  veridyn::bags::probe_container({reinterpret_cast<const char*>(data), size});
  return 0;
}
