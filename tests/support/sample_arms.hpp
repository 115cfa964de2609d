#pragma once

#include <gtest/gtest.h>

#include <cctype>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "support/random.hpp"
#include "math/numbers.hpp"
#include "veridyn/model/model.hpp"

// Arms that between them have every feature of a model: both joint types, both DH conventions,
// general poses on either side of a joint, branches, fixed frames with and without bodies, joints
// that follow several coordinates.

namespace veridyn {

/// Frames and bodies one after the other; every body is random but could exist.
class ArmBuilder {
 public:
  ArmBuilder(std::string name, int joints, unsigned seed) : random_(seed) {
    arm_.name = std::move(name);
    const Limits limits{-kInfinity, kInfinity, kInfinity, kInfinity, kInfinity};
    for (int i = 0; i < joints; ++i)
      arm_.coordinates.push_back({text_of("q", i + 1), limits, 0.0, false, {}});
  }

  Random& random() { return random_; }
  ModelDescription& description() { return arm_; }

  /// A frame with a body. @returns its index.
  int link(int parent, JointType type, const std::vector<double>& coefficients, double offset,
           const Posed& A, const Posed& B) {
    const int k = bare(parent, type, coefficients, offset, A, B);
    arm_.frames.back().body = Body{};
    arm_.frames.back().body->phi = random_.body();
    return k;
  }

  /// A frame without one.
  int bare(int parent, JointType type, const std::vector<double>& coefficients, double offset,
           const Posed& A, const Posed& B) {
    Frame frame;
    frame.name = text_of("frame", static_cast<int>(arm_.frames.size()));
    if (parent >= 0) frame.parent = FrameIndex{parent};
    frame.type = type;
    frame.A = A;
    frame.B = B;
    frame.variable.offset = offset;
    frame.variable.coefficients = Eigen::VectorXd::Zero(joints());
    for (size_t i = 0; i < coefficients.size(); ++i) {
      frame.variable.coefficients[static_cast<Eigen::Index>(i)] = coefficients[i];
    }
    arm_.frames.push_back(frame);
    return static_cast<int>(arm_.frames.size()) - 1;
  }

  /// The next link of a chain in DH numbers, moved by one coordinate.
  int dh_link(JointType type, int coordinate, const DhRow& dh) {
    const int parent = static_cast<int>(arm_.frames.size()) - 1;
    const int k = link(parent, type, unit(coordinate), 0.0, identity_pose(), identity_pose());
    place(arm_.frames.back(), dh);
    return k;
  }

  std::vector<double> unit(int coordinate) const {
    std::vector<double> c(joints(), 0.0);
    c[coordinate] = 1.0;
    return c;
  }

  Model build() { return Model(arm_); }

 private:
  static std::string text_of(const char* word, int number) { return word + std::to_string(number); }
  int joints() const { return static_cast<int>(arm_.coordinates.size()); }

