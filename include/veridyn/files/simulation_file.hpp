#pragma once

#include <string>
#include <vector>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// A simulator's file with the values of a model.
struct UpdatedFile {
  std::string xml;
  std::vector<std::string> changed;   ///< parts that got other values: "inertial of forearm"
  std::vector<std::string> left_out;  ///< parts of the model that the file cannot represent
};

/// The MJCF file that a model came from, with the model's values: inertials, damping, frictionloss,
/// armature, stiffness and springref. A body that only the model has, such as a diagnosed load, is
/// added. Everything else stays: geoms, meshes, actuators, sensors, classes, comments; values that
/// the model shares with the file keep their digits. See portable_model() for values that torques
/// do not determine.
/// @throws InvalidInput  the file cannot be read by read_mjcf(), lacks a joint of the model, or the
/// model has bodies without values, or with values that MuJoCo refuses.
UpdatedFile updated_mjcf(const Model& arm, const std::string& path);

/// Like updated_mjcf() for SDFormat: inertials, damping, friction, spring_stiffness and spring_reference.
UpdatedFile updated_sdf(const Model& arm, const std::string& path);

}  // namespace veridyn
