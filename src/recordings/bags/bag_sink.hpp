#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "recordings/files/byte_stream.hpp"

namespace veridyn::bags {

/// One publisher of one topic, as declared in a container.
struct Channel {
  std::string topic;
  std::string type;        ///< type as stored: sensor_msgs/JointState or sensor_msgs/msg/JointState
  std::string encoding;    ///< ros1, cdr, json; others cannot be decoded
  std::string definition;  ///< message definition in the text form of ROS 1 or 2; empty: not stored
  std::string publisher;   ///< name of the sending node; empty: not stored
};

/// Receiver of the channels and messages of a container.
struct BagSink {
  /// Called once for every channel; its result identifies the channel in calls of `message`.
  std::function<int(const Channel&)> open;
  /// Receives a message and its recording time [ns]. The bytes are valid only during the call.
  std::function<void(int channel, std::int64_t recorded, std::string_view bytes)> message;
  /// Remarks for the user, for example on a file that ends early or a damaged chunk.
  std::vector<std::string> remarks;
};

/// Reads a ROS 1 bag, format 2.0. A bag without an index (after a crash) is read up to its last whole message.
/// @throws InvalidInput  another format, or encrypted.
void read_ros1_bag(std::string_view bytes, const std::string& path, BagSink* sink);

/// Reads an MCAP file. A file without a summary, or a truncated one, is read up to the last whole record.
/// @throws InvalidInput  not MCAP.
void read_mcap(std::string_view bytes, const std::string& path, BagSink* sink);

/// Reads ROS 2 storage in sqlite3, plain (.db3) or as one zstd frame (.db3.zstd).
/// @param message_compression  every message is a zstd frame, as declared in metadata.yaml.
/// @throws InvalidInput  not a database, or without the tables of a ROS 2 bag.
void read_db3(std::string_view bytes, const std::string& path, bool message_compression,
              BagSink* sink);

/// Reads any of these, recognised by its first bytes, or a folder: a ROS 2 bag with or without metadata.yaml,
/// or the pieces of a split ROS 1 bag or MCAP.
/// @param opened  the file, if it is open already.
/// @throws InvalidInput  see above, or a folder that holds none of them.
void read_bag(const std::string& path, BagSink* sink, const ByteStream* opened = nullptr);

/// True if the first bytes of a file are those of a bag.
bool is_bag(std::string_view first_bytes);

}  // namespace veridyn::bags
