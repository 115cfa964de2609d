#pragma once

#include <string>

namespace veridyn {

/// True for one file or folder under two names, links included, and for two files of the same bytes.
/// Two empty files are different, and so are a file that does not exist and any other.
bool same_recording(const std::string& a, const std::string& b);

}  // namespace veridyn
