#pragma once

#include <fstream>
#include <string>

namespace veridyn {

/// A file that is either whole or not there: written aside, renamed by commit(), removed otherwise.
/// What is no regular file (a device, a pipe) is written through.
///
/// @throws InvalidInput  the place cannot be written (constructor), or the disk is full (commit).
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

/// The whole content at once.
void write_file(const std::string& path, const std::string& content);

}  // namespace veridyn
