#pragma once

#include <string>

namespace veridyn {

/// All bytes of a file.
/// @param expected  what it should be, in words: "a factor file".
/// @throws InvalidInput  it is a folder, is not there, or cannot be read.
std::string content_of_file(const std::string& path, const std::string& expected);

}  // namespace veridyn
