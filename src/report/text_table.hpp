#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace veridyn {

enum class Align { kLeft, kRight };

/// Text in aligned columns, indented by two; long text wraps within the last column.
class TextTable {
 public:
  static constexpr std::size_t kWidth = 100;

  explicit TextTable(std::vector<Align> columns) : columns_(std::move(columns)) {}

  /// Adds a row with one cell per column.
  void add(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
  std::string text() const;  ///< all rows, each ended by a line break

 private:
  std::vector<Align> columns_;
  std::vector<std::vector<std::string>> rows_;
};

/// Words in lines of at most `width` letters, broken at spaces only; at least one line.
std::vector<std::string> wrapped(const std::string& words, std::size_t width);

/// Names with two blanks between them, wrapped and indented; "none" if there are none.
std::string paragraph(const std::vector<std::string>& names);

}  // namespace veridyn
