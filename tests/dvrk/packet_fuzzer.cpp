#include <cstdlib>

#include "dvrk/packet_probe.hpp"

// libFuzzer target, built with clang and VERIDYN_FUZZ=ON. Seeds: section 19, one file per datagram,
// which `packet_fuzzer_seeds FOLDER` writes.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (veridyn::dvrk::probe_packet({data, size}) != nullptr) std::abort();
  return 0;
}
