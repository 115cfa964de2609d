#include "veridyn/files/link_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <pugixml.hpp>
#include <sstream>

#include "math/eigen_pose.hpp"
#include "math/decompositions.hpp"
#include "model/joint_placement.hpp"
#include "files/mesh_file.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

namespace fs = std::filesystem;
using Points = std::vector<Eigen::Vector3d>;

constexpr int kMostHalvings = 2;        // halvings of a mesh: at most four capsules
constexpr double kWorthTwo = 0.75;      // largest volume of two capsules relative to that of one, for which two are used
constexpr double kWider[] = {1.0, 1.1, 1.25, 1.5};  // radii that are tried, relative to the smallest: a wider capsule may be shorter

Eigen::Vector3d three_numbers(const pugi::xml_attribute& words, const Eigen::Vector3d& otherwise) {
  if (!words) return otherwise;
  std::istringstream in(words.value());
  Eigen::Vector3d out;
  return in >> out.x() >> out.y() >> out.z() ? out : otherwise;
}

Eigen::Isometry3d origin_of(const pugi::xml_node& shape) {
  const pugi::xml_node origin = shape.child("origin");
  const Eigen::Vector3d rpy = three_numbers(origin.attribute("rpy"), {0, 0, 0});
  return eigen(Posed{rotation_from_rpy(from_eigen(rpy)), from_eigen(three_numbers(origin.attribute("xyz"), {0, 0, 0}))});
}

// The path of a mesh's file, or nullopt if there is none.
std::optional<std::string> mesh_path(const std::string& name, const fs::path& urdf) {
  std::vector<fs::path> folders;
  std::error_code ignored;
  for (fs::path at = fs::absolute(urdf, ignored).parent_path(); at != at.parent_path(); at = at.parent_path())
    folders.push_back(at);
  std::string rest = name;
  const bool package_command = name.rfind("package://", 0) == 0;
  if (package_command) rest = name.substr(10);
  if (name.rfind("file://", 0) == 0) rest = name.substr(7);
  if (!package_command) folders.resize(std::min<size_t>(1, folders.size()));
  if (const char* own = std::getenv("ROS_PACKAGE_PATH"); own != nullptr && package_command) {
    std::istringstream in(own);
    for (std::string folder; std::getline(in, folder, ':');) folders.emplace_back(folder);
  }
  const auto slash = rest.find('/');
  for (const fs::path& folder : folders) {
    if (fs::is_regular_file(folder / rest, ignored)) return (folder / rest).string();
    // A package's folder may have another name than the package.
    if (package_command && slash != std::string::npos && fs::is_regular_file(folder / rest.substr(slash + 1), ignored))
      return (folder / rest.substr(slash + 1)).string();
  }
  return std::nullopt;
}

std::string hex_colour(const pugi::xml_node& shape, const pugi::xml_node& robot) {
  pugi::xml_node material = shape.child("material");
  if (material && !material.child("color")) {
    for (const pugi::xml_node known : robot.children("material"))
      if (std::string(known.attribute("name").value()) == material.attribute("name").value()) material = known;
  }
  const Eigen::Vector3d rgb = three_numbers(material.child("color").attribute("rgba"), {-1, -1, -1});
  if (rgb.minCoeff() < 0.0) return "";
  char out[8];
  std::snprintf(out, sizeof out, "#%02x%02x%02x", static_cast<unsigned>(std::min(1.0, rgb.x()) * 255.0),
                static_cast<unsigned>(std::min(1.0, rgb.y()) * 255.0), static_cast<unsigned>(std::min(1.0, rgb.z()) * 255.0));
  return out;
}

void read_mesh_shape(const pugi::xml_node& mesh, const std::string& urdf, LinkShape& shape) {
  const std::string name = mesh.attribute("filename").value();
  const std::optional<std::string> path = mesh_path(name, urdf);
  require(path.has_value(), "found no file '", name, "'.");
  Mesh read = read_mesh(*path);
  const Eigen::Vector3d scale = three_numbers(mesh.attribute("scale"), {1, 1, 1});
  for (Eigen::Vector3d& p : read.points) p = p.cwiseProduct(scale).eval();
  shape.kind = LinkShape::Kind::kMesh;
  shape.points = std::move(read.points);
  shape.triangles = std::move(read.triangles);
}

