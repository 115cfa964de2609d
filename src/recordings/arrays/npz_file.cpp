#include <zlib.h>

#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>

#include "recordings/arrays/array_recording.hpp"
#include "math/most_rows.hpp"
#include "recordings/files/byte_reader.hpp"
#include "recordings/files/whole_file.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::recordings {
namespace {

using bags::ByteReader;
using bags::CutShort;

constexpr std::uint32_t kEndOfDirectory = 0x06054b50;
constexpr std::uint32_t kDirectoryEntry = 0x02014b50;
constexpr std::uint32_t kLocalHeader = 0x04034b50;
constexpr std::size_t kLargest = std::size_t{4} << 30;

struct Entry {
  std::string name;
  std::uint16_t method = 0;
  std::uint64_t packed = 0, size = 0, offset = 0;
};

// Reads the extra field, which holds sizes beyond 4 GiB, and those that NumPy did not know in advance.
void read_large_sizes(std::string_view extra, Entry* entry) {
  ByteReader reader(extra);
  while (reader.left() >= 4) {
    const auto id = reader.number<std::uint16_t>();
    ByteReader field(reader.read_bytes(reader.number<std::uint16_t>()));
    if (id != 1) continue;
    if (entry->size == 0xFFFFFFFFu) entry->size = field.number<std::uint64_t>();
    if (entry->packed == 0xFFFFFFFFu) entry->packed = field.number<std::uint64_t>();
    if (entry->offset == 0xFFFFFFFFu) entry->offset = field.number<std::uint64_t>();
  }
}

// The entries that the central directory at the end of the file lists.
std::vector<Entry> zip_entries(std::string_view bytes) {
  std::size_t end = bytes.size() < 22 ? std::string_view::npos : bytes.size() - 22;
  const std::size_t farthest = bytes.size() > 66000 ? bytes.size() - 66000 : 0;
  while (end != std::string_view::npos &&
         ByteReader(bytes.substr(end)).number<std::uint32_t>() != kEndOfDirectory)
    end = end > farthest ? end - 1 : std::string_view::npos;
  if (end == std::string_view::npos) throw CutShort("no directory at its end");
  ByteReader tail(bytes.substr(end + 10));
  const auto count = tail.number<std::uint16_t>();
  tail.skip(4);
  ByteReader reader(bytes);
  reader.go_to(tail.number<std::uint32_t>());
  std::vector<Entry> entries;
  for (int k = 0; k < count; ++k) {
    if (reader.number<std::uint32_t>() != kDirectoryEntry) throw CutShort("a damaged directory");
    Entry entry;
    reader.skip(6);
    entry.method = reader.number<std::uint16_t>();
    reader.skip(8);
    entry.packed = reader.number<std::uint32_t>();
    entry.size = reader.number<std::uint32_t>();
    const auto name = reader.number<std::uint16_t>();
    const auto extra = reader.number<std::uint16_t>();
    const auto comment = reader.number<std::uint16_t>();
    reader.skip(8);
    entry.offset = reader.number<std::uint32_t>();
    entry.name = reader.read_bytes(name);
    read_large_sizes(reader.read_bytes(extra), &entry);
    reader.skip(comment);
    entries.push_back(std::move(entry));
  }
  return entries;
}

std::string unpacked_content(std::string_view bytes, const Entry& entry) {
  ByteReader reader(bytes);
  reader.go_to(entry.offset);
  if (reader.number<std::uint32_t>() != kLocalHeader) throw CutShort("a damaged entry");
  reader.skip(22);
  const auto name = reader.number<std::uint16_t>();
  const auto extra = reader.number<std::uint16_t>();
  reader.skip(std::uint64_t{name} + extra);
  const std::string_view packed = reader.read_bytes(entry.packed);
  if (entry.method == 0) return std::string(packed);
  if (entry.method != 8) throw CutShort("an entry packed in another way than deflate");
  // Deflate compresses by at most a factor of about a thousand.
  if (entry.size > kLargest || entry.size / 1100 > packed.size() + 1)
    throw CutShort("an impossible size");
  std::string out(static_cast<std::size_t>(entry.size), '\0');
  z_stream stream{};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) throw CutShort("no memory");
  std::size_t done = 0;
  std::size_t fed = 0;
  int state = Z_OK;
  while (state == Z_OK && (fed < packed.size() || stream.avail_in > 0)) {
    if (stream.avail_in == 0) {
      stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data() + fed));
      stream.avail_in = static_cast<uInt>(std::min<std::size_t>(packed.size() - fed, 1u << 30));
      fed += stream.avail_in;
    }
    stream.next_out = reinterpret_cast<Bytef*>(out.data() + done);
    const auto room = static_cast<uInt>(std::min<std::size_t>(out.size() - done, 1u << 30));
    stream.avail_out = room;
    state = ::inflate(&stream, Z_NO_FLUSH);
    done += room - stream.avail_out;
    if (room == 0 && state == Z_OK) break;
  }
  inflateEnd(&stream);
  if (state != Z_STREAM_END || done != out.size()) throw CutShort("an entry that cannot be unpacked");
  return out;
}

