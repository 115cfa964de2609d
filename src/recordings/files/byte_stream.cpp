#include "recordings/files/byte_stream.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <new>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr std::size_t kPieceSize = 1 << 20;

std::atomic<long> g_opened{0};

}  // namespace

ByteStream::ByteStream(const std::string& path, std::function<bool()> wait)
    : path_(path), wait_(std::move(wait)), buffer_(kPieceSize) {
  struct stat about {};
  const bool there = ::stat(path.c_str(), &about) == 0;
  require(there, path, ": found ", errno == ENOENT ? "no such file" : std::strerror(errno),
          ", expected a recording.");
  require(!S_ISDIR(about.st_mode), path, ": found a folder, expected a recording (CSV).");
  file_.reset(std::fopen(path.c_str(), "rb"));
  if (file_ == nullptr && errno == ENOMEM) throw std::bad_alloc();
  require(file_ != nullptr, path, ": found ", std::strerror(errno),
          ", expected a recording (CSV).");
  std::setvbuf(file_.get(), nullptr, _IONBF, 0);
  count_opened_file();
}

int ByteStream::descriptor() const {
  return ::fileno(file_.get());
}

bool ByteStream::read_on() {
  if (end_ == buffer_.size()) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    dropped_ = dropped_ || begin_ > 0;
    end_ -= begin_;
    begin_ = 0;
    if (end_ == buffer_.size()) buffer_.resize(2 * buffer_.size());
  }
  for (;;) {  // read(2) returns the bytes that a pipe has now, whereas fread() would wait for more
    const ssize_t got = ::read(descriptor(), buffer_.data() + end_, buffer_.size() - end_);
    error_ = got < 0 ? errno : 0;
    if (error_ == EINTR && (!wait_ || wait_())) continue;
    if (got == 0 && wait_ && wait_()) continue;
    end_ += got > 0 ? static_cast<std::size_t>(got) : 0;
    at_end_ = got <= 0;
    return got > 0;
  }
}

void ByteStream::rewind() {
  begin_ = 0;
  if (!dropped_) return;
  require(::lseek(descriptor(), 0, SEEK_SET) == 0, path_,
          ": found more than 1 MiB in front of the rows of a pipe, expected a recording.");
  end_ = 0;
  dropped_ = at_end_ = false;
}

long files_opened() {
  return g_opened.load();
}

void count_opened_file() {
  ++g_opened;
}

}  // namespace veridyn
