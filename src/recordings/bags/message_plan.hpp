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

/// One field of a message, with its subfields.
struct FieldNode {
  FieldKind kind = FieldKind::kMessage;
  enum class Repeat { kOne, kFixed, kSequence } repeat = Repeat::kOne;
  std::uint32_t count = 0;           ///< size of a fixed array
  int leaf = 0;                      ///< index into MessagePlan::paths, for a field of a basic type
  std::vector<FieldNode> children;   ///< fields of a message, in serialised order
};

/// Layout of the bytes of one message type.
struct MessagePlan {
  std::vector<FieldNode> fields;
  std::vector<std::string> paths;  ///< paths of the leaves, such as "wrench/force/x"
};

/// Builds a plan from a definition (ROS 1 or 2, dependencies after lines of '='), or, if that is empty, from
/// the built-in definitions of common types.
/// @param ros2  time is int32 and uint32, and a Header has no seq.
/// @throws InvalidInput  the type is unknown, refers to unknown types, or contains itself.
MessagePlan plan_of(const std::string& type, const std::string& definition, bool ros2);

/// Shortens "sensor_msgs/msg/JointState" to "sensor_msgs/JointState".
std::string short_type(const std::string& type);

}  // namespace veridyn::bags
