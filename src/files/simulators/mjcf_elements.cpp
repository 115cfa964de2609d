#include "files/simulators/mjcf_elements.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kMjcfDensity = 1000.0;  // [kg/m^3] MuJoCo's default for geoms

bool is_true(pugi::xml_attribute a) { return std::strcmp(a.value(), "true") == 0; }

// The shortest rotation that takes z to a unit vector.
Eigen::Matrix3d turn_z_to(const Eigen::Vector3d& z) {
  const Eigen::Vector3d normal = Eigen::Vector3d::UnitZ().cross(z);
  const double sine = normal.norm();
  const Eigen::Vector3d axis = sine < 1e-10 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d(normal / sine);
  return Eigen::AngleAxisd(std::atan2(sine, z.z()), axis).toRotationMatrix();
}

// Volume [m^3] and squared radii of gyration [m^2] about the principal axes.
struct SolidShape {
  double volume;
  Eigen::Vector3d gyration;
};

SolidShape solid_of(const std::string& type, const std::vector<double>& size) {
  const double r = size[0];
  if (type == "sphere") return {4.0 / 3.0 * M_PI * r * r * r, Eigen::Vector3d::Constant(0.4 * r * r)};
  if (type == "box" || type == "ellipsoid") {
    const double x = size[0] * size[0], y = size[1] * size[1], z = size[2] * size[2];
    const bool box = type == "box";
    return {(box ? 8.0 : 4.0 / 3.0 * M_PI) * size[0] * size[1] * size[2],
            Eigen::Vector3d(y + z, x + z, x + y) / (box ? 3.0 : 5.0)};
  }
  const double h = size[1];
  const double tube = 2.0 * M_PI * r * r * h;
  const double across = r * r / 4.0 + h * h / 3.0;
  if (type == "cylinder") return {tube, {across, across, r * r / 2.0}};
  // A capsule is a cylinder between two halves of a sphere, whose centres lie 3/8 r beyond its ends.
  const double ball = 4.0 / 3.0 * M_PI * r * r * r;
  const double all = tube + ball;
  const double ends = 0.4 * r * r + h * h + 0.75 * h * r;
  const double x = (tube * across + ball * ends) / all;
  return {all, {x, x, (tube * r * r / 2.0 + ball * 0.4 * r * r) / all}};
}

}  // namespace

MjcfElements::MjcfElements(const std::string& path) : xml_(path, "mujoco", "an MJCF file") {
  const pugi::xml_node other = root().find_node([](const pugi::xml_node& n) {
    return std::strcmp(n.name(), "include") == 0 || std::strcmp(n.name(), "attach") == 0;
  });
  if (other) {
    xml_.fail(other, text("<", other.name(), "> of '", other.attribute("file").value(), "'"),
              "one file with all of the arm (MuJoCo writes one: mj_saveLastXML)");
  }
  read_classes();
  read_compiler();
}

pugi::xml_attribute MjcfElements::setting(const char* section, const char* name, pugi::xml_node* where) const {
  pugi::xml_attribute out;
  for (const pugi::xml_node node : root().children(section)) {
    if (const pugi::xml_attribute own = node.attribute(name)) {
      out = own;
      if (where != nullptr) *where = node;
    }
  }
  return out;
}

// Reads the classes. If a class or a setting of a class occurs twice, the first one is used.
void MjcfElements::read_classes() {
  const auto take = [this](pugi::xml_node defaults, const char* name) {
    classes_.try_emplace(name, defaults);
    for (const pugi::xml_node child : defaults.children()) settings_.try_emplace({defaults.hash_value(), child.name()}, child);
  };
  for (const pugi::xml_node top : root().children("default")) {
    take(top, top.attribute("class") ? top.attribute("class").value() : "main");
    for (pugi::xml_node at = top.first_child(); at;) {
      if (std::strcmp(at.name(), "default") == 0) take(at, at.attribute("class").value());
      pugi::xml_node next = at.first_child();
      for (; !next && at != top; at = at.parent()) next = at.next_sibling();
      at = next;
    }
  }
}

pugi::xml_attribute MjcfElements::setting_of(pugi::xml_node defaults, const char* element, const char* name) const {
  const auto known = settings_.find({defaults.hash_value(), element});
  return known == settings_.end() ? pugi::xml_attribute() : known->second.attribute(name);
}

// The defaults of a class: the element <default> of that name.
pugi::xml_node MjcfElements::defaults(pugi::xml_node user, const std::string& name) const {
  const auto known = classes_.find(name);
  if (known != classes_.end()) return known->second;
  if (name != "main") xml_.fail(user, "the class '" + name + "'", "one that <default> defines");
  return {};
}

