#pragma once

namespace veridyn {

/// No arm has positions, speeds or torques of this size or beyond: such numbers are damaged.
constexpr double kAbsurd = 1e6;

}  // namespace veridyn
