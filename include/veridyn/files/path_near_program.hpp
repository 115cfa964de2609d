#pragma once

#include <string>

namespace veridyn {

/// Finds a file or folder of the installation relative to the running program: /usr/share/veridyn/robots for
/// /usr/bin/veridyn and "share/veridyn/robots". An absolute path would be wrong after an installation is
/// moved. Empty if the system does not reveal the program's path.
std::string path_near_program(const std::string& place);

}  // namespace veridyn
