#pragma once

#include <Eigen/Geometry>
#include <string>
#include <string_view>
#include <vector>

#include "veridyn/report/json/json_value.hpp"
#include "veridyn/identification/identification.hpp"

namespace veridyn {

// Data of the figures of a page, in one form for all pages:
//
//   command     the command line that made them
//   joints      [{name, unit, torque_unit}]
//   arms        [{name, base, tip, middle, range, frames: [{name, parent, kind, c, s0, A, B}], meshes}]
//   recordings  [{source, role, time, joints: [{q, ...}]}]; instead of `joints`: `q`, columns of all
//               arms one after the other. A joint has `plots` [{kind, title, unit, curves: [{name,
//               style, values}]}], or q, dq, ddq, measured, model and extended
//   friction    [{joint, velocity, torque, half}]: curves of the model with 95 % half widths
//
// and a page may add lists of its own. Columns are packed_values().

inline constexpr Eigen::Index kCurveSamples = 3000;  ///< largest number of samples of one curve

/// Every `step`-th value as 16-bit numbers in base64: {"from", "step", "int16"}, value = from + k step,
/// where zero is one of the steps, and k = 65535 is a value that is not finite.
Json packed_values(const VectorRef& values, Eigen::Index step = 1);

/// Every `step`-th time [s], to a tenth of a millisecond.
Json times(const VectorRef& time, Eigen::Index step = 1);

std::string base64(std::string_view bytes);

/// Command, joints and the arm of a page, without recordings.
Json series_of(const std::string& command, const Model& arm);
Json series_of(const std::string& command);

/// The surfaces of the links, [{frame, colour, x, y, z, corners}], thinned to what a page can move:
/// the visuals (else the collision shapes) of the URDF file that the arm was read from, where it is
/// still there.
Json meshes_json(const Model& arm);

/// An arm that a page can move.
Json arm_json(const Model& arm, const Eigen::Isometry3d& T_world_base = Eigen::Isometry3d::Identity());

Json curve_json(const std::string& name, const std::string& style, Json values);
Json plot_json(const char* kind, const std::string& title, const std::string& unit, Json curves);

/// Decimation of a curve with this many samples.
Eigen::Index curve_step(Eigen::Index rows);

/// One recording in the plots.
struct PlottedRecording {
  const char* role = "";                     ///< "held out" or "training"
  const RecordingError* model = nullptr;     ///< the unmodified robot
  const RecordingError* extended = nullptr;  ///< the robot with the findings; null: there are none
};

/// Adds recordings with measured and modelled torques to a page.
///
/// A recording is thinned to about 3000 samples, and to fewer where there are many recordings and
/// joints. Recordings beyond the capacity of a page are omitted from the end, and counted.
void add_recordings(Json& series, const std::vector<PlottedRecording>& recordings);

/// Adds the friction of every joint over its speed, with the confidence band of its parameters, up
/// to the speeds of the recordings.
void add_friction(Json& series, const Identification& id);

}  // namespace veridyn
