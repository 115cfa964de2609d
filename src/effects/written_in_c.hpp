#pragma once

#include <string>
#include <vector>

#include "veridyn/effects/effect.hpp"

namespace veridyn {

/// Interface of an AxisEffect whose columns can be written as C for exported models. A test compares the C
/// code with columns().
class WrittenInC {
 public:
  virtual ~WrittenInC() = default;

  /// One C expression for each of the effect's parameters, equal to columns(). Available are the
  /// doubles s, ds, dds, from_s, from_ds and load of AxisSample, `z`, three doubles of memory that
  /// start as zeros, <math.h>, and
  ///
  ///   @direction(ds)             the sign of a velocity, see sliding_direction()
  ///   @clamp(x)                  x limited to -1 ... 1
  ///   @step(s, z)                displacement since the previous call
  ///   @contact(s, distance, z)   shear of a contact, see advance_contact()
  ///
  virtual std::vector<std::string> c_columns(const ShapeValues& shape) const = 0;

  /// A C statement before the expressions that advances the memory; empty: none is needed.
  virtual std::string c_before(const ShapeValues& /*shape*/) const { return {}; }
};

/// A number that C reads without loss.
std::string c_number(double value);

}  // namespace veridyn