  ModelDescription arm_;
  Random random_;
};

/// A rod that swings about a horizontal axis: z of the joint is -y of the world, q = 0 hangs along
/// x.
inline Model pendulum() {
  ArmBuilder arm("pendulum", 1, 1);
  arm.link(-1, JointType::kRevolute, {1.0}, 0.0, {rotation_x(M_PI / 2), {0, 0, 0}},
           identity_pose());
  return arm.build();
}

constexpr double kPlanarLength1 = 0.4;

/// Two links in a vertical plane; x of the world horizontal, y of the joints upwards.
inline Model planar_2r() {
  ArmBuilder arm("planar_2R", 2, 2);
  arm.link(-1, JointType::kRevolute, {1.0, 0.0}, 0.0, {rotation_x(M_PI / 2), {0, 0, 0}},
           identity_pose());
  arm.link(0, JointType::kRevolute, {0.0, 1.0}, 0.0, {identity3(), {kPlanarLength1, 0, 0}},
           identity_pose());
  return arm.build();
}

inline Model spherical_rrp() {
  ArmBuilder arm("spherical_RRP", 3, 3);
  arm.dh_link(JointType::kRevolute, 0, {DhConvention::kModified, 0.0, M_PI / 2, 0.0, M_PI / 2});
  arm.dh_link(JointType::kRevolute, 1, {DhConvention::kModified, 0.0, -M_PI / 2, 0.0, -M_PI / 2});
  arm.dh_link(JointType::kPrismatic, 2, {DhConvention::kModified, 0.05, M_PI / 2, -0.43, 0.2});
  return arm.build();
}

inline Model elbow_6r() {
  ArmBuilder arm("elbow_6R", 6, 4);
  arm.dh_link(JointType::kRevolute, 0, {DhConvention::kStandard, 0.0, M_PI / 2, 0.6, 0.0});
  arm.dh_link(JointType::kRevolute, 1, {DhConvention::kStandard, 0.43, 0.0, 0.0, 0.3});
  arm.dh_link(JointType::kRevolute, 2, {DhConvention::kStandard, 0.02, -M_PI / 2, 0.15, 0.0});
  arm.dh_link(JointType::kRevolute, 3, {DhConvention::kStandard, 0.0, M_PI / 2, 0.43, -0.1});
  arm.dh_link(JointType::kRevolute, 4, {DhConvention::kStandard, 0.0, -M_PI / 2, 0.0, 0.0});
  arm.dh_link(JointType::kRevolute, 5, {DhConvention::kStandard, 0.0, 0.0, 0.06, 0.0});
  return arm.build();
}

/// A chain in general position, revolute and prismatic in turn as `types` says ("RRPR...").
inline Model random_serial(const std::string& types, unsigned seed) {
  const int n = static_cast<int>(types.size());
  ArmBuilder arm("serial_" + types, n, seed);
  arm.description().gravity = arm.random().vector(3, -6.0, 6.0);
  for (int i = 0; i < n; ++i) {
    const JointType type =
        types[i] == 'R' ? JointType::kRevolute : JointType::kPrismatic;
    const Posed A = arm.random().pose(0.4);
    const Posed B = i % 2 == 0 ? identity_pose() : arm.random().pose(0.2);
    arm.link(i - 1, type, arm.unit(i), arm.random().in(-1, 1), A, B);
  }
  return arm.build();
}

/// Two chains from one trunk, each joint with a coordinate of its own; for engines that know no
/// couplings.
inline Model branched_tree(unsigned seed) {
  ArmBuilder arm("branched_tree", 6, seed);
  Random& random = arm.random();
  const auto R = JointType::kRevolute;
  const auto P = JointType::kPrismatic;
  const int trunk = arm.link(-1, R, arm.unit(0), 0.2, random.pose(0.3), random.pose(0.3));
  const int left = arm.link(trunk, P, arm.unit(1), 0.1, random.pose(0.3), random.pose(0.3));
  const int right = arm.link(trunk, R, arm.unit(2), 0.0, random.pose(0.3), identity_pose());
  arm.link(left, R, arm.unit(3), -0.4, random.pose(0.3), random.pose(0.3));
  const int wrist = arm.link(right, R, arm.unit(4), 0.0, random.pose(0.3), random.pose(0.3));
  arm.link(wrist, P, arm.unit(5), 0.0, random.pose(0.3), random.pose(0.3));
  return arm.build();
}

/// A parallelogram, as remote-centre arms have it, with a counterweight that slides against the
/// tool.
inline Model parallelogram() {
  ArmBuilder arm("parallelogram", 3, 6);
  const auto R = JointType::kRevolute;
  const auto P = JointType::kPrismatic;
  const int yaw =
      arm.link(-1, R, {1, 0, 0}, 0.0, {rotation_y(M_PI / 2), {0, 0, 0}}, identity_pose());
  const Posed side{rotation_x(-M_PI / 2), {0.1, 0, 0}};
  const int front = arm.link(yaw, R, {0, 1, 0}, -M_PI / 2, side, {identity3(), {0.15, 0, 0}});
  arm.link(yaw, R, {0, 1, 0}, -M_PI / 2, {side.R, {0.25, 0, 0}}, identity_pose());
  const int top =
      arm.link(front, R, {0, -1, 0}, M_PI / 2, {identity3(), {0.3, 0, 0}}, identity_pose());
  const int carriage = arm.link(top, R, {0, 1, 0}, 0.0, {identity3(), {0.2, 0.05, 0}},
                                {rotation_x(M_PI / 2), {0, 0, 0}});
  arm.link(carriage, P, {0, 0, 1}, -0.4, {rotation_z(0.3), {0.02, 0, 0.01}}, identity_pose());
  arm.link(carriage, P, {0, 0, -0.6}, 0.1, {rotation_z(-0.3), {-0.04, 0, 0}},
           {rotation_y(0.2), {0, 0.01, 0}});
  return arm.build();
}

/// Joints that follow several coordinates, coordinates that move several joints of one chain and of
/// another type, fixed frames with a body and without, and a last frame that carries nothing.
inline Model coupled_wrist() {
  ArmBuilder arm("coupled_wrist", 4, 7);
  Random& random = arm.random();
  const auto R = JointType::kRevolute;
  const auto P = JointType::kPrismatic;
  const int base = arm.bare(-1, JointType::kFixed, {}, 0.0, random.pose(0.3), random.pose(0.3));
  const int first = arm.link(base, R, {1.0, 0, 0, 0}, 0.3, random.pose(0.3), random.pose(0.2));
  const int stand = arm.bare(first, JointType::kFixed, {}, 0.0, random.pose(0.3), random.pose(0.3));
  const int screw = arm.bare(stand, P, {0.05, 0.2, 0, 0}, 0.1, random.pose(0.3), random.pose(0.2));
  const int motor = arm.link(screw, JointType::kFixed, {}, 0.0, random.pose(0.3), random.pose(0.2));
  const int second = arm.link(screw, R, {-0.3, 1.1, 0, 0}, 0.0, identity_pose(), random.pose(0.2));
  arm.link(motor, R, {0, 7.0, 0, 0}, 0.0, random.pose(0.1), identity_pose());
  const int third =
      arm.link(second, R, {0, 0.7, -1.2, 0.4}, -0.2, random.pose(0.3), identity_pose());
  const int fourth = arm.link(third, R, {0, 0, 0.5, 0.5}, 0.0, random.pose(0.3), random.pose(0.2));
  arm.link(third, R, {0, 0, 0.5, -0.5}, 0.0, random.pose(0.3), random.pose(0.2));
  arm.bare(fourth, P, {0, 0, 0, 1.0}, 0.0, random.pose(0.3), random.pose(0.2));
  return arm.build();
}

/// A long tree with branches of both joint types whose links do not follow the coordinates' order, some
/// against their coordinate: the dynamics of many independent joints are computed otherwise than
/// those of few.
inline Model long_tree(unsigned seed) {
  constexpr int kLinks = 31;
  ArmBuilder arm("long_tree", kLinks, seed);
  for (int k = 0; k < kLinks; ++k) {
    std::vector<double> coefficients = arm.unit(7 * k % kLinks);
    if (k % 3 == 1) coefficients[7 * k % kLinks] = -0.7;
    const int parent = k % 5 == 0 && k > 0 ? k / 2 : k - 1;
    arm.link(parent, k % 4 == 2 ? JointType::kPrismatic : JointType::kRevolute, coefficients,
             arm.random().in(-1, 1), arm.random().pose(0.2), arm.random().pose(0.1));
  }
  return arm.build();
}

/// A chain of 26 joints, one coordinate each, in order.
inline Model long_chain(unsigned seed) {
  ArmBuilder arm("long_chain", 26, seed);
  for (int k = 0; k < 26; ++k)
    arm.link(k - 1, k % 6 == 4 ? JointType::kPrismatic : JointType::kRevolute, arm.unit(k), 0.0,
             {arm.random().pose(0.1).R, {0.05, 0.01 * k, 0.1}}, identity_pose());
  return arm.build();
}

/// The same chain, with two joints of one coordinate.
inline Model long_coupled_chain(unsigned seed) {
  ArmBuilder arm("long_coupled_chain", 25, seed);
  for (int k = 0; k < 26; ++k)
    arm.link(k - 1, JointType::kRevolute, arm.unit(k % 25), 0.0,
             {arm.random().pose(0.1).R, {0.05, 0.01 * k, 0.1}}, identity_pose());
  return arm.build();
}

inline const std::map<std::string, Model>& sample_arms() {
  static const std::map<std::string, Model> arms = [] {
    std::map<std::string, Model> all;
    for (const Model& arm :
         {pendulum(), planar_2r(), spherical_rrp(), elbow_6r(), random_serial("RRPRRPR", 5),
          random_serial("PRPPR", 8), branched_tree(9), parallelogram(), coupled_wrist(),
          long_tree(11), long_chain(12), long_coupled_chain(13)}) {
      all.emplace(arm.name(), arm);
    }
    return all;
  }();
  return arms;
}

inline std::vector<std::string> sample_arm_names() {
  std::vector<std::string> names;
  for (const auto& [name, arm] : sample_arms()) {
    if (name.rfind("long", 0) != 0) names.push_back(name);
  }
  return names;
}

/// With the long arms, for claims about rigid bodies alone.
inline std::vector<std::string> all_arm_names() {
  std::vector<std::string> names;
  for (const auto& [name, arm] : sample_arms()) names.push_back(name);
  return names;
}

/// One property, claimed for every sample arm: a class with a name of its own per file derives from
/// this one, with INSTANTIATE_TEST_SUITE_P(Sample, ThatClass,
/// testing::ValuesIn(sample_arm_names()), sample_arm_name).
class OnSampleArm : public testing::TestWithParam<std::string> {
 protected:
  static const Model& arm() { return sample_arms().at(GetParam()); }
  static int joints() { return arm().joints(); }
  static Eigen::VectorXd phi() { return *arm().inertial_values(); }
};

inline std::string sample_arm_name(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  return name;
}

}  // namespace veridyn
