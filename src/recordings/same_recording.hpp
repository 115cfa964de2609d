#pragma once

#include <string>

namespace veridyn {

/// True for two names of one file or folder, links included, and for two files of equal contents.
/// Two empty files are different, and so is a file that does not exist from any other.
bool same_recording(const std::string& a, const std::string& b);

}  // namespace veridyn
