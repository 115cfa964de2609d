#include "veridyn/files/mjcf.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>

#include "math/eigen_pose.hpp"
#include "known_effects.hpp"
#include "dynamics/principal_body.hpp"
#include "veridyn/kinematics/tree.hpp"
#include "veridyn/math/require.hpp"
#include "xml.hpp"

namespace veridyn {
namespace {

// [kg], [kg m^2] smallest mass and inertia, since MuJoCo requires some of every moving body.
constexpr double kLeastMjcfMass = 1e-12;
constexpr double kStep = 1e-3;         // [s] time step
// Time constant and damping ratio of couplings: transients end within four steps.
const char* const kStiff = "0.004 1";

void set_pose(pugi::xml_node node, const Eigen::Vector3d& p, const Eigen::Matrix3d& R) {
  const Eigen::Quaterniond q(R);
  set(node, "pos", xml_vector(p));
  set(node, "quat", fmt::format("{} {} {} {}", q.w() + 0.0, q.x() + 0.0, q.y() + 0.0, q.z() + 0.0));
}

void set_pose(pugi::xml_node node, const Posed& T) {
  set_pose(node, eigen(T.p), eigen(T.R));
}

class MjcfWriter {
 public:
  MjcfWriter(const Model& arm, const std::map<std::string, std::string>& remarks)
      : arm_(arm), remarks_(remarks), tree_(arm, Tree::Keep::kEveryFrame), effects_(known_effects(arm)),
        placed_(placed_effects(effects_.forces, arm.joints())) {
    const auto phi = arm.inertial_values();
    require(phi.has_value(), "export: arm '", arm.name(),
            "' has bodies without values, expected a MODEL that identify or diagnose wrote.");
    phi_ = *phi;
    for (int k = 0; k < static_cast<int>(tree_.links.size()); ++k) {
      const int i = plain_coordinate(k);
      if (i >= 0 && main_link_of(i) < 0) main_links_.emplace_back(i, k);
    }
  }

  std::string xml() {
    pugi::xml_node root = document_.append_child("mujoco");
    set(root, "model", arm_.name());
    if (remarks_.count("") > 0) add_comment(root, remarks_.at(""));
    list_left_out_effects(root);
    pugi::xml_node compiler = root.append_child("compiler");
    set(compiler, "angle", std::string("radian"));
    set(compiler, "inertiafromgeom", std::string("false"));
    pugi::xml_node option = root.append_child("option");
    set(option, "gravity", xml_vector(arm_.gravity()));
    set(option, "timestep", kStep);
    pugi::xml_node world = root.append_child("worldbody");
    add_children(world, -1, identity_pose());
    for (int i = 0; i < arm_.joints(); ++i) {
      if (main_link_of(i) < 0) add_carrier_joint(world, i);
    }
    tendons_ = root.append_child("tendon");
    equalities_ = root.append_child("equality");
    for (int k = 0; k < static_cast<int>(tree_.links.size()); ++k) couple_joint(k);
    for (const SimpleForce& force : placed_.across) add_tendon_force(world, force);
    if (!tendons_.first_child()) root.remove_child(tendons_);
    if (!equalities_.first_child()) root.remove_child(equalities_);
    add_motors(root.append_child("actuator"));
    return xml_text(document_);
  }

 private:
  // Lists the effects that MuJoCo cannot represent.
  void list_left_out_effects(pugi::xml_node root) const {
    for (const std::string& one : effects_.left_out) add_comment(root, "left out: " + one);
    for (const Coordinate& c : arm_.coordinates()) {
      if (c.drive_gain != 0.0)
        add_comment(root, fmt::format("left out: drive gain {} of {}", c.drive_gain, c.name));
    }
  }

  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  const Link& link(int k) const { return tree_.links[at(k)]; }

  // Index i if the link's joint variable is coordinate i plus a constant, else -1.
  int plain_coordinate(int k) const {
    const Link& l = link(k);
    if (l.type == JointType::kFixed || l.end_coefficient != l.first_coefficient + 1) return -1;
    const JointCoefficient& share = tree_.coefficients[at(l.first_coefficient)];
    return share.coefficient == 1.0 ? share.coordinate : -1;
  }

  int main_link_of(int coordinate) const {
    for (const auto& [i, k] : main_links_) {
      if (i == coordinate) return k;
    }
    return -1;
  }

  const std::string& frame_name(int k) const { return arm_.frames()[at(link(k).frame)].name; }

  // Name of a link's joint; a joint that is a coordinate has the coordinate's name.
  std::string joint_name(int k) const {
    const int i = plain_coordinate(k);
    if (i >= 0 && main_link_of(i) == k) return arm_.coordinates()[at(i)].name;
    return frame_name(k) + "__joint";
  }

