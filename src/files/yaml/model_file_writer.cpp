#include <algorithm>
#include <cmath>
#include <utility>

#include "files/physical_body.hpp"
#include "veridyn/math/require.hpp"
#include "effects/effect_names.hpp"
#include "model/joint_placement.hpp"
#include "veridyn/files/model_file.hpp"
#include "files/words.hpp"
#include "files/yaml/yaml_identified.hpp"
#include "files/yaml/yaml_text.hpp"

namespace veridyn {
namespace {

bool same_pose(const Posed& a, const Posed& b) {
  const auto same_vector = [](const Vec3d& u, const Vec3d& v) {
    return same_in_yaml(u.x, v.x) && same_in_yaml(u.y, v.y) && same_in_yaml(u.z, v.z);
  };
  return same_vector(a.R.row0, b.R.row0) && same_vector(a.R.row1, b.R.row1) &&
         same_vector(a.R.row2, b.R.row2) && same_vector(a.p, b.p);
}

class ModelWriter {
 public:
  explicit ModelWriter(const Model& arm) : arm_(arm), d_(arm.description()), numbers_(d_) {}

  std::string yaml() {
    write_header();
    write_coordinates();
    const auto has_row = [](const Frame& frame) { return frame.dh.has_value(); };
    const bool has_rows = std::any_of(d_.frames.begin(), d_.frames.end(), has_row);
    write_line(has_rows ? "frames:  # dh: [a, alpha, d, theta]" : "frames:");
    for (const Frame& frame : d_.frames) write_line("  - {" + frame_text(frame) + "}");
    if (!d_.effects.empty()) write_line("effects:");
    for (std::size_t i = 0; i < d_.effects.size(); ++i)
      write_line("  - {" + effect_text(d_.effects[i], text("effects/", i)) + "}");
    if (!d_.arm_effects.empty()) write_line("arm_effects:");
    for (std::size_t i = 0; i < d_.arm_effects.size(); ++i)
      write_line("  - {" + effect_text(d_.arm_effects[i], text("arm_effects/", i)) + "}");
    if (d_.identified) out_ += identified_text(*d_.identified);
    return std::move(out_);
  }

 private:
  void write_line(const std::string& content) { out_ += content + "\n"; }

  void write_header() {
    write_line("veridyn: 1");
    write_line("name: " + quoted_if_needed(d_.name));
    if (!d_.source.empty()) write_line("source: " + quoted_if_needed(d_.source));
    if (d_.values == RobotValues::kPrior) write_line("values: prior");
    write_line("gravity: " + numbers_.list("gravity", d_.gravity));
    if (const auto convention = common_convention()) write_line("convention: " + name_of(*convention));
    constants();
    const std::string box = box_text("box", d_.box);
    if (!box.empty()) write_line(box);
  }

  // Writes constants before those that depend on them.
  void constants() {
    if (d_.constants.empty()) return;
    write_line("constants:");
    Constants written;
    Constants left = d_.constants;
    while (!left.empty()) {
      auto next = std::find_if(left.begin(), left.end(), [&](const auto& c) {
        const auto formula = d_.formulas.find("constants/" + c.first);
        return formula == d_.formulas.end() || formula_gives(formula->second, written, c.second);
      });
      const bool as_it_was = next != left.end();
      if (!as_it_was) next = left.begin();
      write_line("  " + next->first + ": " +
           (as_it_was ? numbers_.number("constants/" + next->first, next->second)
                      : shortest(next->second)));
      written.insert(*next);
      left.erase(next);
    }
  }

  static std::string name_of(DhConvention convention) {
    return convention == DhConvention::kStandard ? "standard" : "modified";
  }

  std::optional<DhConvention> common_convention() const {
    std::optional<DhConvention> common;
    for (const Frame& frame : d_.frames) {
      if (!frame.dh) continue;
      if (common && *common != frame.dh->convention) return std::nullopt;
      common = frame.dh->convention;
    }
    return common;
  }

