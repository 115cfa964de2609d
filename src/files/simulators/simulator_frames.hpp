#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "math/eigen_pose.hpp"
#include "model/joint_placement.hpp"
#include "files/xml_file.hpp"

namespace veridyn {

/// Common parts of the readers of MJCF and SDFormat.

/// Bodies up to this mass [kg] only carry frames, because simulators refuse links without mass (the writers
/// here use 1e-12 and 1e-9); such a frame has no body. Ten micrograms at a distance of a metre cause 1e-7 N
/// m, far below any arm's resolution.
constexpr double kPlaceholderMass = 1e-8;

/// A body from its mass [kg], and the tensor about its centre [kg m^2] along the axes of T, which
/// places the centre of mass; nullopt for a placeholder.
/// @throws InvalidInput  a mass or a principal moment below zero.
std::optional<Body> body_of(const XmlFile& xml, pugi::xml_node at, double mass, const Eigen::Isometry3d& T,
                            const Eigen::Matrix3d& inertia);

/// Axis of a joint as a unit vector. @throws InvalidInput  it has no direction.
Vec3d unit_axis(const XmlFile& xml, pugi::xml_node at, const Eigen::Vector3d& axis);

/// A joint of a file, before the number of coordinates is known.
struct FileJoint {
  pugi::xml_node node;
  std::string name;
  bool turns = true;
  /// Share of another joint: the variable of a dependent joint is constant + sum of coefficient * joint
  /// variable.
  struct Share {
    int joint;
    double coefficient;
  };
  bool follows = false;
  std::vector<Share> shares{};
  double constant = 0.0;
  Limits limits{};
};

/// Every joint's variable as a function of the coordinates: the joints that follow no other, in their order.
/// @throws InvalidInput  joints that follow each other in a cycle, or no coordinate.
std::vector<Axis> joint_variables(const XmlFile& xml, const std::vector<FileJoint>& joints,
                                  std::vector<Coordinate>& coordinates);

/// Adds the effect that corresponds to a simulator's attribute ("damping", "friction", "armature",
/// "stiffness", "offset"), unless its value is zero.
void add_effect(ModelDescription& model, const std::string& file, const char* attribute, const Axis& axis,
                double value);

}  // namespace veridyn
