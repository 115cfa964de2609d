#pragma once

#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace veridyn {

/// The bytes of a file that is opened once and read in pieces. Consumed bytes can be returned, so that the
/// first bytes and the header can be examined without opening the file again. Cost: memory for the unread
/// part or 1 MiB, whichever is more.
class ByteStream {
 public:
  /// @throws InvalidInput  the file is missing, cannot be opened, or is a folder.
  /// @param wait  called at the present end of a file that may still grow: true to try again; false ends the
  /// recording.
  explicit ByteStream(const std::string& path, std::function<bool()> wait = {});

  /// Reads more data. False at the end of the file or on an error.
  bool read_on();
  std::string_view unread() const { return {buffer_.data() + begin_, end_ - begin_}; }
  void consume(std::size_t bytes) { begin_ += bytes; }  ///< removes bytes from the beginning of unread()
  bool at_end() const { return at_end_; }
  int error() const { return error_; }  ///< errno of the last read, or 0

  /// Returns to the first byte. @throws InvalidInput  a pipe of which more than 1 MiB was consumed.
  void rewind();

  const std::string& path() const { return path_; }
  int descriptor() const;

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::string path_;
  std::function<bool()> wait_;
  std::unique_ptr<std::FILE, Close> file_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0;  // unread bytes are buffer_[begin_, end_)
  std::size_t end_ = 0;
  bool dropped_ = false;  // the buffer no longer begins with the file's first byte
  bool at_end_ = false;
  int error_ = 0;
};

/// Number of recordings' files opened since the program began.
long files_opened();

/// Counts a file that is opened by other means than a ByteStream.
void count_opened_file();

}  // namespace veridyn