  std::string box_text(const std::string& place, const ParameterBox& box) const {
    std::vector<std::string> parts;
    if (box.mass_max != 0.0)
      parts.push_back("mass_max: " + numbers_.number(place + "/mass_max", box.mass_max));
    if (box.com_reach != 0.0)
      parts.push_back("com_reach: " + numbers_.number(place + "/com_reach", box.com_reach));
    if (box.effect_max != 0.0)
      parts.push_back("effect_max: " + numbers_.number(place + "/effect_max", box.effect_max));
    return parts.empty() ? "" : "box: {" + joined(parts) + "}";
  }

  void write_coordinates() {
    write_line("coordinates:");
    for (const Coordinate& c : d_.coordinates) {
      const std::string place = "coordinates/" + c.name;
      std::vector<std::string> parts{"name: " + quoted_if_needed(c.name)};
      const std::string limits = limits_text(place + "/limits", c.limits);
      if (!limits.empty()) parts.push_back("limits: {" + limits + "}");
      if (c.drive_gain != 0.0)
        parts.push_back("drive_gain: " + numbers_.number(place + "/drive_gain", c.drive_gain));
      const std::string recorded = channel_text(place + "/recorded", c.recorded);
      if (!recorded.empty()) parts.push_back("recorded: {" + recorded + "}");
      if (c.drive_gain_deviation != 0.0)
        parts.push_back("drive_gain_std: " + deviation_text(c.drive_gain_deviation));
      write_line("  - {" + joined(parts) + "}");
    }
  }

  std::string channel_text(const std::string& place, const RecordedChannel& channel) const {
    std::vector<std::string> parts;
    const auto add = [&](const std::string& key, double value, double usual) {
      if (value != usual) parts.push_back(key + ": " + numbers_.number(place + "/" + key, value));
    };
    add("torque_gain", channel.torque_gain, 1.0);
    add("torque_delay", channel.torque_delay, 0.0);
    add("position_offset", channel.position_offset, 0.0);
    std::vector<std::string> crosstalk;
    for (const auto& [from, share] : channel.torque_crosstalk) {
      const std::string& name = d_.coordinates[from.value].name;
      crosstalk.push_back(quoted_if_needed(name) + ": " +
                          numbers_.number(place + "/torque_crosstalk/" + name, share));
    }
    if (!crosstalk.empty()) parts.push_back("torque_crosstalk: {" + joined(crosstalk) + "}");
    return joined(parts);
  }

  std::string limits_text(const std::string& place, const Limits& limits) const {
    std::vector<std::string> parts;
    if (std::isfinite(limits.lower) || std::isfinite(limits.upper)) {
      const auto end = [&](const char* index, double value) {
        return std::isfinite(value) ? numbers_.number(place + "/position/" + index, value)
                                    : shortest(value);
      };
      parts.push_back("position: [" + end("0", limits.lower) + ", " + end("1", limits.upper) + "]");
    }
    const auto add = [&](const std::string& key, double value) {
      if (std::isfinite(value))
        parts.push_back(key + ": " + numbers_.number(place + "/" + key, value));
    };
    add("velocity", limits.velocity);
    add("acceleration", limits.acceleration);
    add("effort", limits.effort);
    return joined(parts);
  }

  // Writes {coordinate: coefficient, ...}; if all coefficients are zero, the first one is written, so that the
  // map is not empty.
  std::string linear_form(const std::string& place, const VectorXd& c) const {
    std::vector<std::string> parts;
    for (int i = 0; i < arm_.joints(); ++i) {
      if (c[i] == 0.0 && !(i == 0 && c.isZero(0.0))) continue;
      const std::string& name = d_.coordinates[i].name;
      parts.push_back(quoted_if_needed(name) + ": " + numbers_.number(place + "/" + name, c[i]));
    }
    return "{" + joined(parts) + "}";
  }