// Value of a key in the header's dictionary, as text.
std::string value_of(const std::string& header, const std::string& key) {
  const std::size_t at = header.find("'" + key + "'");
  if (at == std::string::npos) throw CutShort("an array without " + key);
  std::size_t begin = header.find(':', at);
  if (begin == std::string::npos) throw CutShort("a damaged header");
  begin = header.find_first_not_of(" ", begin + 1);
  if (begin == std::string::npos) throw CutShort("a damaged header");
  const char open = header[begin];
  const std::size_t end = open == '\''  ? header.find('\'', begin + 1)
                          : open == '(' ? header.find(')', begin)
                                        : header.find_first_of(",}", begin);
  if (end == std::string::npos) throw CutShort("a damaged header");
  return open == '\'' || open == '(' ? header.substr(begin + 1, end - begin - 1)
                                     : header.substr(begin, end - begin);
}

template <typename T>
void read_npz_numbers(ByteReader* reader, bool big, std::vector<double>* out) {
  for (double& value : *out) {
    const std::string_view raw = reader->read_bytes(sizeof(T));
    char bytes[sizeof(T)];
    for (std::size_t k = 0; k < sizeof(T); ++k) bytes[k] = raw[big ? sizeof(T) - 1 - k : k];
    value = static_cast<double>(ByteReader(std::string_view(bytes, sizeof(T))).number<T>());
  }
}

struct Header {
  std::string type;
  bool columns_first = false;
  std::vector<std::size_t> shape;
};

Header parse_header(ByteReader* reader) {
  if (reader->read_bytes(6) != std::string_view("\x93NUMPY", 6)) throw CutShort("an entry that is no array");
  const auto version = reader->number<std::uint8_t>();
  reader->skip(1);
  const std::uint32_t size =
      version == 1 ? reader->number<std::uint16_t>() : reader->number<std::uint32_t>();
  const std::string text(reader->read_bytes(size));
  Header header;
  header.type = value_of(text, "descr");
  header.columns_first = value_of(text, "fortran_order").rfind("True", 0) == 0;
  const std::string shape = value_of(text, "shape");
  for (std::size_t k = 0; k < shape.size(); ++k) {
    std::size_t length = 0;
    const auto [rest, error] = std::from_chars(shape.data() + k, shape.data() + shape.size(), length);
    if (error != std::errc()) continue;
    header.shape.push_back(length);
    k = static_cast<std::size_t>(rest - shape.data());
  }
  return header;
}

