#pragma once

#include <optional>
#include <string>
#include <vector>

#include "veridyn/files/urdf.hpp"

namespace veridyn {

/// Export of one body.
struct PortableBody {
  std::string frame;
  double mass_before = 0.0;               ///< [kg] mass in the model file
  double mass = 0.0;                      ///< [kg] exported mass
  /// Names among m, hx, ... Lzz that the torques do not determine.
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

/// Place of rotor inertia in a file format, if torques do not separate it from the bodies.
enum class RotorPlace {
  kBodies,    ///< rotor inertias of the model only: URDF, SDF
  kArmatures  ///< a rotor inertia on every joint: MJCF
};

/// Chooses values for the inertial parameters that torques determine in combination only. An identification
/// leaves the single values arbitrary, in the worst case at the bounds of its robot file, while other
/// programs display them as masses and centres:
///
///   minimise   sum over bodies of entropic_divergence(J(phi_b), J(prior_b)) + w (m_b / m_prior_b - 1)^2
///   subject to K phi = K phi_model,   rotor inertias >= 0
///
/// All torques are unchanged up to rounding; every body is physically consistent, and as close to
/// the prior as the torques allow. The prior is the given model (a CAD model of the same frames);
/// else the bodies of the robot file, whose masses have the weight w; else a rod of 5 cm diameter
/// with the density of water along every link (w = 0). With kArmatures phi contains a rotor inertia
/// for every joint too, since that of a first joint cannot be separated from its link and would
/// appear as mass of the link. Other effects, known bodies, and models that were not identified are
/// unchanged.
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
