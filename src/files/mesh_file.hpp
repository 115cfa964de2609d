#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

namespace veridyn {

struct Mesh {
  std::vector<Eigen::Vector3d> points;
  std::vector<std::array<int, 3>> triangles;
};

/// A mesh from an STL file (binary or text) or an OBJ file.
/// @throws InvalidInput  no such file, another format, or damaged.
Mesh read_mesh(const std::string& path);

}  // namespace veridyn
