#pragma once

namespace veridyn {

/// No arm has positions, speeds or torques of this size: such numbers come from damaged files.
constexpr double kAbsurd = 1e6;

}  // namespace veridyn
