#include "recordings/files/mapped_file.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "veridyn/math/require.hpp"

namespace veridyn {

MappedFile::MappedFile(const std::string& path, const ByteStream* opened) {
  const int file =
      opened != nullptr ? opened->descriptor() : ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  require(file >= 0, path, ": found ", std::strerror(errno), ", expected a recording.");
  struct stat about {};
  const bool known = ::fstat(file, &about) == 0 && S_ISREG(about.st_mode);
  if (known && about.st_size > 0) {
    size_ = static_cast<std::size_t>(about.st_size);
    void* mapped = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file, 0);
    data_ = mapped == MAP_FAILED ? nullptr : static_cast<const char*>(mapped);
  }
  if (opened == nullptr) {
    ::close(file);
    count_opened_file();
  }
  require(known, path, ": found no regular file, expected a recording.");
  require(size_ > 0, path, ": found an empty file, expected a recording.");
  require(data_ != nullptr, path, ": cannot be mapped into memory: ", std::strerror(errno), ".");
}

MappedFile::~MappedFile() {
  if (data_ != nullptr) ::munmap(const_cast<char*>(data_), size_);
}

std::string first_bytes(const std::string& path, std::size_t count) {
  std::string bytes(count, '\0');
  std::FILE* file = std::fopen(path.c_str(), "rb");
  if (file == nullptr) return {};
  count_opened_file();
  bytes.resize(std::fread(bytes.data(), 1, count, file));
  std::fclose(file);
  return bytes;
}

}  // namespace veridyn
