#pragma once

#include <map>
#include <string>
#include <utility>

#include "recordings/fields/choose_fields.hpp"

namespace veridyn::recordings {

/// The option --map, resolved to columns of a file.
///
/// A source is a column: `/arm/effort/0`, `/arm/effort/data[0]`, `actual_current_0`. For all joints it is the
/// common prefix of their columns, which are taken in the order of their numbers: `tau=/arm/effort`.
struct FieldMap {
  using Signal = std::pair<int, std::size_t>;  ///< index into kRecordingSignals; joint from 0

  std::map<Signal, FieldPlace> places;
  std::map<Signal, Signal> taken;  ///< signals taken from another joint, as in tau1=tau2
  std::map<std::string, std::string> renamed;  ///< joints with another name in the recording than in the arm

  std::optional<FieldPlace> place(int signal, std::size_t joint) const;
  /// True if any joint's signal is mapped.
  bool maps_signal(int signal) const;
  /// Number of joints if the positions of all are mapped, else 0.
  /// @param wanted  joints of the arm; 0: joints 1..n of the map.
  std::size_t mapped_joints(std::size_t wanted) const;
};

/// @throws InvalidInput  a key that is no signal, joint or t, or a source that is not in the file.
FieldMap field_map(const RawRecording& raw, const std::string& path, const SignalChoice& choice);

}  // namespace veridyn::recordings
