#include "files/mesh_file.hpp"

#include <cctype>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <sstream>

#include "files/input_file.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr std::size_t kStlHeader = 84;    // 80 bytes of text and the number of triangles
constexpr std::size_t kStlTriangle = 50;  // a normal and three corners as floats, then two bytes

void require_finite(const std::string& path, const Eigen::Vector3d& p) {
  require(p.allFinite(), path, ": found a vertex that is no finite number.");
}

// Merges corners that coincide.
class MeshPoints {
 public:
  MeshPoints(const std::string& path, Mesh& mesh) : path_(path), mesh_(mesh) {}

  // Index of a point in the mesh, which gets it if it is new.
  int index_of(const Eigen::Vector3d& p) {
    require_finite(path_, p);
    const auto [at, is_new] = known_.try_emplace({p.x(), p.y(), p.z()}, static_cast<int>(mesh_.points.size()));
    if (is_new) mesh_.points.push_back(p);
    return at->second;
  }

 private:
  const std::string& path_;
  Mesh& mesh_;
  std::map<std::array<double, 3>, int> known_;
};

Mesh read_binary_stl(const std::string& path, const std::string& bytes, std::size_t count) {
  Mesh out;
  MeshPoints points(path, out);
  for (std::size_t k = 0; k < count; ++k) {
    std::array<int, 3> corners{};
    for (std::size_t c = 0; c < 3; ++c) {
      float xyz[3];
      std::memcpy(xyz, bytes.data() + kStlHeader + k * kStlTriangle + 12 * (c + 1), sizeof xyz);
      corners[c] = points.index_of({xyz[0], xyz[1], xyz[2]});
    }
    out.triangles.push_back(corners);
  }
  return out;
}

Mesh read_text_stl(const std::string& path, const std::string& content) {
  Mesh out;
  MeshPoints points(path, out);
  std::istringstream words(content);
  std::vector<int> corners;
  for (std::string word; words >> word;) {
    if (word != "vertex") continue;
    Eigen::Vector3d p;
    require(bool(words >> p.x() >> p.y() >> p.z()), path, ": found a vertex without three numbers.");
    corners.push_back(points.index_of(p));
  }
  require(corners.size() % 3 == 0, path, ": found ", corners.size(), " vertices, expected three a triangle.");
  for (std::size_t k = 0; k < corners.size(); k += 3)
    out.triangles.push_back({corners[k], corners[k + 1], corners[k + 2]});
  return out;
}

Mesh read_obj(const std::string& path, const std::string& content) {
  Mesh out;
  std::istringstream lines(content);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "v") {
      Eigen::Vector3d p;
      require(bool(words >> p.x() >> p.y() >> p.z()), path, ": found a vertex without three numbers.");
      require_finite(path, p);
      out.points.push_back(p);
    }
    if (word != "f") continue;
    std::vector<int> corners;
    // Corners are point/texture/normal; negative numbers count from the last point.
    while (words >> word) {
      const long number = std::strtol(word.c_str(), nullptr, 10);
      const long index = number < 0 ? static_cast<long>(out.points.size()) + number : number - 1;
      require(index >= 0 && index < static_cast<long>(out.points.size()), path, ": found a face with the point ",
              word, ", expected 1 to ", out.points.size(), ".");
      corners.push_back(static_cast<int>(index));
    }
    for (std::size_t k = 2; k < corners.size(); ++k)
      out.triangles.push_back({corners[0], corners[k - 1], corners[k]});
  }
  return out;
}

Mesh read_stl(const std::string& path, const std::string& content) {
  if (content.size() >= kStlHeader) {
    std::uint32_t count = 0;
    std::memcpy(&count, content.data() + 80, sizeof count);
    if (content.size() == kStlHeader + kStlTriangle * count) return read_binary_stl(path, content, count);
  }
  require(content.compare(0, 5, "solid") == 0, path,
          ": found neither a text STL file nor a binary one with the triangles that it counts.");
  return read_text_stl(path, content);
}

}  // namespace

Mesh read_mesh(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  require(ending == ".stl" || ending == ".obj", path, ": found a mesh that ends in '", ending,
          "', expected .stl or .obj.");
  const std::string content = content_of_file(path, "a mesh");
  const Mesh out = ending == ".stl" ? read_stl(path, content) : read_obj(path, content);
  require(!out.triangles.empty(), path, ": found no triangles.");
  return out;
}

}  // namespace veridyn
