#pragma once

#include "veridyn/tool/open_commands.hpp"

namespace veridyn::cli {

/// Arms of the dVRK by name, with their closed forms.
KinematicsExtension dvrk_kinematics();

}  // namespace veridyn::cli
