#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace veridyn::bags {

enum class FieldKind {
  kBool, kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kInt64, kUint64,
  kFloat32, kFloat64, kString, kTime, kDuration, kMessage
};

/// One field of a message, with all that lies below it.
struct FieldNode {
  FieldKind kind = FieldKind::kMessage;
  enum class Repeat { kOne, kFixed, kSequence } repeat = Repeat::kOne;
  std::uint32_t count = 0;           ///< Count of a fixed array
  int leaf = -1;                     ///< index into MessagePlan::paths; -1 for a message
  std::vector<FieldNode> children;   ///< Children of a message, in their order on the wire
};

/// How the bytes of one message type are to be read.
struct MessagePlan {
  std::vector<FieldNode> fields;
  std::vector<std::string> paths;  ///< Paths of the leaves, as "wrench/force/x"
};

/// From the text of a definition (of ROS 1 or 2, dependencies behind lines of '='), or, where that
/// is empty, from the few common types that are known by name.
/// @param ros2  time is int32 and uint32, and a Header has no seq.
/// @throws InvalidInput  the type is not known, refers to unknown ones, or holds itself.
MessagePlan plan_of(const std::string& type, const std::string& definition, bool ros2);

/// "sensor_msgs/JointState" for sensor_msgs/msg/JointState.
std::string short_type(const std::string& type);

}  // namespace veridyn::bags
