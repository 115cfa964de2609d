#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "recordings/bags/bag_sink.hpp"
#include "recordings/bags/message_decoder.hpp"
#include "recordings/signals/raw_recording.hpp"

namespace veridyn::bags {

/// Decodes the messages of one channel into streams, one for each set of names and sizes.
class TopicDecoder : public ValueSink {
 public:
  /// @param definite  true: the user chose this topic explicitly.
  TopicDecoder(const Channel& channel, bool definite);

  /// True if the channel has joint signals or plain numbers, or was chosen by the user.
  bool useful() const { return useful_; }
  /// Reason if the channel is not decoded; empty if it is.
  const std::string& problem() const { return problem_; }

  void add(std::int64_t recorded, std::string_view bytes);  ///< decodes a message recorded at this time [ns]

  /// The streams, in the order of their first message. Call it once.
  std::vector<recordings::RawStream> extract_streams();
  long bad_messages() const { return bad_; }  ///< number of messages that could not be decoded
  const std::string& bad_reason() const { return bad_reason_; }

  void number(int leaf, double value) override;
  void text(int leaf, std::string_view value) override;
  void time(int leaf, std::int64_t nanoseconds) override;

 private:
  enum class Role { kOther, kNames, kPosition, kVelocity, kEffort, kStamp };
  struct Leaf {
    std::string path;
    Role role = Role::kOther;
    std::vector<double> numbers;  // numbers of the current message
  };

  int leaf_of(const std::string& path);  ///< index of a leaf, which is added if it is new
  void decode_json(std::string_view bytes);
  void store_row(std::int64_t recorded);  ///< appends the collected values as a row
  recordings::RawStream& stream_of_message();  ///< of messages with these names and lengths
  std::vector<recordings::RawField> fields() const;

  Channel channel_;
  bool ros2_ = false;
  bool useful_ = false;
  std::string problem_;
  MessagePlan plan_;
  std::vector<Leaf> leaves_;
  std::map<std::string, int> leaf_by_path_;
  std::vector<std::string> names_;
  std::int64_t stamp_ = 0;
  std::vector<recordings::RawStream> streams_;
  std::vector<std::string> key_;  // names and sizes of the current stream
  std::map<std::vector<std::string>, std::size_t> stream_by_key_;
  std::size_t current_ = 0;
  long bad_ = 0;
  std::string bad_reason_;
};

}  // namespace veridyn::bags
