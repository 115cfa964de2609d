#include "veridyn/files/simulation_file.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <functional>
#include <set>
#include <vector>

#include "math/eigen_pose.hpp"
#include "dynamics/principal_body.hpp"
#include "known_effects.hpp"
#include "model/joint_placement.hpp"
#include "files/physical_body.hpp"
#include "files/simulators/mjcf_elements.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/simulator_files.hpp"
#include "xml.hpp"

namespace veridyn {
namespace {

// Differences between values of a model and of a file below this share of the body's largest value are
// rounding of one conversion.
constexpr double kSameValue = 1e-12;
constexpr double kSamePlace = 1e-9;  // [m], [rad]

const char* const kLeftOut = " left out: ";  // begins a comment

std::string quaternion_text(const Eigen::Matrix3d& R) {
  const Eigen::Quaterniond q(R);
  return fmt::format("{} {} {} {}", q.w() + 0.0, q.x() + 0.0, q.y() + 0.0, q.z() + 0.0);
}

void set_attribute(pugi::xml_node node, const char* name, const std::string& value) {
  pugi::xml_attribute a = node.attribute(name);
  if (!a) a = node.append_attribute(name);
  a.set_value(value.c_str());
}

// The common parts of both formats: updates values that differ, and lists those that cannot be written.
class UpdatedSimulation {
 public:
  UpdatedSimulation(const Model& arm, const Model& in_file, const std::string& path, const char* root)
      : arm_(arm), in_file_(in_file), path_(path) {
    require(arm.inertial_values().has_value(), "export: arm '", arm.name(),
            "' has bodies without values, expected a MODEL that identify or diagnose wrote.");
    const pugi::xml_parse_result parsed =
        document_.load_file(path.c_str(), pugi::parse_default | pugi::parse_comments | pugi::parse_declaration | pugi::parse_doctype);
    require(bool(parsed), path, ": found no XML (", parsed.description(), "), expected a simulation's file.");
    root_ = document_.child(root);
    for (const Coordinate& c : arm.coordinates()) {
      require(in_file.find_coordinate(c.name).has_value(), path, ": found no joint '", c.name, "', which '", arm.name(),
              "' has, expected the file that the model came from.");
    }
  }

  virtual ~UpdatedSimulation() = default;

 protected:
  // Inertial parameters refer to the model's poses of joints and frames, which the file must share.
  void update_inertials() {
    if (arm_.gravity() != in_file_.gravity()) out_.left_out.push_back("gravity");
    for (const Frame& mine : arm_.frames()) {
      const std::optional<FrameIndex> k = in_file_.find_frame(mine.name);
      if (!k) continue;
      const Frame& there = in_file_.frames()[k->value];
      const auto same = [](const Posed& a, const Posed& b) { return eigen(a.R).isApprox(eigen(b.R), kSamePlace) && (eigen(a.p) - eigen(b.p)).norm() <= kSamePlace; };
      if (!same(mine.A, there.A) || !same(mine.B, there.B) || std::abs(mine.variable.offset - there.variable.offset) > kSamePlace)
        out_.left_out.push_back("the place of " + mine.name);
    }
  }

  // Calls change() for bodies whose values differ from those of the file, and add() for those that are missing
  // in it.
  void bodies(const std::function<void(const Frame& mine, const Frame& there)>& change,
              const std::function<bool(const Frame& mine)>& add) {
    for (const auto [k] : arm_.bodies()) {
      const Frame& mine = arm_.frames()[k];
      const std::optional<FrameIndex> there = in_file_.find_frame(mine.name);
      if (!there) {
        const bool added = mine.type == JointType::kFixed && mine.parent && add(mine);
        (added ? out_.changed : out_.left_out).push_back((added ? "a new body " : "the body ") + mine.name);
        continue;
      }
      const Frame& theirs = in_file_.frames()[there->value];
      const InertialParameters none = InertialParameters::Zero();
      const InertialParameters& before = theirs.body ? *theirs.body->phi : none;
      const InertialParameters& now = *mine.body->phi;
      if ((now - before).cwiseAbs().maxCoeff() <= kSameValue * now.cwiseAbs().maxCoeff()) continue;
      change(mine, theirs);
      out_.changed.push_back("inertial of " + mine.name);
    }
  }

