#pragma once

#include <fstream>
#include <string>

namespace veridyn {

/// A file that is written atomically: to a temporary name, renamed by commit(), removed otherwise.
/// Devices and pipes are written directly.
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
  std::ofstream stream_;
  bool through_ = false;
  bool committed_ = false;
};

/// Writes the whole content at once.
void write_file(const std::string& path, const std::string& content);

}  // namespace veridyn
