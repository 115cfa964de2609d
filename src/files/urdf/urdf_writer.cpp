#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "files/physical_body.hpp"
#include "files/simulators/xml.hpp"
#include "model/joint_placement.hpp"
#include "effects/effect_names.hpp"
#include "veridyn/files/urdf.hpp"

namespace veridyn {
namespace {

constexpr double kWrittenUnlimited = 1e9;  // URDF requires a number where there is no limit

std::string escaped(const std::string& name) {
  std::string out;
  for (const char c : name) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string xml_comment(const std::string& words) { return "<!--" + comment_words(words) + "-->"; }

std::string origin_xml(const Posed& T) {
  return fmt::format("<origin xyz=\"{}\" rpy=\"{}\"/>", xml_vector(T.p),
                     xml_vector(rpy_from_rotation(T.R)));
}

class UrdfWriter {
 public:
  UrdfWriter(const Model& arm, const UrdfExtras& extras)
      : arm_(arm),
        extras_(extras),
        main_frame_(at(arm.joints()), -1),
        main_joints_(at(arm.joints())) {
    for (std::size_t k = 0; k < arm.frames().size(); ++k) {
      const int i = plain_coordinate(arm.frames()[k]);
      if (i >= 0 && main_frame_[at(i)] < 0) main_frame_[at(i)] = static_cast<int>(k);
    }
  }

  std::string urdf() {
    line(0, "<?xml version=\"1.0\"?>");
    line(0, fmt::format("<robot name=\"{}\">", escaped(arm_.name())));
    losses();
    shapes("");
    line(1, "<link name=\"world\"/>");
    for (int i = 0; i < arm_.joints(); ++i) {
      if (main_frame_[at(i)] < 0) add_carrier_joint(i);
    }
    for (std::size_t k = 0; k < arm_.frames().size(); ++k) frame(static_cast<int>(k));
    // The joints of the coordinates come first, in the order of the coordinates and of the columns of
    // recordings.
    for (const Joint& j : main_joints_) write(j);
    for (const Joint& j : other_joints_) write(j);
    line(0, "</robot>");
    return std::move(out_);
  }

 private:
  struct Joint {
    std::string name;
    std::string parent;
    std::string child;
    JointType type = JointType::kFixed;
    Posed origin = identity_pose();
    Vec3d axis{0, 0, 1};
    int coordinate = -1;
    double multiplier = 0.0;
  };

  static std::size_t at(int i) { return static_cast<std::size_t>(i); }

  void line(int depth, const std::string& content) {
    out_ += std::string(2 * at(depth), ' ') + content + "\n";
  }

  // Index i if the frame's joint variable is coordinate i plus a constant, else -1.
  static int plain_coordinate(const Frame& frame) {
    if (frame.type == JointType::kFixed) return -1;
    int found = -1;
    for (int i = 0; i < frame.variable.coefficients.size(); ++i) {
      if (frame.variable.coefficients[i] == 0.0) continue;
      if (found >= 0 || frame.variable.coefficients[i] != 1.0) return -1;
      found = i;
    }
    return found;
  }

  // Lists the parts of the model that URDF cannot represent.
  void losses() {
    write_remark("", 1);
    if (!arm_.description().source.empty())
      line(1, xml_comment("source: " + arm_.description().source));
    const Eigen::Vector3d& g = arm_.gravity();
    line(1, xml_comment(fmt::format("gravity in link world: {} {} {} m/s^2", g.x(), g.y(), g.z())));
    for (const EffectTerm& term : arm_.arm_effects())
      line(1, xml_comment("left out: " + term.effect + " on the arm"));
    int unknown = 0;
    for (const EffectTerm& term : arm_.effects()) {
      if (term.values.empty()) {
        ++unknown;
      } else if (!damping_or_friction(term)) {
        line(1, xml_comment("left out: " + effect_in_words(term)));
      }
    }
    if (unknown > 0)
      line(1, xml_comment(fmt::format("left out: {} effects whose values are not known", unknown)));
    for (const Coordinate& c : arm_.coordinates()) {
      if (c.drive_gain != 0.0)
        line(1, xml_comment(fmt::format("left out: drive gain {} of {}", c.drive_gain, c.name)));
    }
  }

  std::string effect_in_words(const EffectTerm& term) const {
    std::string words = term.effect + " on";
    for (int i = 0; i < term.axis.coefficients.size(); ++i) {
      if (term.axis.coefficients[i] == 0.0) continue;
      words += fmt::format(" {} {}", term.axis.coefficients[i], arm_.coordinates()[at(i)].name);
    }
    if (!term.frame.empty()) words += " frame " + term.frame;
    for (const auto& [key, value] : term.values) words += fmt::format(", {} {}", key, value);
    return words;
  }

  // True for friction along one coordinate with nonnegative values, which <dynamics> can represent.
  static bool damping_or_friction(const EffectTerm& term) {
    const bool known = represents(term, "damping") || represents(term, "friction");
    const bool plain =
        term.axis.coefficients.cwiseAbs().sum() == 1.0 && term.axis.coefficients.maxCoeff() == 1.0;
    return known && plain && term.values.size() == 1 && term.values.begin()->second >= 0.0;
  }

  // True if this attribute of <dynamics> represents the term and its value.
  static bool represents(const EffectTerm& term, const char* attribute) {
    const auto same = effect_of_attribute(attribute);
    return same && term.effect == same->first && term.values.count(same->second) == 1;
  }

  // Value of the attribute of <dynamics> ("damping" or "friction") of a coordinate: the sum of its terms.
  double dynamics_value(int coordinate, const char* attribute) const {
    double sum = 0.0;
    for (const EffectTerm& term : arm_.effects()) {
      const bool here = represents(term, attribute) && damping_or_friction(term) &&
                        term.axis.coefficients[coordinate] == 1.0;
      if (here) sum += term.values.begin()->second;
    }
    return sum;
  }

  // A coordinate that moves no frame on its own still needs a joint that others can mimic.
  void add_carrier_joint(int i) {
    const Coordinate& c = arm_.coordinates()[at(i)];
    const std::string link = c.name + "__coordinate";
    line(1, xml_comment("carries the coordinate " + c.name + ", which other joints mimic"));
    line(1, fmt::format("<link name=\"{}\"/>", escaped(link)));
    const JointType type = c.prismatic ? JointType::kPrismatic : JointType::kRevolute;
    joint({c.name, "world", link, type, identity_pose(), {0, 0, 1}, i, 1.0});
  }

  bool is_coordinate(const Joint& j) const {
    return j.type != JointType::kFixed && j.name == arm_.coordinates()[at(j.coordinate)].name;
  }

  void joint(const Joint& j) {
    if (is_coordinate(j)) {
      main_joints_[at(j.coordinate)] = j;
    } else {
      other_joints_.push_back(j);
    }
  }

  void write(const Joint& j) {
    const bool coordinate = is_coordinate(j);
    line(1,
         fmt::format("<joint name=\"{}\" type=\"{}\">", escaped(j.name), type_of(j, coordinate)));
    line(2, fmt::format("<parent link=\"{}\"/>", escaped(j.parent)));
    line(2, fmt::format("<child link=\"{}\"/>", escaped(j.child)));
    line(2, origin_xml(j.origin));
    if (j.type != JointType::kFixed) {
      line(2, fmt::format("<axis xyz=\"{}\"/>", xml_vector(j.axis)));
      coordinate ? write_dynamics_and_limits(j) : write_mimic(j);
    }
    line(1, "</joint>");
  }

  std::string type_of(const Joint& j, bool coordinate) const {
    if (j.type == JointType::kFixed) return "fixed";
    if (j.type == JointType::kPrismatic) return "prismatic";
    const Limits& limits = arm_.coordinates()[at(j.coordinate)].limits;
    const bool limited = std::isfinite(limits.lower) || std::isfinite(limits.upper);
    return coordinate && limited ? "revolute" : "continuous";
  }

  static double bounded(double value) {
    return std::max(-kWrittenUnlimited, std::min(kWrittenUnlimited, value));
  }

  void write_dynamics_and_limits(const Joint& j) {
    const Limits& limits = arm_.coordinates()[at(j.coordinate)].limits;
    line(2, fmt::format("<limit lower=\"{}\" upper=\"{}\" velocity=\"{}\" effort=\"{}\"/>",
                        xml_number(bounded(limits.lower)), xml_number(bounded(limits.upper)),
                        xml_number(bounded(limits.velocity)), xml_number(bounded(limits.effort))));
    const double damping = dynamics_value(j.coordinate, "damping");
    const double level = dynamics_value(j.coordinate, "friction");
    if (damping != 0.0 || level != 0.0) {
      line(2, fmt::format("<dynamics damping=\"{}\" friction=\"{}\"/>", xml_number(damping),
                          xml_number(level)));
    }
  }

  void write_mimic(const Joint& j) {
    if (j.type == JointType::kPrismatic) {
      line(2, fmt::format("<limit lower=\"{0}\" upper=\"{1}\" velocity=\"{1}\" effort=\"{1}\"/>",
                          xml_number(-kWrittenUnlimited), xml_number(kWrittenUnlimited)));
    }
    line(2, fmt::format("<mimic joint=\"{}\" multiplier=\"{}\" offset=\"0\"/>",
                        escaped(arm_.coordinates()[at(j.coordinate)].name), xml_number(j.multiplier)));
  }

  void link(const Frame& frame) {
    if (!frame.body && extras_.appearance.count(frame.name) == 0) {
      line(1, fmt::format("<link name=\"{}\"/>", escaped(frame.name)));
      return;
    }
    line(1, fmt::format("<link name=\"{}\">", escaped(frame.name)));
    write_remark(frame.name, 2);
    if (frame.body) {
      frame.body->phi ? inertial(*frame.body->phi)
                      : line(2, xml_comment("a body whose values are not known"));
    }
    shapes(frame.name);
    line(1, "</link>");
  }

  void write_remark(const std::string& frame, int depth) {
    const auto words = extras_.remarks.find(frame);
    if (words != extras_.remarks.end()) line(depth, xml_comment(words->second));
  }

  // Writes visuals and collisions unchanged; materials of the whole robot are stored under the empty name.
  void shapes(const std::string& frame) {
    const auto found = extras_.appearance.find(frame);
    if (found == extras_.appearance.end()) return;
    std::size_t begin = 0;
    while (begin < found->second.size()) {
      const std::size_t end = std::min(found->second.find('\n', begin), found->second.size());
      line(frame.empty() ? 1 : 2, found->second.substr(begin, end - begin));
      begin = end + 1;
    }
  }

  void inertial(const InertialParameters& phi) {
    const std::optional<PhysicalBody> body = physical_body(phi);
    if (!body) {
      line(2, xml_comment("a body of mass zero"));
      return;
    }
    const Eigen::Vector3d& com = body->com;
    const Eigen::Matrix<double, 6, 1>& I = body->inertia;
    line(2, "<inertial>");
    line(3, fmt::format("<origin xyz=\"{}\" rpy=\"0 0 0\"/>", xml_vector(com)));
    line(3, fmt::format("<mass value=\"{}\"/>", xml_number(body->mass)));
    line(3,
         fmt::format("<inertia ixx=\"{}\" ixy=\"{}\" ixz=\"{}\" iyy=\"{}\" iyz=\"{}\" izz=\"{}\"/>",
                     xml_number(I[0]), xml_number(I[1]), xml_number(I[3]), xml_number(I[2]), xml_number(I[4]),
                     xml_number(I[5])));
    line(2, "</inertial>");
  }

  void frame(int k) {
    const Frame& f = arm_.frames()[at(k)];
    const std::string parent = f.parent ? arm_.frames()[at(f.parent->value)].name : "world";
    link(f);
    const JointPlacement placed = joint_placement_with_offset(f);
    std::vector<int> coordinates;
    for (int i = 0; i < arm_.joints(); ++i) {
      if (f.type != JointType::kFixed && f.variable.coefficients[i] != 0.0)
        coordinates.push_back(i);
    }
    const bool has_tip = dot(placed.tip, placed.tip) != 0.0;
    std::string last = parent;
    Posed next = placed.origin;
    for (std::size_t j = 0; j < coordinates.size(); ++j) {
      const int i = coordinates[j];
      const std::string& name = arm_.coordinates()[at(i)].name;
      const std::string own_name = f.name + "__" + name;
      const bool ends_here = j + 1 == coordinates.size() && !has_tip;
      const std::string child = ends_here ? f.name : own_name;
      if (!ends_here) line(1, fmt::format("<link name=\"{}\"/>", escaped(child)));
      const bool is_main = main_frame_[at(i)] == k;
      joint({is_main ? name : own_name, last, child, f.type, next, placed.axis, i,
             f.variable.coefficients[i]});
      last = child;
      next = identity_pose();
    }
    if (coordinates.empty() || has_tip) {
      const Posed to_tip = next * Posed{identity3(), placed.tip};
      joint({f.name + "__fixed", last, f.name, JointType::kFixed, to_tip, {0, 0, 1}, -1, 0.0});
    }
  }

  const Model& arm_;
  const UrdfExtras& extras_;
  std::vector<int> main_frame_;  // index of the frame whose joint is the coordinate itself, or -1
  std::vector<Joint> main_joints_;
  std::vector<Joint> other_joints_;
  std::string out_;
};

}  // namespace

std::string to_urdf(const Model& arm, const UrdfExtras& extras) {
  return UrdfWriter(arm, extras).urdf();
}

}  // namespace veridyn
