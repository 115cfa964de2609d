#include "veridyn/model/model.hpp"

#include <cmath>
#include <set>
#include <utility>

#include "veridyn/math/require.hpp"

namespace veridyn {

InertialParameters inertial_parameters(double mass, const Eigen::Vector3d& com,
                                       const Eigen::Matrix<double, 6, 1>& inertia_com) {
  // Steiner's theorem: L = L_com + m (c'c 1 - c c').
  const double x = com.x();
  const double y = com.y();
  const double z = com.z();
  InertialParameters phi;
  phi << mass, mass * x, mass * y, mass * z,                                   //
      inertia_com[0] + mass * (y * y + z * z), inertia_com[1] - mass * x * y,  //
      inertia_com[2] + mass * (x * x + z * z), inertia_com[3] - mass * x * z,  //
      inertia_com[4] - mass * y * z, inertia_com[5] + mass * (x * x + y * y);
  return phi;
}

const char* name_of(RobotValues values) {
  return values == RobotValues::kFacts ? "facts" : "prior";
}

void place(Frame& frame, const DhRow& dh) {
  frame.dh = dh;
  const bool turns = frame.type == JointType::kRevolute;
  const bool slides = frame.type == JointType::kPrismatic;
  // The DH number of the joint's own kind (theta or d) becomes part of s0, the other one part of A or B.
  if (turns) frame.variable.offset += dh.theta;
  if (slides) frame.variable.offset += dh.d;
  const Posed turn{rotation_z(turns ? 0.0 : dh.theta), {0, 0, 0}};
  const Posed slide{identity3(), {0, 0, slides ? 0.0 : dh.d}};
  const Posed link{rotation_x(dh.alpha), {dh.a, 0, 0}};
  // Rz and Tz commute, so the constant one may be placed on either side of the joint.
  if (dh.convention == DhConvention::kStandard) {
    frame.A = turns ? identity_pose() : turn;
    frame.B = slide * link;
  } else {
    frame.A = slides ? link * turn : link * slide;
    frame.B = frame.type == JointType::kFixed ? turn : identity_pose();
  }
}

namespace {

// Largest absolute number in a file: files in other units, or damaged ones, are rejected, so that squares and
// sums of torques remain finite.
constexpr double kLargestNumber = 1e9;

bool is_small(double x) { return std::abs(x) <= kLargestNumber; }  // false for NaN
bool is_small(const Vec3<double>& p) { return is_small(p.x) && is_small(p.y) && is_small(p.z); }

}  // namespace

Model::Model(ModelDescription description) : description_(std::move(description)) {
  const int n = joints();
  const std::string where = text("arm '", description_.name, "'");
  require(n > 0, where, " has no coordinates.");
  require(n <= kMostCoordinates, where, " has ", n, " coordinates, expected at most ", kMostCoordinates, ".");
  require((description_.gravity.array().abs() <= kLargestNumber).all(), where, ": gravity is beyond +-", kLargestNumber,
          " m/s^2, expected that of a planet.");
  std::set<std::string> names;
  for (const Coordinate& c : description_.coordinates) {
    require(names.insert(c.name).second, where, ": coordinate '", c.name, "' stands twice.");
  }
  names.clear();
  std::vector<char> slides(n, 0);
  std::vector<char> turns(n, 0);
  for (int k = 0; k < static_cast<int>(description_.frames.size()); ++k) {
    Frame& frame = description_.frames[k];
    require(names.insert(frame.name).second, where, ": frame '", frame.name, "' stands twice.");
    require(!frame.parent || (frame.parent->value < k && frame.parent->value >= 0), where, ": the parent of frame '", frame.name,
            "' does not stand before it.");
    if (frame.variable.coefficients.size() == 0) frame.variable.coefficients = VectorXd::Zero(n);
    require(frame.variable.coefficients.size() == n, where, ": frame '", frame.name, "' has ",
            frame.variable.coefficients.size(), " joint coefficients, but there are ", n,
            " coordinates.");
    require(is_small(frame.A.p) && is_small(frame.B.p) && is_small(frame.variable.offset) &&
                (frame.variable.coefficients.array().abs() <= kLargestNumber).all(),
            where, ": frame '", frame.name, "' has a length, an angle or a coefficient beyond +-", kLargestNumber,
            ", expected those of an arm, in m and rad.");
    std::vector<char> support(n, 0);
    if (frame.parent) support = support_[frame.parent->value];
    for (int i = 0; i < n; ++i) {
      if (frame.variable.coefficients[i] == 0.0) continue;
      support[i] = 1;
      (frame.type == JointType::kPrismatic ? slides : turns)[i] = 1;
    }
    support_.push_back(std::move(support));
    if (frame.body) bodies_.push_back({k});
  }
  require(bodies_.size() <= kMostBodies, where, " has ", bodies_.size(), " bodies, expected at most ", kMostBodies, ".");
  for (int i = 0; i < n; ++i)
    description_.coordinates[i].prismatic = slides[i] != 0 && turns[i] == 0;
  for (const EffectTerm& term : description_.effects) {
    require(term.axis.coefficients.size() == n, where, ": effect '", term.effect, "' has ",
            term.axis.coefficients.size(), " axis coefficients, but there are ", n,
            " coordinates.");
  }
}

std::optional<FrameIndex> Model::find_frame(const std::string& name) const {
  for (size_t k = 0; k < description_.frames.size(); ++k) {
    if (description_.frames[k].name == name) return FrameIndex{static_cast<int>(k)};
  }
  return std::nullopt;
}

std::optional<JointIndex> Model::find_coordinate(const std::string& name) const {
  for (int i = 0; i < joints(); ++i) {
    if (description_.coordinates[i].name == name) return JointIndex{i};
  }
  return std::nullopt;
}

std::optional<VectorXd> Model::inertial_values() const {
  VectorXd phi(kBodyParameters * static_cast<int>(bodies_.size()));
  for (size_t b = 0; b < bodies_.size(); ++b) {
    const Body& body = *description_.frames[bodies_[b].value].body;
    if (!body.phi) return std::nullopt;
    phi.segment<kBodyParameters>(static_cast<Eigen::Index>(kBodyParameters * b)) = *body.phi;
  }
  return phi;
}

std::string effort_unit(const Coordinate& coordinate) {
  return coordinate.prismatic ? "N" : "N m";
}

std::string position_unit(const Coordinate& coordinate) {
  return coordinate.prismatic ? "m" : "rad";
}

bool is_prismatic(const Model& arm, const Axis& axis) {
  return arm.coordinates()[main_coordinate(axis).value].prismatic;
}

JointIndex main_coordinate(const Axis& axis) {
  Eigen::Index best = 0;
  axis.coefficients.cwiseAbs().maxCoeff(&best);
  return {static_cast<int>(best)};
}

}  // namespace veridyn
