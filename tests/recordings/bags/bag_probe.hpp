#pragma once

#include <string>
#include <string_view>

namespace veridyn::bags {

/// Reads bytes as whichever container they look like, decodes everything, and forgets it: nothing
/// but InvalidInput may come out. @returns the number of values.
long probe_container(std::string_view bytes);

}  // namespace veridyn::bags
