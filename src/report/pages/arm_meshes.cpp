#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>

#include "report/pages/page_series.hpp"
#include "files/robot_format.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/link_shapes.hpp"

namespace veridyn {
namespace {

constexpr int kTrianglesOfArm = 9000;  // largest number for all bodies: 150 kB, and the picture turns smoothly
constexpr int kFinestGrid = 64;        // largest number of cells along a body's longest edge
constexpr int kRoundSides = 24;        // number of sides of cylinders and spheres

struct Triangles {
  std::vector<Eigen::Vector3d> points;
  std::vector<std::array<int, 3>> corners;
};

// The surface of revolution about z through rings of points, from the lowest to the highest.
Triangles of_rings(const std::vector<std::pair<double, double>>& radius_and_height) {
  Triangles out;
  for (const auto& [radius, height] : radius_and_height) {
    for (int k = 0; k < kRoundSides; ++k) {
      const double angle = 2.0 * M_PI * k / kRoundSides;
      out.points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), height);
    }
  }
  const int rings = static_cast<int>(radius_and_height.size());
  for (int r = 0; r + 1 < rings; ++r) {
    for (int k = 0; k < kRoundSides; ++k) {
      const int a = r * kRoundSides + k, b = r * kRoundSides + (k + 1) % kRoundSides;
      out.corners.push_back({a, b, b + kRoundSides});
      out.corners.push_back({a, b + kRoundSides, a + kRoundSides});
    }
  }
  return out;
}

Triangles box_of(const Eigen::Vector3d& size) {
  Triangles out;
  for (int k = 0; k < 8; ++k)
    out.points.emplace_back(0.5 * size.x() * ((k & 1) != 0 ? 1 : -1), 0.5 * size.y() * ((k & 2) != 0 ? 1 : -1), 0.5 * size.z() * ((k & 4) != 0 ? 1 : -1));
  out.corners = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return out;
}

// The surface in the shape's own axes [m].
Triangles surface_of(const LinkShape& shape) {
  using Kind = LinkShape::Kind;
  if (shape.kind == Kind::kMesh) return {shape.points, shape.triangles};
  if (shape.kind == Kind::kBox) return box_of(shape.size);
  const double r = shape.size.x();
  if (shape.kind == Kind::kCylinder) {
    const double half = 0.5 * shape.size.z();
    return of_rings({{0.0, -half}, {r, -half}, {r, half}, {0.0, half}});
  }
  std::vector<std::pair<double, double>> rings;
  for (int k = 0; k <= kRoundSides / 2; ++k) {
    const double angle = 2.0 * M_PI * k / kRoundSides;
    rings.emplace_back(r * std::sin(angle), -r * std::cos(angle));
  }
  return of_rings(rings);
}

// Merges the points in each cell of a grid; triangles that lose a corner are dropped.
Triangles on_coarse_grid(const Triangles& fine, double cell) {
  Triangles out;
  std::map<std::array<long, 3>, int> known;
  std::vector<int> where;
  for (const Eigen::Vector3d& p : fine.points) {
    const std::array<long, 3> at = {std::lround(p.x() / cell), std::lround(p.y() / cell), std::lround(p.z() / cell)};
    const auto [place, is_new] = known.try_emplace(at, static_cast<int>(out.points.size()));
    if (is_new) out.points.push_back(p);
    where.push_back(place->second);
  }
  for (const auto& t : fine.corners) {
    const std::array<int, 3> c = {where[t[0]], where[t[1]], where[t[2]]};
    if (c[0] != c[1] && c[1] != c[2] && c[2] != c[0]) out.corners.push_back(c);
  }
  return out;
}

// The surface with merged vertices, or its box, if it has more than `most` triangles.
Triangles with_fewer_triangles(const Triangles& whole, int most) {
  if (static_cast<int>(whole.corners.size()) <= most) return whole;
  Eigen::Vector3d low = whole.points.front(), high = low;
  for (const Eigen::Vector3d& p : whole.points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double longest = (high - low).maxCoeff();
  for (int cells = kFinestGrid; cells > 3; cells = cells * 4 / 5) {
    Triangles coarse = on_coarse_grid(whole, longest / cells);
    if (static_cast<int>(coarse.corners.size()) <= most) return coarse;
  }
  Triangles box = box_of(high - low);
  for (Eigen::Vector3d& p : box.points) p += 0.5 * (low + high);
  return box;
}

// A surface in the shape's axes, written in those of its frame.
Json mesh_json(int frame, const LinkShape& shape, const Triangles& surface) {
  const auto n = static_cast<Eigen::Index>(surface.points.size());
  MatrixXd points(n, 3);
  for (Eigen::Index k = 0; k < n; ++k) points.row(k) = (shape.pose * surface.points[k]).transpose();
  VectorXd corners(3 * static_cast<Eigen::Index>(surface.corners.size()));
  for (Eigen::Index k = 0; k < corners.size(); ++k) corners[k] = surface.corners[k / 3][k % 3];
  return {{"frame", frame}, {"colour", shape.colour}, {"x", packed_values(points.col(0))}, {"y", packed_values(points.col(1))},
          {"z", packed_values(points.col(2))}, {"corners", packed_values(corners)}};
}

}  // namespace

Json meshes_json(const Model& arm) {
  Json out = Json::array();
  const std::filesystem::path file = arm.description().source;
  std::error_code ignored;
  if (robot_format(file.string()) != RobotFormat::kUrdf || !std::filesystem::is_regular_file(file, ignored)) return out;
  LinkShapes read;
  try {
    read = urdf_shapes(file.string(), UrdfShapes::kVisual);
    if (read.shapes.empty()) read = urdf_shapes(file.string(), UrdfShapes::kCollision);
  } catch (const InvalidInput&) {
    return out;  // the file has changed in the meantime; the page shows rods instead
  }
  if (read.shapes.empty()) return out;
  const int most = kTrianglesOfArm / static_cast<int>(read.shapes.size());
  for (const LinkShape& shape : read.shapes) {
    const std::optional<FrameIndex> frame = arm.find_frame(shape.frame);
    if (frame) out.push_back(mesh_json(frame->value, shape, with_fewer_triangles(surface_of(shape), std::max(12, most))));
  }
  return out;
}

}  // namespace veridyn