  std::string frame_text(const Frame& frame) const {
    const std::string place = "frames/" + frame.name;
    const std::string parent =
        frame.parent ? d_.frames[frame.parent->value].name : "world";
    std::vector<std::string> parts{"name: " + quoted_if_needed(frame.name),
                                   "parent: " + quoted_if_needed(parent)};
    const std::optional<DhRow> row = row_of(frame);
    parts.push_back(row ? row_text(place, *row) : placement_text(place, frame));
    if (frame.type == JointType::kRevolute) {
      parts.push_back("revolute: " + linear_form(place + "/revolute", frame.variable.coefficients));
    } else if (frame.type == JointType::kPrismatic) {
      parts.push_back("prismatic: " +
                      linear_form(place + "/prismatic", frame.variable.coefficients));
    }
    const std::string all = joined(parts);
    return frame.body ? all + "," + body_text(place + "/body", *frame.body) : all;
  }

  // The DH row with the current offset; nullopt if A and B no longer follow from the row.
  static std::optional<DhRow> row_of(const Frame& frame) {
    if (!frame.dh) return std::nullopt;
    DhRow row = *frame.dh;
    if (frame.type == JointType::kRevolute) row.theta = frame.variable.offset;
    if (frame.type == JointType::kPrismatic) row.d = frame.variable.offset;
    Frame placed;
    placed.type = frame.type;
    place(placed, row);
    if (!same_pose(placed.A, frame.A) || !same_pose(placed.B, frame.B)) return std::nullopt;
    return row;
  }

  std::string row_text(const std::string& place, const DhRow& row) const {
    const std::string convention =
        common_convention() ? "" : "convention: " + name_of(row.convention) + ", ";
    const std::string at = place + "/dh/";
    const std::vector<std::string> four{
        numbers_.number(at + "0", row.a), numbers_.angle(at + "1", row.alpha),
        numbers_.number(at + "2", row.d), numbers_.angle(at + "3", row.theta)};
    return convention + "dh: [" + joined(four) + "]";
  }

  std::string placement_text(const std::string& place, const Frame& frame) const {
    const JointPlacement joint = joint_placement(frame);
    const Vec3d rpy = rpy_from_rotation(joint.origin.R);
    const bool turned =
        without_noise(rpy.x) != 0.0 || without_noise(rpy.y) != 0.0 || without_noise(rpy.z) != 0.0;
    std::string all = "origin: {xyz: " + numbers_.vector(place + "/origin/xyz", joint.origin.p);
    if (turned) {
      const std::string at = place + "/origin/rpy/";
      const std::vector<std::string> three{numbers_.angle(at + "0", rpy.x),
                                           numbers_.angle(at + "1", rpy.y),
                                           numbers_.angle(at + "2", rpy.z)};
      all += ", rpy: [" + joined(three) + "]";
    }
    all += "}";
    if (frame.type == JointType::kFixed) return all;
    if (joint.axis.z != 1.0) all += ", axis: " + numbers_.vector(place + "/axis", joint.axis);
    if (dot(joint.tip, joint.tip) != 0.0)
      all += ", tip: " + numbers_.vector(place + "/tip", joint.tip);
    if (frame.variable.offset != 0.0)
      all += ", offset: " + numbers_.angle(place + "/offset", frame.variable.offset);
    return all;
  }

  std::string body_text(const std::string& place, const Body& body) const {
    std::vector<std::string> parts;
    if (body.phi) parts.push_back(values_text(place, *body.phi, body.std_phi.has_value()));
    if (body.std_phi) parts.push_back("std: " + deviations_text(*body.std_phi));
    if (body.prior) parts.push_back("prior: {" + values_text(place + "/prior", *body.prior, false) + "}");
    if (body.fixed) parts.push_back("fixed: true");
    const std::string box = box_text(place + "/box", body.box);
    if (!box.empty()) parts.push_back(box);
    if (parts.empty()) return " body: true";
    std::string all;
    for (const std::string& part : parts)
      all += (all.empty() ? "\n     body: {" : ",\n            ") + part;
    return all + "}";
  }

