#include "recordings/same_recording.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <system_error>

namespace veridyn {

bool same_recording(const std::string& a, const std::string& b) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (a == b || fs::equivalent(a, b, error)) return true;
  if (!fs::is_regular_file(a, error) || !fs::is_regular_file(b, error)) return false;
  if (fs::file_size(a, error) != fs::file_size(b, error) || fs::file_size(a, error) == 0) return false;
  std::ifstream one(a, std::ios::binary);
  std::ifstream other(b, std::ios::binary);
  std::array<char, 1 << 16> a_bytes, b_bytes;
  while (one && other) {
    const auto a_count = one.read(a_bytes.data(), a_bytes.size()).gcount();
    if (other.read(b_bytes.data(), b_bytes.size()).gcount() != a_count) return false;
    if (!std::equal(a_bytes.begin(), a_bytes.begin() + a_count, b_bytes.begin())) return false;
  }
  return one.eof() && other.eof();
}

}  // namespace veridyn
