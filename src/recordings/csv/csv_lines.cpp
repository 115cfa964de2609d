#include "recordings/csv/csv_lines.hpp"

#include <cerrno>
#include <cstring>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr std::size_t kLongestLine = 16 << 20;
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

}  // namespace

CsvLines::CsvLines(ByteStream bytes) : bytes_(std::move(bytes)) {
  if (bytes_.unread().empty()) read_more();
  require(!bytes_.unread().empty(), path(), ": found an empty file, expected a recording (CSV).");
  require(bytes_.unread().find('\0') == std::string_view::npos, path(),
          ": found binary data, expected text (CSV), or a whole bag, MCAP, .npz, .mat or HDF5 file.");
  skip_byte_order_mark();
}

void CsvLines::skip_byte_order_mark() {
  if (bytes_.unread().substr(0, kByteOrderMark.size()) == kByteOrderMark)
    bytes_.consume(kByteOrderMark.size());
}

void CsvLines::rewind() {
  bytes_.rewind();
  if (bytes_.unread().empty()) read_more();
  skip_byte_order_mark();
  number_ = 0;
  comment_.clear();
}

void CsvLines::read_more() {
  require(bytes_.unread().size() < kLongestLine, path(), ":", number_ + 1,
          ": found a line longer than 16 MiB, expected a recording (CSV).");
  const bool more = bytes_.read_on();
  require(more || bytes_.error() == 0 || bytes_.error() == EINTR, path(),
          ": reading failed after line ", number_, ": ", std::strerror(bytes_.error()), ".");
}

bool CsvLines::next_raw(std::string_view* line) {
  std::size_t searched = 0;
  for (;;) {
    const std::string_view unread = bytes_.unread();
    const std::size_t found = unread.find('\n', searched);
    const bool whole = found != std::string_view::npos;
    if (!whole && !bytes_.at_end()) {
      searched = unread.size();
      read_more();
      continue;
    }
    if (unread.empty()) return false;
    *line = unread.substr(0, found);
    bytes_.consume(line->size() + (whole ? 1 : 0));
    ++number_;
    return true;
  }
}

bool CsvLines::next(std::string_view* line) {
  while (next_raw(line)) {
    while (!line->empty() && (line->back() == '\r' || line->back() == ' ')) line->remove_suffix(1);
    if (line->empty()) continue;
    if (line->front() != '#') return true;
    comment_.assign(line->substr(1));
  }
  return false;
}

}  // namespace veridyn