  std::string values_text(const std::string& place, const InertialParameters& phi,
                          bool identified) const {
    const std::optional<PhysicalBody> body = identified ? std::nullopt : rounded_physical_body(phi);
    if (!body) return "parameters: " + numbers_.list(place + "/parameters", phi);
    const char* const names[] = {"xx", "xy", "yy", "xz", "yz", "zz"};
    std::vector<std::string> inertia;
    for (int i = 0; i < 6; ++i) {
      if (body->inertia[i] == 0.0) continue;
      inertia.push_back(text(
          names[i], ": ", numbers_.number(text(place, "/inertia/", names[i]), body->inertia[i])));
    }
    return "mass: " + numbers_.number(place + "/mass", body->mass) +
           ", com: " + numbers_.list(place + "/com", body->com) + ", inertia: {" + joined(inertia) +
           "}";
  }

  // Writes an unknown deviation as infinite.
  static std::string deviations_text(const InertialParameters& deviations) {
    std::vector<std::string> texts;
    for (const double deviation : deviations) texts.push_back(deviation_text(deviation));
    return "[" + joined(texts) + "]";
  }

  static std::string deviation_text(double deviation) {
    return std::isfinite(deviation) ? shortest(deviation) : ".inf";
  }

  std::string effect_text(const EffectTerm& term, const std::string& place) const {
    std::vector<std::string> parts{"effect: " + quoted_if_needed(term.effect)};
    const bool everywhere =
        term.axis.coefficients.isZero(0.0) && (!term.frame.empty() || may_lack_axis(term.effect));
    if (!everywhere)
      parts.push_back("axis: " + linear_form(place + "/axis", term.axis.coefficients));
    const bool own_offset = has_offset_parameter(term.effect);
    if (term.axis.offset != 0.0 && !own_offset) {
      parts.push_back("offset: " + numbers_.number(place + "/offset", term.axis.offset));
    }
    if (term.from) {
      parts.push_back("from: " + linear_form(place + "/from", term.from->coefficients));
      const double offset = term.from->offset;
      if (offset != 0.0)
        parts.push_back("from_offset: " + numbers_.number(place + "/from_offset", offset));
    }
    if (!term.frame.empty()) parts.push_back("frame: " + quoted_if_needed(term.frame));
    add_values(place, term, parts);
    std::vector<std::string> deviations;
    for (const auto& [key, value] : term.deviations) {
      deviations.push_back(quoted_if_needed(key) + ": " + deviation_text(value));
    }
    if (!deviations.empty()) parts.push_back("std: {" + joined(deviations) + "}");
    return joined(parts);
  }

  // Parameters are written beside the other keys, except those with the name of such a key.
  void add_values(const std::string& place, const EffectTerm& term,
                  std::vector<std::string>& parts) const {
    std::vector<std::string> apart;
    for (const auto& [key, value] : term.values) {
      const std::vector<std::string>& keys = effect_keys();
      const bool own_offset = key == "offset" && has_offset_parameter(term.effect);
      const bool clashes = !own_offset && std::find(keys.begin(), keys.end(), key) != keys.end();
      const std::string at = place + (clashes ? "/values/" : "/") + key;
      (clashes ? apart : parts)
          .push_back(quoted_if_needed(key) + ": " + numbers_.number(at, value));
    }
    if (!apart.empty()) parts.push_back("values: {" + joined(apart) + "}");
  }

  const Model& arm_;
  const ModelDescription& d_;
  const YamlNumbers numbers_;
  std::string out_;
};

}  // namespace

std::string to_yaml(const Model& arm) {
  return ModelWriter(arm).yaml();
}

}  // namespace veridyn
