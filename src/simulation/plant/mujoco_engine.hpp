#pragma once

#include <memory>

#include "veridyn/simulation/engine.hpp"

namespace veridyn {

/// An engine that simulates the arm in MuJoCo. Every moving link of the tree is a MuJoCo body with a joint of
/// its own; couplings are exact, not soft constraints: with joints s = S q + s0,
///
///   S' M_mujoco S ddq + S' bias_mujoco + effects = tau
///
/// so that M and bias come from independent software. Steps are Runge-Kutta of order four with a
/// fixed step; dry friction has the effects' regularised sign, which creeps at rest (left_out()
/// says so), and so differs from Plant's.
/// @throws InvalidInput  MuJoCo refuses the model.
std::unique_ptr<Engine> make_mujoco_engine(const Model& arm);

}  // namespace veridyn