// False if the geometry has no size.
bool read_geometry(const pugi::xml_node& geometry, const std::string& urdf, LinkShape& shape) {
  using Kind = LinkShape::Kind;
  if (const pugi::xml_node box = geometry.child("box")) {
    shape.kind = Kind::kBox;
    shape.size = three_numbers(box.attribute("size"), {0, 0, 0});
  } else if (const pugi::xml_node cylinder = geometry.child("cylinder")) {
    shape.kind = Kind::kCylinder;
    const double radius = cylinder.attribute("radius").as_double();
    shape.size = {radius, radius, cylinder.attribute("length").as_double()};
  } else if (const pugi::xml_node sphere = geometry.child("sphere")) {
    shape.kind = Kind::kSphere;
    shape.size.setConstant(sphere.attribute("radius").as_double());
  } else if (const pugi::xml_node mesh = geometry.child("mesh")) {
    read_mesh_shape(mesh, urdf, shape);
    return true;
  }
  return shape.size.allFinite() && shape.size.minCoeff() > 0.0;
}

// The shortest capsule of a given direction and radius around points.
struct Fitted {
  Eigen::Vector3d from{0, 0, 0}, to{0, 0, 0};
  double radius = 0.0;
  // [m^3] of the capsule.
  double volume() const {
    return M_PI * radius * radius * ((to - from).norm() + 4.0 / 3.0 * radius);
  }
};

// A capsule about the points with its axis along a unit vector: of several radii, the one with the least volume.
Fitted capsule_along(const Points& points, const Eigen::Vector3d& along) {
  const Eigen::Vector3d u = along.unitOrthogonal();
  const Eigen::Vector3d v = along.cross(u);
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e300);
  Eigen::Vector2d high = -low;
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector2d across(p.dot(u), p.dot(v));
    low = low.cwiseMin(across);
    high = high.cwiseMax(across);
  }
  const Eigen::Vector2d middle = 0.5 * (low + high);
  double least = 0.0;
  for (const Eigen::Vector3d& p : points)
    least = std::max(least, (Eigen::Vector2d(p.dot(u), p.dot(v)) - middle).norm());
  Fitted best;
  for (const double wider : kWider) {
    const double radius = wider * least * (1.0 + 1e-9);
    double first = 1e300, last = -1e300;  // ends of the segment: every point is within the radius of it
    for (const Eigen::Vector3d& p : points) {
      const double across = (Eigen::Vector2d(p.dot(u), p.dot(v)) - middle).norm();
      const double beyond = std::sqrt(std::max(0.0, radius * radius - across * across));
      first = std::min(first, p.dot(along) + beyond);
      last = std::max(last, p.dot(along) - beyond);
    }
    // If the ends have crossed, a point between them is close enough to all points.
    if (first > last) first = last = 0.5 * (first + last);
    const Eigen::Vector3d on_line = middle.x() * u + middle.y() * v;
    const Fitted next{on_line + first * along, on_line + last * along, radius};
    if (best.radius == 0.0 || next.volume() < best.volume()) best = next;
  }
  return best;
}

Fitted capsule_of(const Points& points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) mean += p / static_cast<double>(points.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points) spread += (p - mean) * (p - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(spread);
  Fitted best;
  for (int k = 0; k < 6; ++k) {
    const Eigen::Vector3d along = k < 3 ? Eigen::Vector3d::Unit(k) : Eigen::Vector3d(principal.eigenvectors().col(k - 3));
    const Fitted next = capsule_along(points, along.normalized());
    if (best.radius == 0.0 || next.volume() < best.volume()) best = next;
  }
  return best;
}

Points used_points(const Points& points, const std::vector<std::array<int, 3>>& triangles) {
  std::vector<char> used(points.size(), 0);
  for (const auto& t : triangles)
    for (const int c : t) used[c] = 1;
  Points out;
  for (size_t k = 0; k < points.size(); ++k)
    if (used[k] != 0) out.push_back(points[k]);
  return out;
}

