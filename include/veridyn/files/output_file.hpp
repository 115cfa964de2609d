#pragma once

#include <fstream>
#include <string>

namespace veridyn {

/// A file that is written atomically: it has no name before commit(), so that a program that is killed leaves
/// nothing behind. If the file system has no files without a name, it has a temporary name and is removed
/// unless it is committed. Devices and pipes are written directly.
///
/// @throws InvalidInput  the file cannot be created (constructor), or the disk is full (commit).
class OutputFile {
 public:
  explicit OutputFile(std::string path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  std::ostream& stream() { return stream_; }
  void commit();

 private:
  std::string path_;
  std::string aside_;
  int nameless_ = -1;  ///< descriptor of a file without a name
  std::ofstream stream_;
  bool through_ = false;
  bool committed_ = false;
};

/// Writes the whole content at once.
void write_file(const std::string& path, const std::string& content);

}  // namespace veridyn
