#pragma once

#include <string>

#include "veridyn/diagnosis/watch.hpp"

namespace veridyn::watching {

/// Description of an event, for a technician.
std::string sentence(const WatchEvent& event);

/// The same for an interval of unusable rows.
std::string blind_sentence(const WatchEvent& event, const std::string& why);

}  // namespace veridyn::watching
