#pragma once

#include <string>
#include <vector>

#include "diagnosis/search/motion_signals.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// Describes a curve: one-sided, periodic, odd or even, saturating, with memory. @param of  its signals.
std::string shape_words(const UnnamedShape& shape, const std::vector<MotionSignal>& of);

}  // namespace veridyn
