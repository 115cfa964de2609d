#pragma once

#include <string>
#include <vector>

#include "veridyn/effects/effect.hpp"

namespace veridyn {

/// What an AxisEffect may be besides: one whose columns can be written as C for exported models.
/// A test compares the two.
class WrittenInC {
 public:
  virtual ~WrittenInC() = default;

  /// One C expression for each of the effect's parameters, the same as columns(). They may use the
  /// doubles s, ds, dds, from_s, from_ds and load of AxisSample, `z`, three doubles of memory that
  /// start as zeros, <math.h>, and
  ///
  ///   @direction(ds)             the sign of a velocity, see sliding_direction()
  ///   @clamp(x)                  within -1 and 1
  ///   @step(s, z)                the way since the call before
  ///   @contact(s, distance, z)   how far a contact is sheared, see advance_contact()
  ///
  virtual std::vector<std::string> c_columns(const ShapeValues& shape) const = 0;

  /// A C statement that stands before them, to advance the memory; empty: none.
  virtual std::string c_before(const ShapeValues& /*shape*/) const { return {}; }
};

/// A number as C reads it back.
std::string c_number(double value);

}  // namespace veridyn
