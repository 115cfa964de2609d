#include <cstdint>

#include "recordings/bags/bag_probe.hpp"
#include "recordings/recording_probe.hpp"

// libFuzzer target, built with clang and VERIDYN_FUZZ=ON: whatever can be a recording, from its
// first bytes to signals. Seeds: tests/recordings/samples. Containers are decoded whole, too, not
// only the topic that is the arm.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const std::string_view start = bytes.substr(0, 6);
  const bool container = start.substr(0, 4) == "#ROS" || start == "\x89MCAP0" ||
                         start == "SQLite" || start.substr(0, 4) == "\x28\xB5\x2F\xFD";
  if (container) veridyn::bags::probe_container(bytes);
  veridyn::probe_recording(bytes);
  return 0;
}
