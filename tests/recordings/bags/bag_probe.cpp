#include "recordings/bags/bag_probe.hpp"

#include <memory>
#include <vector>

#include "recordings/bags/bag_sink.hpp"
#include "recordings/bags/topic_decoder.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::bags {

long probe_container(std::string_view bytes) {
  std::vector<std::unique_ptr<TopicDecoder>> decoders;
  long messages = 0;
  BagSink sink;
  sink.open = [&](const Channel& channel) {
    if (decoders.size() >= 1000) return -1;
    decoders.push_back(std::make_unique<TopicDecoder>(channel, true));
    return static_cast<int>(decoders.size()) - 1;
  };
  sink.message = [&](int channel, std::int64_t recorded, std::string_view message) {
    if (channel < 0) return;
    TopicDecoder& decoder = *decoders[channel];
    if (decoder.problem().empty()) decoder.add(recorded, message);
    ++messages;
  };
  try {
    const std::string path = "fuzz";
    if (bytes.substr(0, 4) == "#ROS") {
      read_ros1_bag(bytes, path, &sink);
    } else if (bytes.substr(1, 4) == "MCAP") {
      read_mcap(bytes, path, &sink);
    } else {
      read_db3(bytes, path, true, &sink);
    }
  } catch (const InvalidInput&) {
    // The right answer to a damaged file.
  }
  long values = 0;
  for (const auto& decoder : decoders) {
    for (const recordings::RawStream& stream : decoder->extract_streams())
      values += static_cast<long>(stream.values.size());
  }
  return values + messages;
}

}  // namespace veridyn::bags