pugi::xml_attribute MjcfElements::given(pugi::xml_node node, const char* name) const {
  if (const pugi::xml_attribute own = node.attribute(name)) return own;
  std::string used = node.attribute("class").value();
  for (pugi::xml_node above = node.parent(); used.empty() && above; above = above.parent())
    used = above.attribute("childclass").value();
  pugi::xml_node from = defaults(node, used.empty() ? "main" : used);
  for (; from && std::strcmp(from.name(), "default") == 0; from = from.parent()) {
    if (const pugi::xml_attribute inherited = setting_of(from, node.name(), name)) return inherited;
  }
  // MuJoCo combines several top-level sections <default> into the class main.
  for (const pugi::xml_node top : root().children("default")) {
    if (const pugi::xml_attribute inherited = setting_of(top, node.name(), name)) return inherited;
  }
  return {};
}

double MjcfElements::number(pugi::xml_node node, const char* name, double otherwise) const {
  const pugi::xml_attribute a = given(node, name);
  return a ? xml_.numbers(node, name, a.value(), 1, 1)[0] : otherwise;
}

std::vector<double> MjcfElements::numbers(pugi::xml_node node, const char* name, int least, int most) const {
  const pugi::xml_attribute a = given(node, name);
  return a ? xml_.numbers(node, name, a.value(), least, most) : std::vector<double>();
}

Eigen::Vector3d MjcfElements::direction(pugi::xml_node node, const char* name, const std::vector<double>& v) const {
  if (const double length = as_vector(v).norm(); length > 1e-10) return as_vector(v) / length;
  xml_.fail(node, text(name, " without a direction"), "a vector that is not zero");
}

Eigen::Matrix3d MjcfElements::orientation(pugi::xml_node node) const {
  if (const auto q = numbers(node, "quat", 4, 4); !q.empty()) {
    const Eigen::Quaterniond turn(q[0], q[1], q[2], q[3]);
    if (!(turn.norm() > 1e-10)) xml_.fail(node, "a quaternion of zero length", "a rotation");
    return turn.normalized().toRotationMatrix();
  }
  if (const auto a = numbers(node, "axisangle", 4, 4); !a.empty())
    return Eigen::AngleAxisd(angle_ * a[3], direction(node, "axisangle", a)).toRotationMatrix();
  if (const auto e = numbers(node, "euler", 3, 3); !e.empty()) {
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    for (std::size_t k = 0; k < 3; ++k) {
      const bool fixed_axes = sequence_[k] < 'a';
      const Eigen::Matrix3d turn =
          Eigen::AngleAxisd(angle_ * e[k], Eigen::Vector3d::Unit((fixed_axes ? sequence_[k] + 32 : sequence_[k]) - 'x'))
              .toRotationMatrix();
      R = fixed_axes ? Eigen::Matrix3d(turn * R) : Eigen::Matrix3d(R * turn);
    }
    return R;
  }
  if (const auto v = numbers(node, "xyaxes", 6, 6); !v.empty()) {
    Eigen::Matrix3d R;
    R.col(0) = direction(node, "xyaxes", v);
    const Eigen::Vector3d y(v[3], v[4], v[5]);
    R.col(1) = y - R.col(0).dot(y) * R.col(0);
    if (!(R.col(1).norm() > 1e-10)) xml_.fail(node, "xyaxes that are parallel", "two directions");
    R.col(1).normalize();
    R.col(2) = R.col(0).cross(R.col(1));
    return R;
  }
  if (const auto z = numbers(node, "zaxis", 3, 3); !z.empty()) return turn_z_to(direction(node, "zaxis", z));
  return Eigen::Matrix3d::Identity();
}

Eigen::Isometry3d MjcfElements::pose(pugi::xml_node node) const {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  if (const auto p = numbers(node, "pos", 3, 3); !p.empty()) T.translation() = as_vector(p);
  T.linear() = orientation(node);
  return T;
}

bool MjcfElements::limited(pugi::xml_node node, const char* name) const {
  const std::string words = given(node, name).value();
  return words == "true" || (words != "false" && auto_limits_);
}

void MjcfElements::read_compiler() {
  pugi::xml_node at = root().child("compiler");
  for (const char* name : {"boundmass", "boundinertia", "settotalmass"}) {
    const pugi::xml_attribute given = setting("compiler", name, &at);
    if (given && xml_.number(at, name, given.value()) > 0.0)
      xml_.fail(at, text("the compiler's ", name, ", which changes bodies"), "bodies as they are");
  }
  const std::string coordinate = setting("compiler", "coordinate", &at).value();
  if (coordinate == "global") xml_.fail(at, "global coordinates", "local ones");
  const std::string angle = setting("compiler", "angle", &at).value();
  if (!angle.empty() && angle != "degree" && angle != "radian") xml_.fail(at, "angle '" + angle + "'", "degree or radian");
  angle_ = angle == "radian" ? 1.0 : kDegree;
  if (const pugi::xml_attribute given = setting("compiler", "eulerseq", &at)) sequence_ = given.value();
  if (sequence_.size() != 3 || sequence_.find_first_not_of("xyzXYZ") != std::string::npos)
    xml_.fail(at, "eulerseq '" + sequence_ + "'", "three letters of x, y, z, X, Y, Z");
  const std::string limits = setting("compiler", "autolimits").value();
  auto_limits_ = limits != "false";
  geoms_always_ = is_true(setting("compiler", "inertiafromgeom"));
  geoms_never_ = std::strcmp(setting("compiler", "inertiafromgeom").value(), "false") == 0;
  if (const pugi::xml_attribute given = setting("compiler", "inertiagrouprange", &at)) {
    const auto range = xml_.numbers(at, "inertiagrouprange", given.value(), 2, 2);
    first_group_ = range[0];
    last_group_ = range[1];
  }
}

