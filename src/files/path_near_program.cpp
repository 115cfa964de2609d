#include "files/path_near_program.hpp"

#include <filesystem>

namespace veridyn {

std::string path_near_program(const std::string& place) {
  std::error_code unknown;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", unknown);
  if (unknown) return {};
  return (program.parent_path().parent_path() / place).string();
}

}  // namespace veridyn
