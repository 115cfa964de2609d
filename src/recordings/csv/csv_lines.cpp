#include "recordings/csv/csv_lines.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr std::size_t kBufferSize = 1 << 20;
constexpr std::size_t kLongestLine = 16 << 20;

}  // namespace

CsvLines::CsvLines(const std::string& path, std::function<bool()> wait)
    : path_(path), wait_(std::move(wait)), buffer_(kBufferSize) {
  struct stat about {};
  const bool there = ::stat(path.c_str(), &about) == 0;
  require(there, path, ": found ", errno == ENOENT ? "no such file" : std::strerror(errno),
          ", expected a recording.");
  require(!S_ISDIR(about.st_mode), path, ": found a folder, expected a recording (CSV).");
  file_.reset(std::fopen(path.c_str(), "rb"));
  require(file_ != nullptr, path, ": found ", std::strerror(errno),
          ", expected a recording (CSV).");
  std::setvbuf(file_.get(), nullptr, _IONBF, 0);
  require(refill(), path, ": found an empty file, expected a recording (CSV).");
  require(std::memchr(buffer_.data(), '\0', end_) == nullptr, path,
          ": found binary data, expected text (CSV), or a whole bag, MCAP, .npz, .mat or HDF5 file.");
  if (end_ >= 3 && std::memcmp(buffer_.data(), "\xEF\xBB\xBF", 3) == 0) begin_ = 3;
}

bool CsvLines::refill() {
  std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
  end_ -= begin_;
  begin_ = 0;
  if (end_ == buffer_.size()) {
    require(buffer_.size() < kLongestLine, path_, ":", number_ + 1,
            ": found a line longer than 16 MiB, expected a recording (CSV).");
    buffer_.resize(2 * buffer_.size());
  }
  for (;;) {  // read(2) returns what a pipe has by now, where fread() would wait for more
    const ssize_t got =
        ::read(::fileno(file_.get()), buffer_.data() + end_, buffer_.size() - end_);
    if (got < 0 && errno == EINTR && (!wait_ || wait_())) continue;
    require(got >= 0 || errno == EINTR, path_, ": reading failed after line ", number_, ": ",
            std::strerror(errno), ".");
    if (got == 0 && wait_ && wait_()) continue;
    end_ += got > 0 ? static_cast<std::size_t>(got) : 0;
    at_end_ = got <= 0;
    return got > 0;
  }
}

bool CsvLines::next_raw(std::string_view* line) {
  std::size_t searched = 0;
  for (;;) {
    const char* first = buffer_.data() + begin_;
    const void* found = std::memchr(first + searched, '\n', end_ - begin_ - searched);
    std::size_t length = end_ - begin_;
    if (found != nullptr) {
      length = static_cast<std::size_t>(static_cast<const char*>(found) - first);
    } else if (!at_end_) {
      searched = length;
      refill();
      continue;
    } else if (length == 0) {
      return false;
    }
    *line = std::string_view(first, length);
    begin_ += length + (found != nullptr ? 1 : 0);
    ++number_;
    return true;
  }
}

bool CsvLines::next(std::string_view* line) {
  while (next_raw(line)) {
    while (!line->empty() && (line->back() == '\r' || line->back() == ' ')) line->remove_suffix(1);
    if (line->empty()) continue;
    if (line->front() != '#') return true;
    comment_.assign(line->substr(1));
  }
  return false;
}

}  // namespace veridyn
