#pragma once

#include <Eigen/Geometry>
#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "files/simulators/simulator_frames.hpp"

namespace veridyn {

inline Eigen::Vector3d as_vector(const std::vector<double>& v) {
  return {v[0], v[1], v[2]};
}

/// The elements of an MJCF file with MuJoCo's rules applied: defaults of the class, settings of the compiler,
/// and bodies from their inertia or their geoms.
class MjcfElements {
 public:
  /// @throws InvalidInput  no such file, one that includes others, or unsupported settings of the compiler
  /// that change bodies.
  explicit MjcfElements(const std::string& path);

  pugi::xml_node root() const { return xml_.root(); }

  /// The last value of an attribute in all sections with this name.
  pugi::xml_attribute setting(const char* section, const char* name, pugi::xml_node* where = nullptr) const;

  /// An attribute of an element, or that of its class' defaults.
  pugi::xml_attribute given(pugi::xml_node node, const char* name) const;
  double number(pugi::xml_node node, const char* name, double otherwise) const;  ///< of an attribute, or `otherwise` without it
  std::vector<double> numbers(pugi::xml_node node, const char* name, int least, int most) const;

  double angle() const { return angle_; }  ///< [rad] per unit of angle in the file
  Eigen::Isometry3d pose(pugi::xml_node node) const;  ///< in the frame of its parent

  /// True if the range of a joint or actuator is a limit.
  bool limited(pugi::xml_node node, const char* name) const;

  /// Inertial parameters of an element; nullopt if the file gives none, or only the tiny mass that simulators
  /// require.
  /// @param moves  relative to the world: the geoms of fixed bodies have no inertia.
  std::optional<Body> inertia(pugi::xml_node node, const Eigen::Isometry3d& T_frame_body, bool moves) const;

 protected:
  XmlFile xml_;

 private:
  void read_classes();
  void read_compiler();
  pugi::xml_node defaults(pugi::xml_node user, const std::string& name) const;
  Eigen::Vector3d direction(pugi::xml_node node, const char* name, const std::vector<double>& v) const;
  Eigen::Matrix3d orientation(pugi::xml_node node) const;
  std::optional<Body> inertia_of_geoms(pugi::xml_node node, const Eigen::Isometry3d& T_frame_body) const;
  std::optional<Body> geom(pugi::xml_node node, const Eigen::Isometry3d& T_frame_body) const;  ///< body of one geom; none without mass

  pugi::xml_attribute setting_of(pugi::xml_node defaults, const char* element, const char* name) const;

  std::unordered_map<std::string, pugi::xml_node> classes_;  // elements <default> of the classes by name
  std::map<std::pair<std::size_t, std::string>, pugi::xml_node> settings_;  // by <default> and kind of element
  double angle_ = 1.0;
  std::string sequence_ = "xyz";
  bool auto_limits_ = true, geoms_always_ = false, geoms_never_ = false;
  double first_group_ = 0.0, last_group_ = 5.0;
};

}  // namespace veridyn
