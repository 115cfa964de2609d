#pragma once

#include <optional>
#include <string>
#include <vector>

#include "veridyn/model/urdf.hpp"

namespace veridyn {

/// What an export says about one body.
struct PortableBody {
  std::string frame;
  double mass_before = 0.0;               ///< [kg] in the MODEL file
  double mass = 0.0;                      ///< [kg] as exported
  std::vector<std::string> undetermined;  ///< Undetermined of m, hx, ... Lzz: what the torques do not determine
};

/// A model whose every single number can be shown to other programs.
struct PortableModel {
  Model arm;
  std::vector<PortableBody> bodies;
  bool changed = false;  ///< values were chosen anew
  std::string prior;     ///< what they were chosen near to, in words
  std::string remark;    ///< why they were not, one line; empty otherwise
};

/// Torques determine combinations of inertial parameters, not every one of them; what an
/// identification leaves for the others is arbitrary, at worst the edge of the box in its robot
/// file. Other programs show these numbers as masses and centres. Here they are chosen anew:
///
///   minimise   sum over bodies of entropic_divergence(J(phi_b), J(prior_b))
///   subject to K phi = K phi_model
///
/// All torques stay what they are, to rounding; every body is physically possible, and as close to
/// the prior as the torques allow. The prior is the given model (a CAD model of the same frames),
/// or else a rod of 5 cm diameter and of the density of water along every link. Effects, bodies
/// that are facts, and models that are not identified stay as they are.
PortableModel portable_model(const Model& arm, const std::optional<Model>& prior = std::nullopt);

/// What a file in another format is made of.
struct ExportedModel {
  Model arm;
  UrdfExtras extras;  ///< remarks on bodies, and what the links look like
  std::vector<std::string> notes;  ///< for the user, one line each
  std::vector<std::string> warnings;
};

/// A model for export: portable_model() where it has values, with remarks on what torques do not
/// determine, and the appearance of its links.
/// @param meshes_from  URDF file whose links look like this arm's; empty: the URDF file that the
///                     model came from, if its `source` names one that is still there.
ExportedModel exported_model(const Model& arm, const std::optional<Model>& prior = std::nullopt,
                             const std::string& meshes_from = {});

}  // namespace veridyn
