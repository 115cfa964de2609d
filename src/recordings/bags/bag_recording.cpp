#include "recordings/bags/bag_recording.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <map>
#include <memory>

#include "recordings/files/whole_file.hpp"
#include "recordings/bags/topic_decoder.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::bags {
namespace {

using recordings::RawRecording;
using recordings::RawStream;
using recordings::RawTopic;

// True if --topic names the topic, or a source of --map begins with it.
bool is_named(const std::string& topic, const SignalChoice& choice) {
  const auto& topics = choice.topics;
  if (std::find(topics.begin(), topics.end(), topic) != topics.end()) return true;
  return std::any_of(choice.map.begin(), choice.map.end(), [&topic](const auto& entry) {
    return entry.second.rfind(topic, 0) == 0;
  });
}

class Collector {
 public:
  explicit Collector(const SignalChoice& choice) : choice_(choice) {
    sink_.open = [this](const Channel& channel) { return open(channel); };
    sink_.message = [this](int channel, std::int64_t recorded, std::string_view bytes) {
      store_message(channel, recorded, bytes);
    };
  }

  BagSink* sink() { return &sink_; }

  RawRecording finish() {
    RawRecording raw;
    raw.topics = std::move(topics_);
    raw.remarks = std::move(sink_.remarks);
    for (const std::unique_ptr<Entry>& entry : entries_) {
      const TopicDecoder& decoder = entry->decoder;
      if (decoder.bad_messages() > 0)
        raw.remarks.push_back(text(decoder.bad_messages(), " messages on ", raw.topics[entry->topic].name,
                                   " cannot be decoded (", decoder.bad_reason(), ") and are left out."));
      for (RawStream& stream : entry->decoder.extract_streams()) raw.streams.push_back(std::move(stream));
    }
    return raw;
  }

 private:
  struct Entry {
    TopicDecoder decoder;
    std::size_t topic;
  };

  // One entry for each channel; the pieces of a split bag declare the same channels, which share their
  // entries.
  int open(const Channel& channel) {
    const std::string key =
        channel.topic + "\n" + channel.type + "\n" + channel.publisher + "\n" + channel.encoding;
    const auto [at, fresh] = entry_by_key_.try_emplace(key, static_cast<int>(entries_.size()));
    if (!fresh) return at->second;
    const auto [known, is_new] = topic_by_name_.try_emplace(channel.topic, topics_.size());
    const std::size_t topic = known->second;
    if (is_new) topics_.push_back({channel.topic, channel.type, channel.encoding, 0, 0, 0, ""});
    entries_.push_back(std::unique_ptr<Entry>(
        new Entry{TopicDecoder(channel, is_named(channel.topic, choice_)), topic}));
    if (!entries_.back()->decoder.problem().empty())
      topics_[topic].undecoded = entries_.back()->decoder.problem();
    return at->second;
  }

  void store_message(int channel, std::int64_t recorded, std::string_view bytes) {
    if (channel < 0) return;
    Entry& entry = *entries_[channel];
    RawTopic& topic = topics_[entry.topic];
    recorded = std::clamp(recorded, std::int64_t{0}, recordings::kLargestTime);
    topic.first = topic.messages == 0 ? recorded : std::min(topic.first, recorded);
    topic.last = topic.messages == 0 ? recorded : std::max(topic.last, recorded);
    ++topic.messages;
    if (entry.decoder.problem().empty() && entry.decoder.useful()) entry.decoder.add(recorded, bytes);
  }

  const SignalChoice& choice_;
  BagSink sink_;
  std::vector<RawTopic> topics_;
  std::map<std::string, std::size_t> topic_by_name_;
  std::vector<std::unique_ptr<Entry>> entries_;
  std::map<std::string, int> entry_by_key_;
};

std::string format_name(const recordings::OpenedFile& file) {
  if (!file.bytes) return "bag (folder)";
  const std::string_view probe = file.bytes->unread().substr(0, 8);
  if (probe.substr(0, 7) == "#ROSBAG") return "ROS 1 bag";
  if (probe.substr(1, 4) == "MCAP") return "MCAP";
  return "ROS 2 bag";
}

}  // namespace

RawRecording read_bag_recording(const recordings::OpenedFile& file, const SignalChoice& choice) {
  Collector collector(choice);
  read_bag(file.path, collector.sink(), file.bytes ? &*file.bytes : nullptr);
  RawRecording raw = collector.finish();
  raw.format = format_name(file);
  return raw;
}

}  // namespace veridyn::bags