  void add_children(pugi::xml_node above, int parent, const Posed& before) {
    for (int k = 0; k < static_cast<int>(tree_.links.size()); ++k) {
      const Link& l = link(k);
      if (l.parent != parent) continue;
      if (l.type == JointType::kFixed && l.body < 0) {
        add_site(above, k, before * l.A);
        add_children(above, k, before * l.A);
        continue;
      }
      const bool turns = l.type == JointType::kRevolute;
      Posed at_zero = identity_pose();
      if (turns) at_zero.R = rotation_z(l.offset);
      if (l.type == JointType::kPrismatic) at_zero.p.z = l.offset;
      const Posed T = before * l.A * at_zero;
      pugi::xml_node body = above.append_child("body");
      set(body, "name", frame_name(k));
      set_pose(body, T);
      if (remarks_.count(frame_name(k)) > 0) add_comment(body, remarks_.at(frame_name(k)));
      add_inertial(body, k);
      if (l.type != JointType::kFixed) {
        add_joint(body, joint_name(k), turns, plain_coordinate(k),
              main_link_of(plain_coordinate(k)) == k);
      }
      add_site(body, k, l.B);
      add_children(body, k, l.B);
    }
  }

  // Adds a site at the frame: a link's own frame turns with its joint and lies before B.
  void add_site(pugi::xml_node body, int k, const Posed& T) const {
    pugi::xml_node node = body.append_child("site");
    set(node, "name", frame_name(k));
    set_pose(node, T);
  }

  void add_inertial(pugi::xml_node body, int k) const {
    const Link& l = link(k);
    const double* phi = l.body < 0 ? nullptr : phi_.data() + kBodyParameters * l.body;
    pugi::xml_node node = body.append_child("inertial");
    const bool none = phi == nullptr || VectorXd::Map(phi, kBodyParameters).isZero(0.0);
    if (none) {
      exclude_from_collision(node);
      return;
    }
    require(phi[0] > 0.0, "export: the body ", frame_name(k), " of '", arm_.name(),
            "' has a mass of ", phi[0], " kg, expected one above zero.");
    const PrincipalBody p = principal_body(phi, l.B);
    require(p.possible(), "export: the body ", frame_name(k), " of '", arm_.name(),
            "' has the principal moments ", p.moments[0], ", ", p.moments[1], ", ", p.moments[2],
            " kg m^2, which no body has; expected a feasible identification.");
    set_pose(node, p.com, p.axes);
    set(node, "mass", phi[0]);
    set(node, "diaginertia", xml_vector(p.moments));
  }

  static void exclude_from_collision(pugi::xml_node node) {
    set(node, "pos", std::string("0 0 0"));
    set(node, "mass", kLeastMjcfMass);
    set(node, "diaginertia", xml_vector(Vec3d{kLeastMjcfMass, kLeastMjcfMass, kLeastMjcfMass}));
  }

  // Adds a joint for a coordinate that moves no frame by itself, so that others can be coupled to
  // it.
  void add_carrier_joint(pugi::xml_node world, int i) {
    const Coordinate& c = arm_.coordinates()[at(i)];
    pugi::xml_node body = world.append_child("body");
    set(body, "name", c.name + "__coordinate");
    exclude_from_collision(body.append_child("inertial"));
    add_joint(body, c.name, !c.prismatic, i, true);
  }

  void add_joint(pugi::xml_node body, const std::string& name, bool turns, int coordinate, bool main) {
    pugi::xml_node node = body.append_child("joint");
    set(node, "name", name);
    set(node, "type", std::string(turns ? "hinge" : "slide"));
    set(node, "axis", std::string("0 0 1"));
    if (!main) return;
    const Limits& limits = arm_.coordinates()[at(coordinate)].limits;
    if (std::isfinite(limits.lower) && std::isfinite(limits.upper)) {
      set(node, "limited", std::string("true"));
      set(node, "range", xml_number(limits.lower) + " " + xml_number(limits.upper));
    }
    set_joint_forces(node, placed_.along[at(coordinate)]);
  }

  void set_joint_forces(pugi::xml_node node, const SimpleForce& f) {
    if (f.damping != 0.0) set(node, "damping", f.damping);
    if (f.inertia != 0.0) set(node, "armature", f.inertia);
    if (f.friction != 0.0) set(node, "frictionloss", f.friction);
    spring(node, f, "springref");
  }

  // Writes the spring offset + stiffness s as stiffness (s - reference).
  void spring(pugi::xml_node node, const SimpleForce& f, const char* reference) {
    if (f.stiffness == 0.0) return;
    set(node, "stiffness", f.stiffness);
    set(node, reference, -f.offset / f.stiffness);
  }

  // Attaches a force along several coordinates to a tendon.
  void add_tendon_force(pugi::xml_node world, const SimpleForce& f) {
    if (f.inertia != 0.0 && !inertia_along_joint(f)) add_flywheel(world, f);
    if (f.damping == 0.0 && f.friction == 0.0 && f.stiffness == 0.0) return;
    pugi::xml_node tendon = tendons_.append_child("fixed");
    set(tendon, "name", fmt::format("effects_{}", ++tendon_count_));
    if (f.damping != 0.0) set(tendon, "damping", f.damping);
    if (f.friction != 0.0) set(tendon, "frictionloss", f.friction);
    spring(tendon, f, "springlength");
    add_terms(tendon, f.axis.coefficients, 1.0);
  }