std::optional<Body> MjcfElements::inertia(pugi::xml_node node, const Eigen::Isometry3d& T_frame_body, bool moves) const {
  const pugi::xml_node own = node.child("inertial");
  if (!own || geoms_always_) return geoms_never_ || !moves ? std::nullopt : inertia_of_geoms(node, T_frame_body);
  if (!own.attribute("mass")) xml_.fail(own, "no mass of a body", "one");
  const double mass = number(own, "mass", 0.0);
  Eigen::Matrix3d I = Eigen::Matrix3d::Zero();
  if (const auto full = numbers(own, "fullinertia", 6, 6); !full.empty()) {
    I << full[0], full[3], full[4], full[3], full[1], full[5], full[4], full[5], full[2];
  } else if (const auto diagonal = numbers(own, "diaginertia", 3, 3); !diagonal.empty()) {
    I.diagonal() = as_vector(diagonal);
  } else {
    xml_.fail(own, "no moments of inertia", "diaginertia or fullinertia");
  }
  return body_of(xml_, own, mass, T_frame_body * pose(own), I);
}

// The body that is the sum of the element's geoms, each with uniform density.
std::optional<Body> MjcfElements::inertia_of_geoms(pugi::xml_node node, const Eigen::Isometry3d& T_frame_body) const {
  std::optional<Body> sum;
  for (const pugi::xml_node part : node.children()) {
    if (std::strcmp(part.name(), "frame") == 0) {
      const std::optional<Body> below = inertia_of_geoms(part, T_frame_body * pose(part));
      if (below && sum) *sum->phi += *below->phi;
      if (below && !sum) sum = below;
    }
    if (std::strcmp(part.name(), "geom") != 0) continue;
    const double group = number(part, "group", 0.0);
    if (group < first_group_ || group > last_group_) continue;
    const std::optional<Body> one = geom(part, T_frame_body);
    if (one && sum) *sum->phi += *one->phi;
    if (one && !sum) sum = one;
  }
  return sum;
}

std::optional<Body> MjcfElements::geom(pugi::xml_node node, const Eigen::Isometry3d& T_frame_body) const {
  const std::string type = given(node, "type") ? given(node, "type").value() : "sphere";
  const double density = number(node, "density", kMjcfDensity);
  const double mass = number(node, "mass", -1.0);
  if (mass == 0.0 || (mass < 0.0 && density == 0.0)) return std::nullopt;
  if (is_true(given(node, "shellinertia"))) xml_.fail(node, "the inertia of a shell", "an <inertial> in its body");
  const auto ends = numbers(node, "fromto", 6, 6);
  const bool long_shape = type == "capsule" || type == "cylinder" || type == "box" || type == "ellipsoid";
  const std::size_t needed = type == "sphere" ? 1 : type == "box" || type == "ellipsoid" ? 3 : 2;
  if (!long_shape && type != "sphere") {
    xml_.fail(node, text("a body without <inertial>, whose inertia MuJoCo infers from a ", type),
              "<inertial> in its body (MuJoCo writes one: mj_saveLastXML)");
  }
  auto size = numbers(node, "size", 1, 3);
  Eigen::Isometry3d T = pose(node);
  if (!ends.empty() && long_shape) {
    const Eigen::Vector3d from = as_vector(ends), to(ends[3], ends[4], ends[5]);
    if (!((to - from).norm() > 0.0)) xml_.fail(node, "a geom between two equal points", "two points");
    T.translation() = 0.5 * (from + to);
    T.linear() = turn_z_to((from - to).normalized());
    const double radius = size.empty() ? 0.0 : size[0];
    size = needed == 3 ? std::vector<double>{radius, radius} : std::vector<double>{radius};
    size.push_back(0.5 * (to - from).norm());
  }
  if (size.size() < needed || *std::min_element(size.begin(), size.end()) < 0.0 || !(size[0] > 0.0))
    xml_.fail(node, text("a ", type, " without its sizes"), text(needed, needed == 1 ? " number" : " numbers", " above zero"));
  const SolidShape solid = solid_of(type, size);
  const double m = mass > 0.0 ? mass : density * solid.volume;
  Eigen::Matrix3d I = Eigen::Matrix3d::Zero();
  I.diagonal() = m * solid.gyration;
  return body_of(xml_, node, m, T_frame_body * T, I);
}

}  // namespace veridyn
