#pragma once

#include <map>
#include <string>
#include <vector>

#include "recordings/choose_fields.hpp"

namespace veridyn::recordings {

/// What --map says, resolved to columns of a file.
///
/// A source is a column: `/arm/effort/0`, `/arm/effort/data[0]`, `actual_current_0`; for all joints
/// it is what their columns begin with, in the order of their numbers: `tau=/arm/effort`.
class FieldMap {
 public:
  /// @throws InvalidInput  a key that is no signal, joint or t, or a source that is not in the file.
  FieldMap(const RawRecording& raw, const std::string& path, const SignalChoice& choice);

  /// Where --map puts a signal of joint `joint` (from 0); not found: it does not say.
  FieldPlace place(int signal, std::size_t joint) const;
  /// Where --map takes another joint's signal, as in tau1=tau2: by what is mapped, what is taken.
  struct Taken {
    int signal;
    std::size_t joint;
  };
  const std::map<std::pair<int, std::size_t>, Taken>& taken() const { return taken_; }
  /// Whether any joint's signal is mapped.
  bool touches(int signal) const;
  /// Whether all positions (of the joints that are wanted, or 1..n) are mapped.
  bool maps_all_positions() const;
  /// The largest joint number among the mapped positions.
  std::size_t largest_joint() const;
  /// Joints that are recorded under another name.
  const std::map<std::string, std::string>& renamed() const { return renamed_; }

 private:
  std::map<std::pair<int, std::size_t>, FieldPlace> places_;
  std::map<std::pair<int, std::size_t>, Taken> taken_;
  std::map<std::string, std::string> renamed_;
  std::size_t wanted_ = 0;
};

}  // namespace veridyn::recordings
