#pragma once

#include <optional>
#include <string>

#include "veridyn/recordings/signal_choice.hpp"

namespace veridyn::recordings {

/// Conversion of numbers to SI: factor * (number - zero).
struct UnitScale {
  double factor = 1.0;
  double zero = 0.0;
  /// Bit 10 of a whole number is the direction and its lower bits are the size, as in the load registers of
  /// hobby servos.
  bool direction_bit = false;

  double operator()(double number) const;  ///< the number in SI units
  bool changes_nothing() const { return factor == 1.0 && zero == 0.0 && !direction_bit; }
};

/// Scale of a unit of a signal ("q", "dq", "ddq", "tau", "i", "t"), or nullopt for an unknown unit:
///
///   deg, mNm, ...      see the table; a leading - reverses the sign
///   0.01               factor to SI, for example of a gear
///   4096/rev, @2048    counts of an encoder; the count at zero (default 0); also with other units: rad@1.57
///   %                  share of the range, -100 to 100 (q, dq), or of the largest effort (tau); also permille
///                      and share (of one)
///   load               a load register: direction in bit 10, 1023 is the largest effort (tau)
///
/// `tau` in A has the factor of a current.
/// @param joint  has the limits to which shares refer; null: the limits are assumed to be finite.
std::optional<UnitScale> unit_scale(const std::string& signal, const std::string& unit, const WantedJoint* joint = nullptr);

/// Name of a scale for unit_scale(): that of a known unit, otherwise its factor.
std::string unit_name(const std::string& signal, const UnitScale& scale, const WantedJoint& joint);

/// True for degrees of a prismatic joint, and millimetres of a revolute one.
bool is_unit_of_other_joint_type(const std::string& unit, const WantedJoint& joint);

/// The factor of unit_scale() alone.
std::optional<double> unit_factor(const std::string& signal, const std::string& unit);

/// Unit of times with such steps, if it is not the second: "ms", "us" or "ns".
const char* unit_of_clock(double step);

/// True for a unit of current.
bool is_current_unit(const std::string& unit);

/// The chosen unit of a signal of joint number `joint` (from 1), or "".
std::string unit_of(const SignalChoice& choice, const std::string& signal, int joint);

/// The scale of one column: degrees apply to revolute joints, millimetres to prismatic ones.
UnitScale scale_for(const SignalChoice& choice, const std::string& signal, int joint);

/// @throws InvalidInput  a signal or unit that is not known.
void require_known_units(const SignalChoice& choice);

/// @throws InvalidInput  a unit is given for a joint beyond those of the recording, or a share for a joint without limits.
void require_joints_of(const SignalChoice& choice, int joints, const std::string& path);

}  // namespace veridyn::recordings
