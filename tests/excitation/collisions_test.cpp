#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "excitation/cautions.hpp"
#include "excitation/limits/limit_signals.hpp"
#include "excitation/limits/link_gap.hpp"
#include "math/random_numbers.hpp"
#include "veridyn/excitation/excitation.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/link_shapes.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

// A planar arm whose fore arm folds back onto its stand, and a stand that is wider than its links.
std::string folding_urdf() {
  const auto link = [](const char* name, const char* shape, const char* at) {
    return std::string("<link name=\"") + name + "\"><inertial><origin xyz=\"0.2 0 0\"/><mass value=\"2\"/>" +
           "<inertia ixx=\"0.01\" iyy=\"0.03\" izz=\"0.03\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>" +
           "<collision><origin xyz=\"" + at + "\" rpy=\"0 1.5707963 0\"/><geometry>" + shape + "</geometry></collision></link>";
  };
  const auto joint = [](const char* name, const char* parent, const char* child, const char* at) {
    return std::string("<joint name=\"") + name + "\" type=\"revolute\"><parent link=\"" + parent + "\"/><child link=\"" +
           child + "\"/><origin xyz=\"" + at + "\"/><axis xyz=\"0 1 0\"/>" +
           "<limit lower=\"-2.9\" upper=\"2.9\" velocity=\"2\" effort=\"200\"/></joint>";
  };
  return "<robot name=\"folding\"><link name=\"stand\"><collision><geometry><box size=\"0.2 0.2 0.3\"/></geometry></collision></link>" +
         link("upper", "<cylinder radius=\"0.04\" length=\"0.4\"/>", "0.2 0 0") +
         link("fore", "<cylinder radius=\"0.03\" length=\"0.4\"/>", "0.2 0 0") +
         link("hand", "<sphere radius=\"0.05\"/>", "0.05 0 0") + joint("shoulder", "stand", "upper", "0 0 0.3") +
         joint("elbow", "upper", "fore", "0.4 0 0") + joint("wrist", "fore", "hand", "0.42 0 0") + "</robot>";
}

