#include "files/input_file.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>

#include "veridyn/math/require.hpp"

namespace veridyn {

std::string content_of_file(const std::string& path, const std::string& expected) {
  std::error_code error;
  // Opening a folder succeeds; reading it does not.
  require(!std::filesystem::is_directory(path, error), path, ": found a folder, expected ", expected, ".");
  std::ifstream file(path, std::ios::binary);
  require(file.is_open(), path,
          std::filesystem::exists(path, error) ? ": cannot be read, expected " : ": found no such file, expected ",
          expected, ".");
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace veridyn
