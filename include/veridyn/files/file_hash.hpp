#pragma once

#include <string>

namespace veridyn {

/// SHA-256 of a file's bytes in 64 hexadecimal digits, as `sha256sum` prints it; empty if the file cannot be
/// read or is no regular file. Cost: one pass, about 3 ns a byte.
std::string sha256_of_file(const std::string& path);

}  // namespace veridyn
