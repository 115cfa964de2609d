#include "recordings/files/whole_file.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <new>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr std::size_t kLargestRead = std::size_t{256} << 20;

// Reads as many bytes as there are, at most `size`; errno is zero unless the file cannot be read.
std::size_t read_into(char* data, std::size_t size, int file) {
  std::size_t done = 0;
  errno = 0;
  while (done < size) {
    const ssize_t got = ::pread(file, data + done, size - done, static_cast<off_t>(done));
    if (got == 0 || (got < 0 && errno != EINTR)) break;
    if (got < 0) continue;
    done += static_cast<std::size_t>(got);
  }
  return done;
}

// A file descriptor that is closed at the end if it was opened here.
class Descriptor {
 public:
  Descriptor(const std::string& path, const ByteStream* opened)
      : number_(opened != nullptr ? opened->descriptor() : ::open(path.c_str(), O_RDONLY | O_CLOEXEC)),
        owned_(opened == nullptr) {}
  ~Descriptor() {
    if (!owned_ || number_ < 0) return;
    ::close(number_);
    count_opened_file();
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return number_; }

 private:
  int number_;
  bool owned_;
};

}  // namespace

WholeFile::WholeFile(const std::string& path, const ByteStream* opened) {
  const Descriptor file(path, opened);
  require(file.number() >= 0, path, ": found ", std::strerror(errno), ", expected a recording.");
  struct stat about {};
  const bool known = ::fstat(file.number(), &about) == 0 && S_ISREG(about.st_mode);
  require(known, path, ": found no regular file, expected a recording.");
  size_ = static_cast<std::size_t>(about.st_size);
  require(size_ > 0, path, ": found an empty file, expected a recording.");
  const bool read = size_ <= kLargestRead;
  void* place = read ? ::mmap(nullptr, size_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0)
                     : ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file.number(), 0);
  if (place == MAP_FAILED && errno == ENOMEM) throw std::bad_alloc();
  require(place != MAP_FAILED, path, ": cannot be mapped into memory: ", std::strerror(errno), ".");
  data_ = static_cast<char*>(place);
  const std::size_t found = read ? read_into(data_, size_, file.number()) : size_;
  if (found == size_) return;
  const int error = errno;
  ::munmap(place, size_);
  require(error == 0 || error == EINTR, path, ": found ", std::strerror(error), ", expected a recording.");
  throw InvalidInput(text(path, ": found ", found, " bytes, expected ", size_,
                          ", its size when it was opened: another program cuts it."));
}

WholeFile::~WholeFile() {
  ::munmap(data_, size_);
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
