#include "veridyn/math/output_file.hpp"

#include <unistd.h>

#include <cstdio>
#include <utility>

#include "veridyn/math/require.hpp"

namespace veridyn {

OutputFile::OutputFile(std::string path)
    : path_(std::move(path)), aside_(text(path_, ".part-", ::getpid())) {
  stream_.open(aside_, std::ios::binary | std::ios::trunc);
  require(stream_.is_open(), path_, ": cannot be written: no such folder, or no permission.");
}

OutputFile::~OutputFile() {
  if (committed_) return;
  stream_.close();
  std::remove(aside_.c_str());
}

void OutputFile::commit() {
  stream_.close();
  require(!stream_.fail(), path_, ": writing failed (disk full?); nothing was kept.");
  require(std::rename(aside_.c_str(), path_.c_str()) == 0, path_, ": cannot be replaced.");
  committed_ = true;
}

void write_file(const std::string& path, const std::string& content) {
  OutputFile file(path);
  file.stream() << content;
  file.commit();
}

}  // namespace veridyn
