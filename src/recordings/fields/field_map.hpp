#pragma once

#include <map>
#include <string>
#include <vector>

#include "recordings/fields/choose_fields.hpp"

namespace veridyn::recordings {

/// The option --map, resolved to columns of a file.
///
/// A source is a column: `/arm/effort/0`, `/arm/effort/data[0]`, `actual_current_0`. For all joints it is the
/// common prefix of their columns, which are taken in the order of their numbers: `tau=/arm/effort`.
class FieldMap {
 public:
  /// @throws InvalidInput  a key that is no signal, joint or t, or a source that is not in the file.
  FieldMap(const RawRecording& raw, const std::string& path, const SignalChoice& choice);

  /// The mapped column of a signal of joint `joint` (from 0); nullopt if it is not mapped.
  std::optional<FieldPlace> place(int signal, std::size_t joint) const;
  /// Signals taken from another joint, as in tau1=tau2: the source of each mapped one.
  struct Taken {
    int signal;
    std::size_t joint;
  };
  const std::map<std::pair<int, std::size_t>, Taken>& taken() const { return taken_; }
  /// True if any joint's signal is mapped.
  bool maps_signal(int signal) const;
  /// True if all positions (of the arm's joints, or 1..n) are mapped.
  bool maps_all_positions() const;
  /// The largest joint number among the mapped positions.
  std::size_t largest_joint() const;
  /// Joints with another name in the recording than in the arm.
  const std::map<std::string, std::string>& renamed() const { return renamed_; }

 private:
  std::map<std::pair<int, std::size_t>, FieldPlace> places_;
  std::map<std::pair<int, std::size_t>, Taken> taken_;
  std::map<std::string, std::string> renamed_;
  std::size_t wanted_ = 0;
};

}  // namespace veridyn::recordings
