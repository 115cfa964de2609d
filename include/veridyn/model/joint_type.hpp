#pragma once

namespace veridyn {

enum class JointType { kFixed, kRevolute, kPrismatic };

}  // namespace veridyn
