#pragma once

#include <functional>
#include <string>
#include <vector>

#include "veridyn/files/output_file.hpp"

namespace veridyn::cli {

/// One of the files of a command. All contents are computed before a file is written, so that an error leaves
/// no file.
struct FileToWrite {
  std::string path, content;
  std::function<void()> tell = {};  ///< prints remarks on this file once all files are written
};

/// Writes all files, then calls their tell().
inline void write_all(const std::vector<FileToWrite>& files) {
  for (const FileToWrite& file : files) write_file(file.path, file.content);
  for (const FileToWrite& file : files) {
    if (file.tell) file.tell();
  }
}

}  // namespace veridyn::cli