  // Updates effects on each coordinate's own axis; others are reported.
  void update_effects(const std::function<bool(const std::string& joint, const char* value, double now)>& change, bool rotors) {
    const KnownEffects mine = known_effects(arm_);
    for (const std::string& one : mine.left_out) out_.left_out.push_back(one);
    const PlacedEffects now = placed_effects(mine.forces, arm_.joints());
    const PlacedEffects there = placed_effects(known_effects(in_file_).forces, in_file_.joints());
    for (int i = 0; i < arm_.joints(); ++i) {
      const std::string& name = arm_.coordinates()[i].name;
      const int j = in_file_.find_coordinate(name)->value;
      const SimpleForce& a = now.along[i];
      const SimpleForce& b = there.along[j];
      const auto one = [&](const char* what, double value, double before) {
        if (std::abs(value - before) <= kSameValue * std::abs(value)) return;
        if (has_coupled_forces(j) || is_referenced(name, what)) {
          out_.left_out.push_back(fmt::format("{} {} of {}, which other parts of the file share", what, value, name));
          return;
        }
        const bool done = change(name, what, value);
        (done ? out_.changed : out_.left_out).push_back(fmt::format("{} of {}{}", what, name, done ? "" : ", a joint without a name of its own"));
      };
      one("damping", a.damping, b.damping);
      one("friction", a.friction, b.friction);
      if (rotors) one("armature", a.inertia, b.inertia);
      else if (a.inertia != 0.0) out_.left_out.push_back(fmt::format("rotor inertia of {}, {}", name, a.inertia));
      one("stiffness", a.stiffness, b.stiffness);
      const double rest = a.stiffness != 0.0 ? -a.offset / a.stiffness : 0.0;
      if (a.stiffness != 0.0) one("spring", rest, b.stiffness != 0.0 ? -b.offset / b.stiffness : 0.0);
      if (now.constants[i] != there.constants[j])
        out_.left_out.push_back(fmt::format("a constant force of {} on {}", now.constants[i] - there.constants[j], name));
    }
    keep_coupled_forces(now, there);
    for (const Coordinate& c : arm_.coordinates()) {
      if (c.drive_gain != 0.0) out_.left_out.push_back(fmt::format("drive gain {} of {}", c.drive_gain, c.name));
    }
  }

  // True if joints that follow the coordinate, or tendons along it, have forces of their own, so that its
  // total force is not the value of one joint.
  bool has_coupled_forces(int coordinate) const {
    std::set<std::string> seen;
    for (const EffectTerm& term : in_file_.effects()) {
      const VectorXd& c = term.axis.coefficients;
      if (c[coordinate] == 0.0 || c.cwiseAbs().sum() != std::abs(c[coordinate])) continue;
      if (c[coordinate] != 1.0 || !seen.insert(term.effect).second) return true;
    }
    return false;
  }

  // True if other parts of the file depend on this value of a joint.
  virtual bool is_referenced(const std::string& /*joint*/, const std::string& /*value*/) const { return false; }

  // Forces along several coordinates keep the file's values.
  void keep_coupled_forces(const PlacedEffects& now, const PlacedEffects& there) {
    for (std::size_t k = 0; k < std::max(now.across.size(), there.across.size()); ++k) {
      const bool both = k < now.across.size() && k < there.across.size();
      const auto values = [](const SimpleForce& f) {
        return std::vector<double>{f.offset, f.stiffness, f.damping, f.inertia, f.friction};
      };
      if (both && values(now.across[k]) == values(there.across[k])) continue;
      out_.left_out.push_back(k < now.across.size() ? "forces along " + axis_text(arm_, now.across[k].axis)
                                                    : "the removal of forces along " + axis_text(in_file_, there.across[k].axis));
    }
  }

  UpdatedFile finish() {
    for (pugi::xml_node node = root_.first_child(), next; node; node = next) {
      next = node.next_sibling();
      const bool earlier = node.type() == pugi::node_comment && std::strncmp(node.value(), kLeftOut, std::strlen(kLeftOut)) == 0;
      if (earlier) root_.remove_child(node);
    }
    pugi::xml_node first = root_.first_child();
    for (const std::string& words : out_.left_out) {
      pugi::xml_node comment = first ? root_.insert_child_before(pugi::node_comment, first) : root_.append_child(pugi::node_comment);
      comment.set_value(comment_words("left out: " + words).c_str());
    }
    out_.xml = xml_text(document_);
    return std::move(out_);
  }

  static pugi::xml_node find_in(pugi::xml_node tree, const char* element, const std::string& name) {
    return tree.find_node([&](const pugi::xml_node& n) {
      return std::strcmp(n.name(), element) == 0 && name == n.attribute("name").value();
    });
  }