// Every triangle belongs to one part. The part's capsule contains all of the triangle, since it is convex.
std::vector<Fitted> capsules_of(const Points& points, const std::vector<std::array<int, 3>>& triangles, int halvings) {
  const Fitted whole = capsule_of(used_points(points, triangles));
  if (halvings == 0 || triangles.size() < 2) return {whole};
  const Eigen::Vector3d along = whole.to - whole.from;
  std::vector<double> at;
  for (const auto& t : triangles)
    at.push_back(along.dot(points[t[0]] + points[t[1]] + points[t[2]]) / 3.0);
  const auto [low, high] = std::minmax_element(at.begin(), at.end());
  const double middle = 0.5 * (*low + *high);
  std::vector<std::array<int, 3>> halves[2];
  for (size_t k = 0; k < triangles.size(); ++k) halves[at[k] > middle ? 1 : 0].push_back(triangles[k]);
  if (halves[0].empty() || halves[1].empty()) return {whole};
  std::vector<Fitted> parts;
  double volume = 0.0;
  for (const auto& half : halves) {
    for (const Fitted& part : capsules_of(points, half, halvings - 1)) {
      parts.push_back(part);
      volume += part.volume();
    }
  }
  return volume < kWorthTwo * whole.volume() ? parts : std::vector<Fitted>{whole};
}

}  // namespace

LinkShapes urdf_shapes(const std::string& path, UrdfShapes which) {
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_file(path.c_str());
  require(bool(parsed), path, ": found no XML (", parsed.description(), "), expected a URDF file.");
  const char* const element = which == UrdfShapes::kVisual ? "visual" : "collision";
  const pugi::xml_node robot = document.child("robot");
  LinkShapes out;
  for (const pugi::xml_node link : robot.children("link")) {
    for (const pugi::xml_node node : link.children(element)) {
      LinkShape shape;
      shape.frame = link.attribute("name").value();
      shape.pose = origin_of(node);
      shape.colour = hex_colour(node, robot);
      try {
        if (read_geometry(node.child("geometry"), path, shape)) out.shapes.push_back(std::move(shape));
      } catch (const InvalidInput& error) {
        out.remarks.push_back("The shape of '" + shape.frame + "' is left out: " + error.what());
      }
    }
  }
  return out;
}

std::vector<Capsule> capsules_around(const LinkShape& shape) {
  std::vector<Fitted> fitted;
  const Eigen::Vector3d half = 0.5 * shape.size;
  if (shape.kind == LinkShape::Kind::kSphere) {
    fitted = {{{0, 0, 0}, {0, 0, 0}, shape.size.x()}};
  } else if (shape.kind == LinkShape::Kind::kMesh) {
    fitted = capsules_of(shape.points, shape.triangles, kMostHalvings);
  } else {
    // A cylinder is contained in the capsule of a circumscribed prism with 32 sides.
    Points corners;
    const int sides = shape.kind == LinkShape::Kind::kBox ? 4 : 32;
    for (int k = 0; k < sides; ++k) {
      const double angle = 2.0 * M_PI * (k + 0.5) / sides;
      const double reach = 1.0 / std::cos(M_PI / sides);
      Eigen::Vector3d corner(reach * std::cos(angle), reach * std::sin(angle), 0.0);
      const double radius = shape.kind == LinkShape::Kind::kBox ? 0.5 : 1.0;
      corner = radius * corner.cwiseProduct(shape.size).eval();
      corners.emplace_back(corner.x(), corner.y(), -half.z());
      corners.emplace_back(corner.x(), corner.y(), half.z());
    }
    fitted = {capsule_of(corners)};
  }
  std::vector<Capsule> out;
  for (const Fitted& f : fitted) out.push_back({shape.frame, shape.pose * f.from, shape.pose * f.to, f.radius});
  return out;
}

std::vector<Capsule> collision_capsules(const std::string& urdf, std::vector<std::string>& remarks) {
  LinkShapes read = urdf_shapes(urdf, UrdfShapes::kCollision);
  remarks = std::move(read.remarks);
  std::vector<Capsule> out;
  for (const LinkShape& shape : read.shapes)
    for (Capsule& capsule : capsules_around(shape)) out.push_back(std::move(capsule));
  return out;
}

std::vector<Capsule> capsules_along_links(const Model& arm, double radius) {
  require(radius > 0.0 && std::isfinite(radius), "links: found a radius of ", radius, " m, expected a positive one.");
  std::vector<Capsule> out;
  const auto add = [&](const std::string& frame, const Eigen::Vector3d& to) {
    if (to.norm() > 1e-9) out.push_back({frame, {0, 0, 0}, to, radius});
  };
  for (const Frame& frame : arm.frames()) {
    // The segment up to the joint belongs to the parent, the rest to the frame.
    add(frame.parent ? arm.frames()[frame.parent->value].name : "world", eigen(frame.A.p));
    add(frame.name, eigen(inverse(frame.B).p));
  }
  return out;
}

}  // namespace veridyn
