#include "files/output_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

std::string path_of(int descriptor) {
  return text("/proc/self/fd/", descriptor);
}

// Opens a file without a name; -1 if the file system does not support it.
int open_nameless(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  return ::open(folder.empty() ? "." : folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
}

// Gives the file its name. An existing file is replaced atomically, by way of a temporary second name.
bool link_to_name(int descriptor, const std::string& aside, const std::string& path) {
  const std::string from = path_of(descriptor);
  const auto link_to = [&](const std::string& name) {
    return ::linkat(AT_FDCWD, from.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0;
  };
  return link_to(path) || (link_to(aside) && std::rename(aside.c_str(), path.c_str()) == 0);
}

}  // namespace

OutputFile::OutputFile(std::string path) : path_(std::move(path)) {
  require(path_ != "-", "found '-' for a file to write, expected a name; /dev/stdout writes to the terminal.");
  std::error_code error;
  // A symbolic link is kept, and its target is replaced.
  if (std::filesystem::is_symlink(path_, error)) {
    const auto target = std::filesystem::weakly_canonical(path_, error);
    if (!error && std::filesystem::is_regular_file(target, error)) path_ = target.string();
  }
  through_ = std::filesystem::exists(path_, error) && std::filesystem::is_other(path_, error);
  aside_ = through_ ? path_ : text(path_, ".part-", ::getpid());
  if (!through_) nameless_ = open_nameless(path_);
  if (nameless_ >= 0) stream_.open(path_of(nameless_), std::ios::binary | std::ios::trunc);
  if (!stream_.is_open()) {
    if (nameless_ >= 0) ::close(std::exchange(nameless_, -1));
    stream_.clear();
    stream_.open(aside_, std::ios::binary | std::ios::trunc);
  }
  require(stream_.is_open(), path_, ": cannot be written: no such folder, or no permission.");
}

OutputFile::~OutputFile() {
  stream_.close();
  if (nameless_ >= 0) ::close(nameless_);
  if (committed_ || through_) return;
  std::remove(aside_.c_str());
}

void OutputFile::commit() {
  stream_.close();
  require(!stream_.fail(), path_, ": writing failed (disk full?); nothing was kept.");
  if (through_) return;
  const bool named = nameless_ >= 0 ? link_to_name(nameless_, aside_, path_)
                                    : std::rename(aside_.c_str(), path_.c_str()) == 0;
  require(named, path_, ": cannot be replaced.");
  committed_ = true;
}

void write_file(const std::string& path, const std::string& content) {
  OutputFile file(path);
  file.stream() << content;
  file.commit();
}

}  // namespace veridyn