  // Finds an element of the arm itself: other sections and models may have other elements of the same name.
  pugi::xml_node find(const char* element, const std::string& name) const {
    for (const pugi::xml_node tree : trees_) {
      if (const pugi::xml_node found = find_in(tree, element, name)) return found;
    }
    return {};
  }

  const Model& arm_;
  const Model& in_file_;
  const std::string& path_;
  pugi::xml_document document_;
  pugi::xml_node root_;
  std::vector<pugi::xml_node> trees_;  // the arm's bodies and joints are in these
  UpdatedFile out_;
};

class UpdatedMjcf : public UpdatedSimulation {
 public:
  UpdatedMjcf(const Model& arm, const Model& in_file, const std::string& path)
      : UpdatedSimulation(arm, in_file, path, "mujoco"), elements_(path) {
    for (const pugi::xml_node world : root_.children("worldbody")) trees_.push_back(world);
    for (const pugi::xml_node compiler : root_.children("compiler")) {
      if (std::strcmp(compiler.attribute("inertiafromgeom").value(), "true") == 0) from_geoms_ = compiler;
    }
  }

  UpdatedFile file() {
    update_inertials();
    bodies([this](const Frame& mine, const Frame&) { change_body(mine); }, [this](const Frame& mine) { return add_body(mine); });
    update_effects([this](const std::string& joint, const char* value, double now) { return change_joint(joint, value, now); }, true);
    if (from_geoms_ && !written_.empty()) use_file_inertials();
    return finish();
  }

 private:
  // Makes the compiler use a body's own inertial, as only "auto" does; inertials that were unused so far must
  // then be removed.
  void use_file_inertials() {
    from_geoms_.attribute("inertiafromgeom").set_value("auto");
    for (const pugi::xml_node tree : trees_) {
      for (pugi::xpath_node found : tree.select_nodes(".//inertial")) {
        pugi::xml_node body = found.parent();
        if (written_.count(body.attribute("name").value()) == 0) body.remove_child(found.node());
      }
    }
  }

  void set_inertial(pugi::xml_node node, const InertialParameters& phi, const Posed& T_body_frame, const std::string& name) {
    const PrincipalBody p = principal_body(phi.data(), T_body_frame);
    require(phi[0] > 0.0 && p.possible(), "export: the body ", name, " of '", arm_.name(), "' has a mass of ", phi[0],
            " kg and the principal moments ", p.moments[0], ", ", p.moments[1], ", ", p.moments[2],
            " kg m^2, which no body has; expected a feasible identification.");
    set_attribute(node, "pos", xml_vector(p.com));
    set_attribute(node, "quat", quaternion_text(p.axes));
    set_attribute(node, "mass", xml_number(phi[0]));
    set_attribute(node, "diaginertia", xml_vector(p.moments));
    written_.insert(name);
  }

  // The pose of the frame in its body's axes: that of the site with the same name, see read_mjcf().
  Posed frame_in_body(const std::string& body) const {
    const pugi::xml_node there = find_in(elements_.root(), "body", body);
    const pugi::xml_node site = there.find_child_by_attribute("site", "name", body.c_str());
    return site ? from_eigen(elements_.pose(site)) : identity_pose();
  }

  // A tendon's spring without a length of its own is relaxed at the spring references of its joints.
  bool is_referenced(const std::string& joint, const std::string& value) const override {
    if (value != "spring") return false;
    for (const pugi::xml_node section : root_.children("tendon")) {
      for (const pugi::xml_node tendon : section.children("fixed")) {
        if (tendon.find_child_by_attribute("joint", "joint", joint.c_str()) && !tendon.attribute("springlength")) return true;
      }
    }
    return false;
  }

  void change_body(const Frame& mine) {
    pugi::xml_node body = find("body", mine.name);
    if (!body) {
      out_.left_out.push_back("inertial of " + mine.name + ", a body without a name of its own");
      return;
    }
    pugi::xml_node node = body.child("inertial");
    if (node) {
      while (node.first_attribute()) node.remove_attribute(node.first_attribute());
    } else {
      node = body.prepend_child("inertial");
    }
    set_inertial(node, *mine.body->phi, frame_in_body(mine.name), mine.name);
  }

