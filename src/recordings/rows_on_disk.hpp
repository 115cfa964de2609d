#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "veridyn/recordings/recording.hpp"

namespace veridyn {

/// Parsed rows of recordings in one temporary file without a name, for all passes after the first: it is
/// faster than parsing text and uses no memory of the process. Threads may share it. Without sufficient
/// space, or if the file cannot be written, it stores nothing.
class RowsOnDisk {
 public:
  static constexpr long kMostBytes = 2L << 30;      ///< largest size of the file [bytes]
  static constexpr double kMostOfFreeSpace = 0.25;  ///< largest share of the free space of its disk

  RowsOnDisk() = default;
  ~RowsOnDisk();
  RowsOnDisk(const RowsOnDisk&) = delete;
  RowsOnDisk& operator=(const RowsOnDisk&) = delete;

  /// A stored recording, as pieces in order.
  struct Stored {
    Recording without_rows;  ///< source and signals of the recording, with zero rows
    struct Piece {
      long offset;  ///< offset of the first column in the file, in doubles
      int rows;
    };
    std::vector<Piece> pieces;
    RecordingFacts facts;
    long rows() const;
  };

  /// The recording with this key; null if it is not stored.
  std::shared_ptr<const Stored> find(const std::string& key) const;

  /// Appends a piece to `to`. False if it cannot be stored.
  bool append(const Recording& piece, Stored& to);
  void finish(const std::string& key, Stored stored);  ///< from now on find() returns it

  /// A reader of the rows from the first one on, with the interface of RecordingReader::next().
  std::function<Recording(int)> rows_of(std::shared_ptr<const Stored> stored) const;

 private:
  bool open();

  mutable std::mutex mutex_;
  int file_ = -1;
  bool tried_ = false;
  long most_ = 0, used_ = 0;  // doubles
  std::map<std::string, std::shared_ptr<const Stored>> all_;
};

}  // namespace veridyn