  // Adds a rotor along c . q to the joint with that variable; false if there is none.
  bool inertia_along_joint(const SimpleForce& f) {
    for (int k = 0; k < static_cast<int>(tree_.links.size()); ++k) {
      if (link(k).type == JointType::kFixed) continue;
      const VectorXd c = coefficients(k);
      const double scale = c.dot(f.axis.coefficients) / f.axis.coefficients.squaredNorm();
      if (scale == 0.0 || !c.isApprox(scale * f.axis.coefficients, 1e-12)) continue;
      pugi::xml_node node = document_.first_child().find_node([&](const pugi::xml_node& n) {
        return std::string(n.name()) == "joint" && joint_name(k) == n.attribute("name").value();
      });
      pugi::xml_attribute armature = node.attribute("armature");
      if (!armature) armature = node.append_attribute("armature");
      armature.set_value(
          xml_number(armature.as_double() + f.inertia / (scale * scale)).c_str());
      return true;
    }
    return false;
  }

  // Adds a rotor along several coordinates: armatures belong to single joints, so it becomes a
  // joint on a massless body that is coupled to the coordinates.
  void add_flywheel(pugi::xml_node world, const SimpleForce& f) {
    const std::string name = fmt::format("rotor_{}", ++rotor_count_);
    pugi::xml_node body = world.append_child("body");
    set(body, "name", name);
    exclude_from_collision(body.append_child("inertial"));
    add_joint(body, name + "__joint", true, -1, false);
    set(body.child("joint"), "armature", f.inertia);
    add_coupling(name, name + "__joint", f.axis.coefficients);
  }

  VectorXd coefficients(int k) const {
    VectorXd c = VectorXd::Zero(arm_.joints());
    for (int e = link(k).first_coefficient; e < link(k).end_coefficient; ++e)
      c[tree_.coefficients[at(e)].coordinate] += tree_.coefficients[at(e)].coefficient;
    return c;
  }

  void add_terms(pugi::xml_node tendon, const VectorXd& c, double sign) {
    for (int i = 0; i < arm_.joints(); ++i) {
      if (c[i] == 0.0) continue;
      pugi::xml_node term = tendon.append_child("joint");
      set(term, "joint", arm_.coordinates()[at(i)].name);
      set(term, "coef", sign * c[i]);
    }
  }

  // Couples joints that are not coordinates.
  void couple_joint(int k) {
    const int i = plain_coordinate(k);
    if (link(k).type == JointType::kFixed || (i >= 0 && main_link_of(i) == k)) return;
    add_coupling(frame_name(k), joint_name(k), coefficients(k));
  }

  // Couples a joint by the constraint 0 = joint - c . q.
  void add_coupling(const std::string& name, const std::string& joint, const VectorXd& c) {
    pugi::xml_node tendon = tendons_.append_child("fixed");
    set(tendon, "name", name + "__coupling");
    pugi::xml_node own = tendon.append_child("joint");
    set(own, "joint", joint);
    set(own, "coef", 1.0);
    add_terms(tendon, c, -1.0);
    pugi::xml_node equality = equalities_.append_child("tendon");
    set(equality, "tendon1", name + "__coupling");
    set(equality, "solref", std::string(kStiff));
  }

  // Adds motors, through which constant effects act: force = control - constant.
  void add_motors(pugi::xml_node actuators) const {
    for (int i = 0; i < arm_.joints(); ++i) {
      const Coordinate& c = arm_.coordinates()[at(i)];
      const bool biased = placed_.constants[i] != 0.0;
      pugi::xml_node motor = actuators.append_child(biased ? "general" : "motor");
      set(motor, "name", c.name);
      set(motor, "joint", c.name);
      if (biased) {
        set(motor, "biastype", std::string("affine"));
        set(motor, "biasprm", xml_number(-placed_.constants[i]) + " 0 0");
      }
      if (!std::isfinite(c.limits.effort)) continue;
      set(motor, "ctrllimited", std::string("true"));
      set(motor, "ctrlrange",
          xml_number(-c.limits.effort) + " " + xml_number(c.limits.effort));
    }
  }

  const Model& arm_;
  const std::map<std::string, std::string>& remarks_;
  Tree tree_;
  KnownEffects effects_;
  PlacedEffects placed_;
  VectorXd phi_;
  std::vector<std::pair<int, int>> main_links_;  // (coordinate, link whose joint equals it)
  pugi::xml_document document_;
  pugi::xml_node tendons_, equalities_;
  int tendon_count_ = 0;
  int rotor_count_ = 0;
};

}  // namespace

std::string to_mjcf(const Model& arm, const std::map<std::string, std::string>& remarks) {
  return MjcfWriter(arm, remarks).xml();
}

}  // namespace veridyn
