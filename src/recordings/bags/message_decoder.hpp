#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "recordings/bags/message_plan.hpp"

namespace veridyn::bags {

/// Receiver of the values of a message; `leaf` indexes MessagePlan::paths.
class ValueSink {
 public:
  virtual ~ValueSink() = default;
  /// The functions receive each value of a message with the index of its leaf in the plan.
  virtual void number(int leaf, double value) = 0;
  virtual void text(int leaf, std::string_view value) = 0;
  virtual void time(int leaf, std::int64_t nanoseconds) = 0;
};

/// Decodes packed little-endian values of ROS 1.
/// @throws CutShort  the bytes end too early.
void decode_ros1(const MessagePlan& plan, std::string_view bytes, ValueSink* sink);

/// Decodes CDR after its header of four bytes: plain, of either byte order, version 1 or 2.
/// @throws CutShort  the bytes end too early, or the encapsulation is not supported.
void decode_cdr(const MessagePlan& plan, std::string_view bytes, ValueSink* sink);

}  // namespace veridyn::bags