// Reads strings of a fixed width, with one or four bytes for each character.
std::vector<std::string> texts_in(const Header& header, ByteReader* reader) {
  std::size_t width = 0;
  std::from_chars(header.type.data() + 2, header.type.data() + header.type.size(), width);
  const std::size_t letter = header.type[1] == 'U' ? 4 : 1;
  std::vector<std::string> out;
  if (header.shape.size() != 1 || width == 0 || header.shape[0] > 1000 || width > 1000) return out;
  for (std::size_t k = 0; k < header.shape[0]; ++k) {
    std::string one;
    for (std::size_t c = 0; c < width; ++c) {
      const std::string_view raw = reader->read_bytes(letter);
      const char low = header.type[0] == '>' ? raw[letter - 1] : raw[0];
      if (low != '\0') one += low;
    }
    out.push_back(one);
  }
  return out;
}

void read_array(const std::string& name, std::string_view bytes, ArraySet* set) {
  ByteReader reader(bytes);
  const Header header = parse_header(&reader);
  if (header.type.size() < 3) return;
  if (header.type[1] == 'U' || header.type[1] == 'S') {
    std::vector<std::string> texts = texts_in(header, &reader);
    if (name == "joints" || name == "joint_names" || name == "names") set->joint_names = texts;
    return;
  }
  if (header.shape.empty() || header.shape.size() > 2) return;
  NamedArray array;
  array.name = name;
  array.rows = header.shape[0];
  array.columns = header.shape.size() == 2 ? header.shape[1] : 1;
  if (array.columns > 0 && array.rows > reader.left() / array.columns) throw CutShort("an array longer than its entry");
  array.values.resize(array.rows * array.columns);
  const bool big = header.type[0] == '>';
  const std::string kind = header.type.substr(1);
  if (kind == "f8") {
    read_npz_numbers<double>(&reader, big, &array.values);
  } else if (kind == "f4") {
    read_npz_numbers<float>(&reader, big, &array.values);
  } else if (kind == "i8") {
    read_npz_numbers<std::int64_t>(&reader, big, &array.values);
  } else if (kind == "u8") {
    read_npz_numbers<std::uint64_t>(&reader, big, &array.values);
  } else if (kind == "i4") {
    read_npz_numbers<std::int32_t>(&reader, big, &array.values);
  } else if (kind == "u4") {
    read_npz_numbers<std::uint32_t>(&reader, big, &array.values);
  } else {
    return;  // not usable as a signal
  }
  if (header.columns_first && array.columns > 1) {
    std::vector<double> turned(array.values.size());
    for (std::size_t r = 0; r < array.rows; ++r) {
      for (std::size_t c = 0; c < array.columns; ++c)
        turned[r * array.columns + c] = array.values[c * array.rows + r];
    }
    array.values = std::move(turned);
  }
  set->arrays.push_back(std::move(array));
}

}  // namespace

ArraySet read_npz(const ByteStream& opened) {
  const std::string& path = opened.path();
  const WholeFile file(path, &opened);
  ArraySet set;
  try {
    const std::vector<Entry> entries = zip_entries(file.bytes());
    double unpacked = 0.0;
    for (const Entry& entry : entries) unpacked += static_cast<double>(entry.size);
    const double most = sizeof(double) * most_rows(1.0);
    require(unpacked <= most, path, ": found arrays of ", std::ceil(unpacked / 1e6),
            " MB, expected at most ", std::floor(most / 1e6), " MB, what this machine holds.");
    for (const Entry& entry : entries) {
      const bool workbook = entry.name.rfind("xl/", 0) == 0;
      require(!workbook, path, ": found an Excel workbook, expected it saved as CSV.");
      const std::size_t end = entry.name.rfind(".npy");
      if (end == std::string::npos) continue;
      read_array(entry.name.substr(0, end), unpacked_content(file.bytes(), entry), &set);
    }
  } catch (const CutShort& error) {
    throw InvalidInput(text(path, ": found ", error.what(), ", expected an intact .npz of NumPy."));
  }
  require(!set.arrays.empty(), path, ": found a zip archive without arrays, expected .npz of NumPy.");
  return set;
}

}  // namespace veridyn::recordings