  bool add_body(const Frame& mine) {
    Posed T = mine.A * mine.B;
    int carrier = mine.parent->value;
    pugi::xml_node above = find("body", arm_.frames()[carrier].name);
    // A site is a fixed frame on its body.
    while (!above && arm_.frames()[carrier].type == JointType::kFixed && arm_.frames()[carrier].parent) {
      T = arm_.frames()[carrier].A * arm_.frames()[carrier].B * T;
      carrier = arm_.frames()[carrier].parent->value;
      above = find("body", arm_.frames()[carrier].name);
    }
    if (!above) return false;
    T = frame_in_body(arm_.frames()[carrier].name) * T;
    pugi::xml_node body = above.append_child("body");
    set(body, "name", mine.name);
    set(body, "pos", xml_vector(T.p));
    set(body, "quat", quaternion_text(eigen(T.R)));
    set_inertial(body.append_child("inertial"), *mine.body->phi, identity_pose(), mine.name);
    return true;
  }

  bool change_joint(const std::string& joint, const char* value, double now) {
    const pugi::xml_node node = find("joint", joint);
    if (!node) return false;
    const std::string what = value;
    const bool angle = what == "spring" && !arm_.coordinates()[arm_.find_coordinate(joint)->value].prismatic;
    const char* name = what == "friction" ? "frictionloss" : what == "spring" ? "springref" : value;
    set_attribute(node, name, xml_number(angle ? now / elements_.angle() : now));
    return true;
  }

  MjcfElements elements_;  // elements of that file
  pugi::xml_node from_geoms_;
  std::set<std::string> written_;  // bodies that have an inertial of the model
};

class UpdatedSdf : public UpdatedSimulation {
 public:
  UpdatedSdf(const Model& arm, const Model& in_file, const std::string& path)
      : UpdatedSimulation(arm, in_file, path, "sdf") {
    trees_.push_back(find_in(root_, "model", in_file.name()));
  }

  UpdatedFile file() {
    update_inertials();
    bodies([this](const Frame& mine, const Frame&) { set_inertial(find("link", mine.name), *mine.body->phi); },
           [this](const Frame& mine) { return add_link(mine); });
    update_effects([this](const std::string& joint, const char* value, double now) { return change_joint(joint, value, now); }, false);
    return finish();
  }

 private:
  // The child element, which is added if there is none.
  static pugi::xml_node child_or_new(pugi::xml_node above, const char* name) {
    const pugi::xml_node found = above.child(name);
    return found ? found : above.append_child(name);
  }

  void set_inertial(pugi::xml_node link, const InertialParameters& phi) {
    const std::optional<PhysicalBody> body = physical_body(phi);
    require(body.has_value(), "export: a body of '", arm_.name(), "' has no mass, expected one above zero.");
    pugi::xml_node node = child_or_new(link, "inertial");
    while (node.first_child()) node.remove_child(node.first_child());
    node.append_child("pose").text().set((xml_vector(body->com) + " 0 0 0").c_str());
    node.append_child("mass").text().set(xml_number(body->mass).c_str());
    pugi::xml_node inertia = node.append_child("inertia");
    const char* const keys[] = {"ixx", "ixy", "iyy", "ixz", "iyz", "izz"};
    for (int k = 0; k < 6; ++k) inertia.append_child(keys[k]).text().set(xml_number(body->inertia[k]).c_str());
  }

  bool add_link(const Frame& mine) {
    const std::string parent = arm_.frames()[mine.parent->value].name;
    pugi::xml_node above = find("link", parent);
    if (!above) return false;
    const Posed T = mine.A * mine.B;
    pugi::xml_node link = above.parent().append_child("link");
    set(link, "name", mine.name);
    pugi::xml_node pose = link.append_child("pose");
    set(pose, "relative_to", parent);
    pose.text().set((xml_vector(T.p) + " " + xml_vector(rpy_from_rotation(T.R))).c_str());
    set_inertial(link, *mine.body->phi);
    pugi::xml_node joint = above.parent().append_child("joint");
    set(joint, "name", mine.name + "__fixed");
    set(joint, "type", std::string("fixed"));
    joint.append_child("parent").text().set(parent.c_str());
    joint.append_child("child").text().set(mine.name.c_str());
    return true;
  }

  bool change_joint(const std::string& joint, const char* value, double now) {
    const std::string what = value;
    const char* name = what == "stiffness" ? "spring_stiffness" : what == "spring" ? "spring_reference" : value;
    child_or_new(child_or_new(child_or_new(find("joint", joint), "axis"), "dynamics"), name).text().set(xml_number(now).c_str());
    return true;
  }
};

}  // namespace

UpdatedFile updated_mjcf(const Model& arm, const std::string& path) {
  const Model in_file = read_mjcf(path);
  return UpdatedMjcf(arm, in_file, path).file();
}

UpdatedFile updated_sdf(const Model& arm, const std::string& path) {
  const Model in_file = read_sdf(path);
  return UpdatedSdf(arm, in_file, path).file();
}

}  // namespace veridyn
