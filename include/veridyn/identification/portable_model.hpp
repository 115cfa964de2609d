#pragma once

#include <optional>
#include <string>
#include <vector>

#include "veridyn/files/urdf.hpp"

namespace veridyn {

/// Export of one body.
struct PortableBody {
  std::string frame;
  double mass_before = 0.0;               ///< [kg] in the MODEL file
  double mass = 0.0;                      ///< [kg] as exported
  /// Those of m, hx, ... Lzz that the torques do not determine.
  std::vector<std::string> undetermined;
};

/// A model with physically plausible values for every single inertial parameter.
struct PortableModel {
  Model arm;
  std::vector<PortableBody> bodies;
  bool changed = false;  ///< true: values were chosen anew
  std::string prior;     ///< source of the prior, in words
  std::string remark;    ///< reason for which no values were chosen, one line; empty otherwise
};

/// Place that a file's format has for what torques do not tell from the bodies.
enum class RotorPlace {
  kBodies,    ///< none beside the rotor inertias that the model has: URDF, SDF
  kArmatures  ///< a rotor inertia on every joint: MJCF
};

/// Torques determine combinations of inertial parameters and not each of them; an identification
/// leaves the rest arbitrary, at worst at the bounds of its robot file. Other programs show these
/// numbers as masses and centres. This function chooses them anew:
///
///   minimise   sum over bodies of entropic_divergence(J(phi_b), J(prior_b)) + w (m_b / m_prior_b - 1)^2
///   subject to K phi = K phi_model,   rotor inertias >= 0
///
/// All torques are unchanged up to rounding; every body is physically consistent, and as close to
/// the prior as the torques allow. The prior is the given model (a CAD model of the same frames),
/// else the robot file's bodies, whose masses are held (w) since a drawing knows them best; else a rod of
/// 5 cm diameter and the density of water along every link (w = 0). With kArmatures phi holds a rotor
/// inertia for every joint too: that of a first joint turns nothing but what its link turns as well, and
/// would make the link as heavy as a gear feels. Other effects, bodies that are facts, and models that
/// were not identified are unchanged.
PortableModel portable_model(const Model& arm, const std::optional<Model>& prior = std::nullopt,
                             RotorPlace rotors = RotorPlace::kBodies);

/// Contents of a file in another format.
struct ExportedModel {
  Model arm;
  UrdfExtras extras;  ///< comments on bodies, and the appearance of the links
  std::vector<std::string> notes;  ///< for the user, one line each
  std::vector<std::string> warnings;
};

/// Prepares a model for export: portable_model() where it has values, with comments on the
/// parameters that torques do not determine, and the appearance of its links.
/// @param meshes_from  URDF file whose links look like this arm's; empty: the URDF file that the
///                     model came from, if its `source` names one that is still there.
ExportedModel exported_model(const Model& arm, const std::optional<Model>& prior = std::nullopt,
                             const std::string& meshes_from = {}, RotorPlace rotors = RotorPlace::kBodies);

}  // namespace veridyn
