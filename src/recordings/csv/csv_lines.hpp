#pragma once

#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace veridyn {

/// Lines of a text file of any length, without a copy per line.
///
/// Empty lines and lines that start with `#` are skipped; a byte-order mark and carriage returns
/// are taken off. Cost: memory for the longest line or 1 MiB, whichever is more.
class CsvLines {
 public:
  /// @throws InvalidInput  the file is missing, unreadable, a folder, or empty.
  /// @param wait  called where a file that still grows ends for now; true: look again.
  explicit CsvLines(const std::string& path, std::function<bool()> wait = {});

  /// The next line, valid until the next call. False at the end.
  /// @throws InvalidInput  not text (a NUL in the first piece, or a line of 16 MiB), or reading
  /// fails.
  bool next(std::string_view* line);

  /// Whether the file ends behind the line last returned.
  bool at_end() const { return at_end_ && begin_ == end_; }
  long number() const { return number_; }  ///< Number of the line last returned, from 1
  const std::string& last_comment() const { return comment_; }  ///< without its `#`
  const std::string& path() const { return path_; }

 private:
  bool next_raw(std::string_view* line);
  bool refill();

  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::string path_;
  std::function<bool()> wait_;
  std::unique_ptr<std::FILE, Close> file_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0;  // unread bytes are buffer_[begin_, end_)
  std::size_t end_ = 0;
  bool at_end_ = false;
  long number_ = 0;
  std::string comment_;
};

}  // namespace veridyn
