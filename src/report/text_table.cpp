#include "report/text_table.hpp"

#include <algorithm>
#include <sstream>

namespace veridyn {
namespace {

constexpr std::size_t kNarrowest = 24;  // smallest width of the last column
const std::string kIndent = "  ";

std::string aligned(const std::string& cell, std::size_t width, Align align) {
  const std::string blank(width - std::min(width, cell.size()), ' ');
  return align == Align::kRight ? blank + cell : cell + blank;
}

}  // namespace

std::vector<std::string> wrapped(const std::string& words, std::size_t width) {
  std::vector<std::string> lines = {""};
  std::istringstream in(words);
  for (std::string word; in >> word;) {
    std::string& line = lines.back();
    if (line.empty()) {
      line = word;
    } else if (line.size() + 1 + word.size() <= width) {
      line += " " + word;
    } else {
      lines.push_back(word);
    }
  }
  return lines;
}

std::string TextTable::text() const {
  std::vector<std::size_t> widths(columns_.size(), 0);
  for (const auto& row : rows_) {
    for (std::size_t c = 0; c < widths.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
  }
  std::size_t before = 0;
  for (std::size_t c = 0; c + 1 < widths.size(); ++c) before += kIndent.size() + widths[c];
  before += kIndent.size();
  const std::size_t last = kWidth > before + kNarrowest ? kWidth - before : kNarrowest;
  std::string out;
  for (const auto& row : rows_) {
    std::string line;
    for (std::size_t c = 0; c + 1 < widths.size(); ++c) {
      line += kIndent + aligned(row[c], widths[c], columns_[c]);
    }
    for (const std::string& piece : wrapped(row.back(), last)) {
      line += piece.empty() ? "" : kIndent + piece;
      out += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
      line = std::string(before - kIndent.size(), ' ');
    }
  }
  return out;
}

std::string paragraph(const std::vector<std::string>& names) {
  std::string out;
  std::string line;
  for (const std::string& name : names) {
    if (!line.empty() && kIndent.size() + line.size() + 2 + name.size() > TextTable::kWidth) {
      out += kIndent + line + "\n";
      line.clear();
    }
    line += (line.empty() ? "" : "  ") + name;
  }
  return out + kIndent + (line.empty() ? "none" : line) + "\n";
}

}  // namespace veridyn
