#include "files/file_hash.hpp"

#include <sha2.h>

#include <array>
#include <filesystem>

namespace veridyn {

std::string sha256_of_file(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return {};
  std::array<char, SHA256_DIGEST_STRING_LENGTH> digits{};
  const char* const done = ::SHA256File(path.c_str(), digits.data());
  return done == nullptr ? std::string() : std::string(digits.data());
}

}  // namespace veridyn
