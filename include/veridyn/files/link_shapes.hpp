#pragma once

#include <Eigen/Geometry>
#include <array>
#include <string>
#include <vector>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// All points within `radius` of the straight line between two points of a frame [m].
struct Capsule {
  std::string frame;  ///< "world": fixed in the world
  Eigen::Vector3d from{0, 0, 0};
  Eigen::Vector3d to{0, 0, 0};
  double radius = 0.0;
};

/// A solid on a frame. Boxes, cylinders (along z) and spheres are centred on `pose`.
struct LinkShape {
  enum class Kind { kBox, kCylinder, kSphere, kMesh };
  std::string frame;
  Kind kind = Kind::kBox;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< T_frame_shape
  Eigen::Vector3d size{0, 0, 0};  ///< [m] edges of a box; (radius, radius, length) of a cylinder; (radius, radius,
                                  ///< radius) of a sphere
  std::string colour;             ///< "#rrggbb"; empty: none given
  /// Vertices of a mesh, in its own axes [m].
  std::vector<Eigen::Vector3d> points;
  std::vector<std::array<int, 3>> triangles;
};

struct LinkShapes {
  std::vector<LinkShape> shapes;
  std::vector<std::string> remarks;  ///< meshes that could not be read
};

/// Selects one kind of shapes in a URDF file.
enum class UrdfShapes { kVisual, kCollision };

/// The shapes of a URDF file's links. Meshes are STL and OBJ files; `package://NAME/...` is searched for next
/// to the URDF file, in the folders above it, and in those of ROS_PACKAGE_PATH.
/// @throws InvalidInput  no such file, or no XML.
LinkShapes urdf_shapes(const std::string& path, UrdfShapes which);

/// Capsules that contain all of a shape; a long mesh may need several.
std::vector<Capsule> capsules_around(const LinkShape& shape);

/// Capsules around all collision shapes of a URDF file; shapes that could not be read are listed in `remarks`.
std::vector<Capsule> collision_capsules(const std::string& urdf, std::vector<std::string>& remarks);

/// A capsule of this radius along every straight line from one joint to the next, for an arm of which only
/// the kinematics is known.
std::vector<Capsule> capsules_along_links(const Model& arm, double radius);

}  // namespace veridyn
