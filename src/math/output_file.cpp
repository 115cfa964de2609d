#include "math/output_file.hpp"

#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

#include "veridyn/math/require.hpp"

namespace veridyn {

OutputFile::OutputFile(std::string path) : path_(std::move(path)) {
  std::error_code error;
  // A symbolic link is kept, and its target replaced.
  if (std::filesystem::is_symlink(path_, error)) {
    const auto target = std::filesystem::weakly_canonical(path_, error);
    if (!error && std::filesystem::is_regular_file(target, error)) path_ = target.string();
  }
  through_ = std::filesystem::exists(path_, error) && std::filesystem::is_other(path_, error);
  aside_ = through_ ? path_ : text(path_, ".part-", ::getpid());
  stream_.open(aside_, std::ios::binary | std::ios::trunc);
  require(stream_.is_open(), path_, ": cannot be written: no such folder, or no permission.");
}

OutputFile::~OutputFile() {
  if (committed_ || through_) return;
  stream_.close();
  std::remove(aside_.c_str());
}

void OutputFile::commit() {
  stream_.close();
  require(!stream_.fail(), path_, ": writing failed (disk full?); nothing was kept.");
  if (through_) return;
  require(std::rename(aside_.c_str(), path_.c_str()) == 0, path_, ": cannot be replaced.");
  committed_ = true;
}

void write_file(const std::string& path, const std::string& content) {
  OutputFile file(path);
  file.stream() << content;
  file.commit();
}

}  // namespace veridyn
