#include "recordings/recording_probe.hpp"

#include "support/file_in_memory.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/recordings/recording.hpp"

namespace veridyn {

Recording read_probe(std::string_view bytes) {
  return read_recording(FileInMemory(bytes).path());
}

long probe_recording(std::string_view bytes) {
  try {
    const Recording read = read_probe(bytes);
    return read.q.size() + read.tau.size();
  } catch (const InvalidInput&) {
    return 0;  // the right answer to a damaged file
  }
}

}  // namespace veridyn
