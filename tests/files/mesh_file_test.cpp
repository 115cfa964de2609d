#include "files/mesh_file.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "files/output_file.hpp"
#include "support/refusal.hpp"

namespace veridyn {
namespace {

using Corners = std::vector<std::array<int, 3>>;

class MeshFile : public testing::Test {
 protected:
  ~MeshFile() override { std::filesystem::remove_all(folder_); }

  Mesh read(const std::string& name, const std::string& content) const { return read_mesh(written(name, content)); }
  std::string error(const std::string& name, const std::string& content) const {
    const std::string path = written(name, content);
    return refusal([&] { read_mesh(path); });
  }

 private:
  std::string written(const std::string& name, const std::string& content) const {
    std::filesystem::create_directories(folder_);
    const std::string path = (folder_ / name).string();
    write_file(path, content);
    return path;
  }

  std::filesystem::path folder_ = std::filesystem::temp_directory_path() /
                                  ("veridyn-mesh-" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
};

// 80 bytes of text, a count, and triangles of a normal, three corners and two bytes each.
std::string binary_stl(const std::vector<std::array<float, 9>>& triangles, std::uint32_t count) {
  std::string out(80, ' ');
  const auto add = [&out](const void* bytes, std::size_t size) { out.append(static_cast<const char*>(bytes), size); };
  add(&count, sizeof count);
  for (const std::array<float, 9>& corners : triangles) {
    const std::array<float, 3> normal{};
    add(normal.data(), sizeof normal);
    add(corners.data(), sizeof corners);
    out.append(2, '\0');
  }
  return out;
}

const std::vector<std::array<float, 9>> kTwo = {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {1, 0, 0, 0, 1, 0, 1, 1, 0.5F}};

TEST_F(MeshFile, CoincidentCornersAreMergedIntoOnePoint) {
  const Mesh mesh = read("two.STL", binary_stl(kTwo, 2));
  ASSERT_EQ(mesh.points.size(), 4U);
  EXPECT_EQ(mesh.points[3], Eigen::Vector3d(1, 1, 0.5));
  EXPECT_EQ(mesh.triangles, (Corners{{0, 1, 2}, {1, 2, 3}}));
  const Mesh text = read("two.stl",
                         "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
                         "facet\nouter loop\nvertex 1 0 0\nvertex 0 1 0\nvertex 1 1 5e-1\nendloop\nendfacet\nendsolid\n");
  EXPECT_EQ(text.points, mesh.points);
  EXPECT_EQ(text.triangles, mesh.triangles);
}

TEST_F(MeshFile, PositiveAndNegativeFaceIndicesOfAnObjAreRead) {
  const std::string points = "# a square\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\n";
  EXPECT_EQ(read("a.obj", points + "f 1 2 3\n").triangles, (Corners{{0, 1, 2}}));
  EXPECT_EQ(read("b.obj", points + "f 1//1 2//1 3//1 4//1\n").triangles, (Corners{{0, 1, 2}, {0, 2, 3}}));
  // -1 is the last point before the face, also where further points follow.
  EXPECT_EQ(read("c.obj", points + "f -4 -2 -1\nv 5 5 5\nf -1 1 2\n").triangles, (Corners{{0, 2, 3}, {4, 0, 1}}));
}

TEST_F(MeshFile, DamagedMeshesAreRefused) {
  const std::string points = "v 0 0 0\nv 1 0 0\nv 1 1 0\n";
  EXPECT_NE(error("a.obj", points + "f 1 2 4\n").find("the point 4, expected 1 to 3."), std::string::npos);
  EXPECT_NE(error("a.obj", points + "f 0 1 2\n").find("the point 0, expected 1 to 3."), std::string::npos);
  EXPECT_NE(error("a.obj", points + "f -4 1 2\n").find("the point -4, expected 1 to 3."), std::string::npos);
  EXPECT_NE(error("a.obj", points + "f one 1 2\n").find("the point one"), std::string::npos);
  EXPECT_NE(error("a.obj", points + "f 9223372036854775808 1 2\n").find("the point 9223372036854775808"), std::string::npos);
  EXPECT_NE(error("a.obj", points + "f 1 2\n").find("no triangles"), std::string::npos);
  EXPECT_NE(error("a.obj", "v 0 0\n").find("without three numbers"), std::string::npos);
  EXPECT_NE(error("a.stl", binary_stl(kTwo, 3)).find("neither a text STL"), std::string::npos);
  EXPECT_NE(error("a.stl", binary_stl(kTwo, 0xFFFFFFFFU)).find("neither a text STL"), std::string::npos);
  EXPECT_NE(error("a.stl", binary_stl({{0, 0, 0, 1, 0, 0, 0, std::numeric_limits<float>::quiet_NaN(), 0}}, 1)).find("no finite number"),
            std::string::npos);
  EXPECT_NE(error("a.stl", "solid\nvertex 0 0 0\nvertex 1 0 0\n").find("found 2 vertices"), std::string::npos);
  EXPECT_NE(error("a.stl", "solid\nvertex 0 0 nan\n").find("without three numbers"), std::string::npos);
  EXPECT_NE(error("a.stl", "").find("neither a text STL"), std::string::npos);
  EXPECT_NE(error("a.dae", "<COLLADA/>").find("expected .stl or .obj"), std::string::npos);
  EXPECT_NE(refusal([] { read_mesh("/no/such.stl"); }).find("/no/such.stl"), std::string::npos);
}

}  // namespace
}  // namespace veridyn
