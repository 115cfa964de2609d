#pragma once

#include <string>

#include "veridyn/watch/watch.hpp"

namespace veridyn::watching {

/// Description of an event, for a technician.
std::string sentence(const WatchEvent& event);

}  // namespace veridyn::watching
