#pragma once

#include <string>
#include <string_view>

#include "veridyn/recordings/files/byte_stream.hpp"

namespace veridyn {

/// Lines of a text file of any length, without a copy per line.
///
/// Empty lines and lines that start with `#` are skipped; a byte-order mark and carriage returns
/// are removed. Cost: memory for the longest line or 1 MiB, whichever is more.
class CsvLines {
 public:
  /// @throws InvalidInput  the file is empty, or not text (a NUL in the first piece).
  explicit CsvLines(ByteStream bytes);
  /// @throws InvalidInput  as ByteStream as well.
  explicit CsvLines(const std::string& path) : CsvLines(ByteStream(path)) {}

  /// The next line, valid until the next call. False at the end.
  /// @throws InvalidInput  not text (a line of 16 MiB), or reading fails.
  bool next(std::string_view* line);

  /// Returns to the first line. @throws InvalidInput  see ByteStream::rewind().
  void rewind();

  /// True if the last returned line was the last of the file.
  bool at_end() const { return bytes_.at_end() && bytes_.unread().empty(); }
  long number() const { return number_; }  ///< number of the last returned line, from 1
  const std::string& last_comment() const { return comment_; }  ///< text of the last comment without its `#`
  const std::string& path() const { return bytes_.path(); }

 private:
  bool next_raw(std::string_view* line);  ///< the next line, comments included; false at the end
  void read_more();  ///< throws if a line gets too long
  void skip_byte_order_mark();

  ByteStream bytes_;
  long number_ = 0;
  std::string comment_;
};

}  // namespace veridyn