class Files {
 public:
  explicit Files(const char* name)
      : folder_(std::filesystem::temp_directory_path() / (std::string(name) + "-" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~Files() { std::filesystem::remove_all(folder_); }
  Files(const Files&) = delete;
  Files& operator=(const Files&) = delete;
  std::string write(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    return folder_ / name;
  }

 private:
  std::filesystem::path folder_;
};

std::string folding_path() {
  static const Files kFiles("veridyn-collisions");
  static const std::string kPath = kFiles.write("folding.urdf", folding_urdf());
  return kPath;
}

// Distance of a point from a segment, and of two segments by points along the first.
double distance_to(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d along = b - a;
  const double s = along.squaredNorm() > 0.0 ? std::clamp(along.dot(p - a) / along.squaredNorm(), 0.0, 1.0) : 0.0;
  return (p - a - s * along).norm();
}

double by_points(const FramePoints& at, const Model& arm, const Capsule& a, const Capsule& b) {
  const auto place = [&](const Capsule& c, const Eigen::Vector3d& p) {
    return c.frame == "world" ? p : at.point(*arm.find_frame(c.frame), p);
  };
  double least = 1e9;
  for (int k = 0; k <= 400; ++k) {
    const Eigen::Vector3d p = place(a, a.from + k / 400.0 * (a.to - a.from));
    least = std::min(least, distance_to(p, place(b, b.from), place(b, b.to)));
  }
  return least - a.radius - b.radius;
}

std::vector<Capsule> folding_capsules() {
  std::vector<std::string> remarks;
  const std::vector<Capsule> out = collision_capsules(folding_path(), remarks);
  EXPECT_TRUE(remarks.empty());
  return out;
}

ExcitationOptions short_search() {
  ExcitationOptions options;
  options.starts = 1;
  options.iterations = 30;
  return options;
}

// The smallest gap of a pair along a motion, on a grid ten times as fine as any of the search.
double smallest_gap(const Model& arm, const Excitation& e, const CollisionPair& pair) {
  const MotionSamples m = e.trajectory.samples(period_instants(e.trajectory.frequency(), 4001));
  FramePoints at(arm);
  double least = 1e9;
  for (Eigen::Index row = 0; row < m.rows(); ++row) {
    at.move_to(m.q.row(row));
    for (const Capsule& a : pair.capsules) {
      for (const Capsule& b : pair.others) least = std::min(least, by_points(at, arm, a, b));
      if (!pair.obstacle) continue;
      for (const Eigen::Vector3d& end : {a.from, a.to})
        least = std::min(least, at.point(*arm.find_frame(a.frame), end).z() - pair.obstacle->upper.z() - a.radius);
    }
  }
  return least;
}

TEST(Collisions, LinksKeepTheirClearanceAndStayAboveTheFloor) {
  const Model arm = read_model(folding_path());
  const Obstacle floor{"floor", {-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, -0.1}};
  ExcitationOptions options = short_search();
  const CollisionLimits kept = collision_limits(arm, folding_capsules(), {floor});
  std::vector<std::string> names;
  for (const CollisionPair& pair : kept.pairs) names.push_back(pair.first + " and " + pair.second);
  EXPECT_EQ(names, (std::vector<std::string>{"stand and fore", "stand and hand", "upper and hand", "upper and floor",
                                             "fore and floor", "hand and floor"}));
  options.workspace.collisions = kept;
  const Excitation e = optimise_excitation(arm, options);
  ASSERT_EQ(e.status, ExcitationStatus::kDone);
  for (const CollisionPair& pair : kept.pairs) EXPECT_GE(smallest_gap(arm, e, pair), kLinkClearance - 1e-6) << pair.first << pair.second;
  EXPECT_NE(e.report().find("gap of "), std::string::npos);
  // Without the limits the links meet: the test could fail.
  options.workspace.collisions = {};
  const Excitation free = optimise_excitation(arm, options);
  double least = 1e9;
  for (const CollisionPair& pair : kept.pairs) least = std::min(least, smallest_gap(arm, free, pair));
  EXPECT_LT(least, 0.0);
  EXPECT_EQ(free.report().find("gap of "), std::string::npos);
}

TEST(Collisions, GapsEqualTheLeastDistanceOfSampledAxisPoints) {
  const Model arm = read_model(folding_path());
  const std::vector<Capsule> capsules = folding_capsules();
  RandomNumbers random(3);
  FramePoints at(arm);
  for (int k = 0; k < 200; ++k) {
    VectorXd q(3);
    for (int i = 0; i < 3; ++i) q[i] = random.uniform(-2.9, 2.9);
    at.move_to(q);
    for (size_t a = 0; a < capsules.size(); ++a) {
      for (size_t b = 0; b < capsules.size(); ++b) {
        if (a == b) continue;
        const LinkGap gap(arm, {"a", "b", {capsules[a]}, {capsules[b]}, {}, 0.0});
        const double points = by_points(at, arm, capsules[a], capsules[b]);
        EXPECT_LE(gap.nearest(at).gap, points + 1e-9);
        EXPECT_NEAR(gap.nearest(at).gap, points, 2e-3);
      }
      const Obstacle box{"box", {0.1, -0.2, 0.0}, {0.5, 0.2, 0.4}};
      const LinkGap gap(arm, {"a", "box", {capsules[a]}, {}, box, 0.0});
      const auto nearest = gap.nearest(at);
      if (nearest.gap + capsules[a].radius < 1e-6) continue;  // the axis is inside
      double points = 1e9;
      for (int s = 0; s <= 400; ++s) {
        const Eigen::Vector3d p =
            at.point(*arm.find_frame(capsules[a].frame), capsules[a].from + s / 400.0 * (capsules[a].to - capsules[a].from));
        points = std::min(points, (p - p.cwiseMax(box.lower).cwiseMin(box.upper)).norm());
      }
      EXPECT_LE(nearest.gap, points - capsules[a].radius + 1e-9);
      EXPECT_NEAR(nearest.gap, points - capsules[a].radius, 2e-3);
    }
  }
}

TEST(Collisions, GradientsMatchCentralDifferences) {
  const Model arm = read_model(folding_path());
  CollisionLimits limits = collision_limits(arm, folding_capsules(), {{"table", {0.2, -1, -1}, {0.6, 1, -0.2}}});
  WorkspaceLimits workspace;
  workspace.collisions = limits;
  const LimitSignals signals(arm, motion_limits(arm), workspace, std::nullopt);
  const auto values = [&](const VectorXd& q) {
    MotionSamples one;
    one.time = VectorXd::Zero(1);
    one.q = q.transpose();
    one.dq = one.ddq = MatrixXd::Zero(1, 3);
    return std::make_pair(signals.values(one), signals.derivatives(one));
  };
  RandomNumbers random(7);
  for (int k = 0; k < 40; ++k) {
    VectorXd q(3);
    for (int i = 0; i < 3; ++i) q[i] = random.uniform(-2.0, 2.0);
    const auto [at_q, slopes] = values(q);
    for (int i = 0; i < 3; ++i) {
      const VectorXd step = 1e-6 * VectorXd::Unit(3, i);
      const VectorXd difference = (values(q + step).first - values(q - step).first).transpose() / 2e-6;
      for (Eigen::Index s = 0; s < difference.size(); ++s) {
        if (at_q(0, s) < -0.06) continue;  // axes that nearly cross have no direction
        EXPECT_NEAR(slopes[s](0, i), difference[s], 1e-4) << k << " " << s;
      }
    }
  }
}

TEST(Collisions, LinksThatTouchInEveryPostureAreReportedAndNotLimited) {
  const Model arm = read_model(folding_path());
  std::vector<Capsule> capsules = folding_capsules();
  capsules.push_back({"hand", {0, 0, 0}, {0, 0, 0}, 0.5});  // reaches back to the elbow
  const CollisionLimits limits = collision_limits(arm, capsules);
  EXPECT_EQ(limits.touching, std::vector<std::string>{"upper and hand"});
  for (const CollisionPair& pair : limits.pairs) EXPECT_FALSE(pair.first == "upper" && pair.second == "hand");
  EXPECT_THROW(collision_limits(arm, {{"nowhere", {0, 0, 0}, {1, 0, 0}, 0.1}}), InvalidInput);
}

// What is to be kept clear of is kept or named: a floor above the shoulder, which no posture leaves; one
// that the links reach in some postures; and a turntable, whose mount the floor is.
TEST(Collisions, AnObstacleIsKeptAsALimitOrReportedAsImpossible) {
  const Model arm = read_model(folding_path());
  const auto floor_at = [](double z) { return Obstacle{"floor", {-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, z}}; };
  const auto with_floor = [&](double z) { return collision_limits(arm, folding_capsules(), {floor_at(z)}); };
  EXPECT_EQ(with_floor(0.28).impossible, std::vector<std::string>{"upper and floor"});
  EXPECT_TRUE(with_floor(0.2).impossible.empty());
  for (const double z : {0.28, 0.2}) {
    const CollisionLimits limits = with_floor(z);
    EXPECT_TRUE(limits.touching.empty());
    EXPECT_EQ(std::count_if(limits.pairs.begin(), limits.pairs.end(), [](const CollisionPair& p) { return p.obstacle.has_value(); }), 3);
  }
  ModelDescription d = arm.description();
  d.frames[arm.find_frame("upper")->value].A = identity_pose();  // about the world's z axis
  const Model table(std::move(d));
  const Capsule disc{"upper", {0, 0, 0}, {0, 0, 0.1}, 0.05};
  EXPECT_EQ(collision_limits(table, {disc}, {floor_at(0.0)}).touching, std::vector<std::string>{"upper and floor"});
  EXPECT_EQ(collision_limits(table, {disc}, {floor_at(0.04)}).impossible, std::vector<std::string>{"upper and floor"});
}

// The first lines say what was not checked, with the option that does.
TEST(Cautions, UncheckedCollisionsAndAssumedLimitsAreListed) {
  ModelDescription d = read_model(folding_path()).description();
  d.coordinates[1].limits.velocity = INFINITY;
  d.coordinates[2].limits.effort = INFINITY;
  const Model arm(std::move(d));
  ExcitationOptions options = short_search();
  const Excitation bare = optimise_excitation(arm, options);
  ASSERT_EQ(bare.cautions.size(), 4U) << bare.report();
  EXPECT_EQ(bare.report().find(bare.cautions[0]), 0U) << bare.report();
  EXPECT_EQ(bare.cautions[0].find("NOT CHECKED: neither the floor nor self-collision"), 0U) << bare.cautions[0];
  EXPECT_NE(bare.cautions[0].find("--link-radius"), std::string::npos);
  EXPECT_EQ(bare.cautions[1].find("ASSUMED: at most 2 rad/s"), 0U) << bare.cautions[1];
  EXPECT_NE(bare.cautions[1].find("elbow"), std::string::npos);
  EXPECT_EQ(bare.cautions[2].find("NOT LIMITED: torques of wrist"), 0U) << bare.cautions[2];
  EXPECT_NE(bare.cautions[3].find("no values of friction"), std::string::npos) << bare.cautions[3];
  FramePoints at(arm);
  double lowest = 1e9;
  for (Eigen::Index row = 0; row < bare.motion.rows(); ++row) {
    at.move_to(bare.motion.q.row(row).transpose());
    for (int k = 1; k < static_cast<int>(arm.frames().size()); ++k) lowest = std::min(lowest, at.point(FrameIndex{k}, {0, 0, 0}).z());
  }
  EXPECT_NEAR(bare.lowest.z, lowest, 1e-12);
  options.workspace.collisions = collision_limits(arm, folding_capsules());
  const Excitation shaped = optimise_excitation(arm, options);
  EXPECT_EQ(shaped.cautions[0].find("NOT CHECKED: the floor;"), 0U) << shaped.cautions[0];
  EXPECT_LE(shaped.lowest.z, smallest_gap(arm, shaped, {"hand", "floor", folding_capsules(), {}, Obstacle{"floor", {0, 0, 0}, {0, 0, 0}}, 0.0}) + 1e-6);
  options.workspace.collisions = collision_limits(arm, folding_capsules(), {{"floor", {-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, -0.3}}});
  const Excitation floored = optimise_excitation(arm, options);
  EXPECT_EQ(floored.report().find("NOT CHECKED"), std::string::npos) << floored.report();
  EXPECT_GE(floored.lowest.z, -0.3);
}

bool says(const Model& arm, const std::string& words) {
  const std::vector<std::string> all = cautions(arm, {}, {}, {});
  return std::any_of(all.begin(), all.end(), [&](const std::string& one) { return one.find(words) != std::string::npos; });
}

TEST(Cautions, LimitsThatLookLikeDegreesAreQuestioned) {
  const Model arm = read_model("planar-2r");
  EXPECT_FALSE(says(arm, "degrees"));
  ModelDescription d = arm.description();
  d.coordinates[1].limits.velocity = 150.0;
  const Model fast(d);
  EXPECT_TRUE(says(fast, "ASSUMED: rad/s, though few arms are as fast (are these degrees per second?), for the speed limits of elbow (150)"));
  EXPECT_FALSE(says(fast, "two turns"));
  d = arm.description();
  d.coordinates[1].limits.lower = -160.0;
  const Model wide(d);
  EXPECT_TRUE(says(wide, "ASSUMED: rad, though that would be more than two turns (are these degrees?), for the ranges of elbow (-160 to 2.5)"));
  EXPECT_NO_THROW(require_ranges_in_radians(wide, "arm"));  // the shoulder's are rad
  d.coordinates[0].limits.upper = 170.0;
  EXPECT_THROW(require_ranges_in_radians(Model(d), "arm"), InvalidInput);
  d.coordinates[0].limits.upper = 1e4;  // as some files write a joint without an end
  EXPECT_NO_THROW(require_ranges_in_radians(Model(d), "arm"));
  // Metres.
  d = read_model("scara").description();
  for (Coordinate& c : d.coordinates) {
    if (c.prismatic) c.limits.upper = c.limits.velocity = 170.0;
  }
  EXPECT_FALSE(says(Model(d), "degrees"));
}

// The same path, slower: velocities by the share, accelerations by its square.
TEST(Excitation, HalfTheSpeedGivesTheSamePath) {
  const Model arm = read_model(folding_path());
  ExcitationOptions options = short_search();
  const Excitation whole = optimise_excitation(arm, options);
  options.speed = 0.5;
  const Excitation half = optimise_excitation(arm, options);
  ASSERT_EQ(half.status, ExcitationStatus::kDone);
  ASSERT_EQ(half.motion.rows(), 2 * whole.motion.rows() - 1);
  for (Eigen::Index k = 0; k < whole.motion.rows(); k += 50) {
    EXPECT_LT((half.motion.q.row(2 * k) - whole.motion.q.row(k)).norm(), 1e-9);
    EXPECT_LT((2.0 * half.motion.dq.row(2 * k) - whole.motion.dq.row(k)).norm(), 1e-9);
    EXPECT_LT((4.0 * half.motion.ddq.row(2 * k) - whole.motion.ddq.row(k)).norm(), 1e-9);
  }
  EXPECT_NE(whole.report().find("--speed 0.5"), std::string::npos);
}

// Every point of a shape's surface is within its capsules.
void expect_held(const LinkShape& shape, const std::vector<Eigen::Vector3d>& surface) {
  const std::vector<Capsule> capsules = capsules_around(shape);
  for (const Eigen::Vector3d& p : surface) {
    double least = 1e9;
    for (const Capsule& c : capsules) least = std::min(least, distance_to(shape.pose * p, c.from, c.to) - c.radius);
    EXPECT_LT(least, 1e-9) << p.transpose();
  }
}

TEST(Collisions, CapsulesHoldBoxesCylindersAndMeshes) {
  LinkShape shape;
  shape.frame = "world";
  shape.pose = Eigen::Translation3d(0.1, -0.2, 0.3) * Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized());
  RandomNumbers random(5);
  for (const Eigen::Vector3d& size : {Eigen::Vector3d(0.1, 0.2, 0.9), Eigen::Vector3d(0.5, 0.5, 0.1), Eigen::Vector3d(0.3, 0.3, 0.3)}) {
    shape.size = size;
    shape.kind = LinkShape::Kind::kBox;
    std::vector<Eigen::Vector3d> box, cylinder;
    for (int k = 0; k < 500; ++k) {
      Eigen::Vector3d p(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5));
      p[k % 3] = k % 2 == 0 ? 0.5 : -0.5;
      box.push_back(p.cwiseProduct(size));
      const double angle = random.uniform(0.0, 2.0 * M_PI);
      cylinder.emplace_back(size.x() * std::cos(angle), size.x() * std::sin(angle), random.uniform(-0.5, 0.5) * size.z());
    }
    expect_held(shape, box);
    shape.kind = LinkShape::Kind::kCylinder;
    shape.size.y() = shape.size.x();
    expect_held(shape, cylinder);
  }
  // An angle of two boxes needs two capsules; one around both would fill the corner.
  shape.kind = LinkShape::Kind::kMesh;
  const auto slab = [&](const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
    const int first = static_cast<int>(shape.points.size());
    for (int k = 0; k < 8; ++k)
      shape.points.emplace_back((k & 1) != 0 ? high.x() : low.x(), (k & 2) != 0 ? high.y() : low.y(), (k & 4) != 0 ? high.z() : low.z());
    for (const std::array<int, 3>& t : std::vector<std::array<int, 3>>{{0, 1, 3}, {0, 3, 2}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                                        {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 3, 7}, {1, 7, 5}})
      shape.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  };
  slab({0, -0.03, -0.03}, {0.5, 0.03, 0.03});
  slab({0.44, 0.0, -0.03}, {0.5, 0.5, 0.03});
  std::vector<Eigen::Vector3d> inside;
  for (const auto& t : shape.triangles) {
    for (int k = 0; k < 20; ++k) {
      double u = random.uniform(), v = random.uniform();
      if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
      const auto& a = shape.points[t[0]];
      inside.push_back(a + u * (shape.points[t[1]] - a) + v * (shape.points[t[2]] - a));
    }
  }
  expect_held(shape, inside);
  EXPECT_GE(capsules_around(shape).size(), 2u);
}

