#pragma once

#include <string>

namespace veridyn {

/// All bytes of a file.
/// @param expected  description of the file for messages: "a factor file".
/// @throws InvalidInput  it is a folder, does not exist, or cannot be read.
std::string content_of_file(const std::string& path, const std::string& expected);

}  // namespace veridyn
