#pragma once

#include <string>

namespace veridyn {

/// A file or folder of the installation, beside the program that runs: /usr/share/veridyn/robots for
/// /usr/bin/veridyn and "share/veridyn/robots". Empty where the system does not tell its programs.
/// Installations may be moved, and packages are built elsewhere than they are used.
std::string beside_program(const std::string& place);

}  // namespace veridyn
