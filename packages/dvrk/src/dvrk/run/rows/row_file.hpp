#pragma once

#include <atomic>
#include <string>
#include <thread>

#include "dvrk/run/rows/row_keeper.hpp"

namespace veridyn::dvrk {

/// Writes the recording to a file during the run: a thread of ordinary priority appends the rows of
/// a RowKeeper, so that a killed program leaves nearly all of them. The first line says that the
/// recording is incomplete until finish().
///
/// A disk that is full before the first row leaves no file, and keeps an existing one; later it leaves the
/// whole rows that fitted.
///
/// Devices and pipes are not written during the run; only finish() writes them.
class RowFile {
 public:
  /// @param path  empty: nothing is written. @param joints  number of joints to write, from the first on.
  RowFile(std::string path, const RowKeeper& rows, Eigen::Index joints);
  ~RowFile();
  RowFile(const RowFile&) = delete;
  RowFile& operator=(const RowFile&) = delete;

  /// Writing failed; error() has the reason. Earlier rows are kept.
  bool failed() const { return failed_.load(std::memory_order_relaxed); }

  /// Writes the last rows, and the first line: "# remark", or none if it is empty. Call it once.
  void finish(const std::string& remark);

  /// After finish(): number of rows in the file, and the reason if these are not all.
  Eigen::Index rows() const { return written_; }
  const std::string& error() const { return error_; }

 private:
  void follow();  ///< the thread: appends rows until stop() or a failure
  void append();  ///< writes all new rows; opens the file at the first one
  void open();
  void name_or_remove();
  bool put(const std::string& bytes);  ///< false: failed, with the reason in error_
  void stop();  ///< ends the thread and waits for it
  void remark_in_place(const std::string& remark);  ///< overwrites the first line, truncated to its length
  void copy_rows(const std::string& remark) const;

  std::string path_;
  std::string aside_;  ///< present name of the file, until it has rows
  const RowKeeper& keeper_;
  Eigen::Index joints_;
  int file_ = -1;
  bool followed_ = false;  // a regular file
  Eigen::Index written_ = 0;
  std::string text_, error_;
  std::atomic<bool> failed_{false}, ends_{false};
  std::thread thread_;
};

}  // namespace veridyn::dvrk