void append(std::string& bytes, float value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

TEST(Collisions, MeshesAreReadFromStlAndObj) {
  const float corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const int faces[4][3] = {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}};
  std::string binary(80, ' ');
  const std::uint32_t count = 4;
  binary.append(reinterpret_cast<const char*>(&count), 4);
  std::string text = "solid t\n", obj;
  for (const auto& c : corners) obj += "v " + std::to_string(c[0]) + " " + std::to_string(c[1]) + " " + std::to_string(c[2]) + "\n";
  for (const auto& f : faces) {
    for (int k = 0; k < 3; ++k) append(binary, 0.0F);
    text += "facet normal 0 0 0\nouter loop\n";
    obj += "f";
    for (const int c : f) {
      for (const float x : corners[c]) append(binary, x);
      text += "vertex " + std::to_string(corners[c][0]) + " " + std::to_string(corners[c][1]) + " " + std::to_string(corners[c][2]) + "\n";
      obj += " " + std::to_string(c + 1) + "//1";
    }
    text += "endloop\nendfacet\n";
    obj += "\n";
    binary.append(2, '\0');
  }
  const Files own("veridyn-meshes");
  own.write("a.stl", binary);
  own.write("b.stl", text);
  own.write("c.OBJ", obj);
  own.write("d.stl", "no mesh");
  std::string urdf = "<robot name=\"m\">";
  for (const char* name : {"a.stl", "package://anything/b.stl", "c.OBJ", "d.stl", "package://none/e.stl", "f.dae"})
    urdf += std::string("<link name=\"") + name + "\"><visual><origin xyz=\"1 0 0\"/><geometry><mesh filename=\"" + name +
            "\" scale=\"2 2 2\"/></geometry><material name=\"m\"><color rgba=\"1 0 0.5 1\"/></material></visual></link>";
  const LinkShapes read = urdf_shapes(own.write("m.urdf", urdf + "</robot>"), UrdfShapes::kVisual);
  ASSERT_EQ(read.shapes.size(), 3u);
  for (const LinkShape& shape : read.shapes) {
    ASSERT_EQ(shape.points.size(), 4u) << shape.frame;
    EXPECT_EQ(shape.triangles.size(), 4u);
    EXPECT_EQ(shape.points[1], Eigen::Vector3d(2, 0, 0));
    EXPECT_EQ(shape.triangles[3], (std::array<int, 3>{1, 2, 3}));
    EXPECT_EQ(shape.pose.translation(), Eigen::Vector3d(1, 0, 0));
    EXPECT_EQ(shape.colour, "#ff007f");
  }
  EXPECT_EQ(read.remarks.size(), 3u);
}

TEST(Collisions, AnArmWithoutShapesHasCapsulesFromJointToJoint) {
  const Model arm = read_model("ur10e");
  const std::vector<Capsule> capsules = capsules_along_links(arm, 0.05);
  double length = 0.0;
  for (const Capsule& c : capsules) length += (c.to - c.from).norm();
  EXPECT_NEAR(length, 0.1807 + 0.6127 + 0.57155 + 0.17415 + 0.11985 + 0.11655, 1e-9);
  const CollisionLimits limits = collision_limits(arm, capsules);
  EXPECT_FALSE(limits.pairs.empty());
  EXPECT_THROW(capsules_along_links(arm, 0.0), InvalidInput);
}

}  // namespace
}  // namespace veridyn
