#include <zlib.h>

#include <map>

#include "recordings/bags/bag_sink.hpp"
#include "recordings/files/byte_reader.hpp"
#include "recordings/bags/inflate.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::bags {
namespace {

constexpr std::string_view kMagic = "\x89MCAP0\r\n";

enum Operation : std::uint8_t {
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kDataEnd = 0x0F
};

struct Schema {
  std::string name, encoding, definition;
};

class Mcap {
 public:
  Mcap(const std::string& path, BagSink* sink) : path_(path), sink_(sink) {}

  // Reads records to the end of the data; false if the data end within a record.
  bool read(std::string_view records, bool in_chunk) {
    ByteReader reader(records);
    try {
      while (reader.left() > 0) {
        const auto operation = reader.number<std::uint8_t>();
        const std::string_view content = reader.read_bytes(reader.number<std::uint64_t>());
        if (!in_chunk && (operation == kDataEnd || operation == kFooter)) return true;
        read_record(operation, content, in_chunk);
      }
      return in_chunk;
    } catch (const CutShort&) {
      return false;
    }
  }

  int damaged_chunks() const { return damaged_; }
  int damaged_records() const { return broken_; }

 private:
  void read_record(std::uint8_t operation, std::string_view content, bool in_chunk) {
    ByteReader reader(content);
    try {
      if (operation == kSchema) read_schema(&reader);
      if (operation == kChannel) read_channel(&reader);
      if (operation == kMessage) read_message(&reader);
      if (operation == kChunk && !in_chunk) read_chunk(&reader);
    } catch (const CutShort&) {
      ++broken_;
    }
  }

  void read_schema(ByteReader* reader) {
    const auto id = reader->number<std::uint16_t>();
    Schema& schema = schemas_[id];
    schema.name = reader->sized_text();
    schema.encoding = reader->sized_text();
    schema.definition = reader->sized_text();
  }

  void read_channel(ByteReader* reader) {
    const auto id = reader->number<std::uint16_t>();
    if (channels_.count(id) > 0) return;
    const auto schema_id = reader->number<std::uint16_t>();
    Channel channel;
    channel.topic = reader->sized_text();
    channel.encoding = reader->sized_text();
    ByteReader metadata(reader->sized_text());
    while (metadata.left() > 0) {
      const std::string_view key = metadata.sized_text();
      const std::string_view value = metadata.sized_text();
      if (key == "callerid") channel.publisher = value;
    }
    const auto schema = schemas_.find(schema_id);
    if (schema != schemas_.end()) {
      channel.type = schema->second.name;
      const std::string& form = schema->second.encoding;
      if (form == "ros1msg" || form == "ros2msg") channel.definition = schema->second.definition;
    }
    channels_[id] = sink_->open(channel);
  }

  void read_message(ByteReader* reader) {
    const auto found = channels_.find(reader->number<std::uint16_t>());
    reader->skip(4);  // sequence
    const auto logged = static_cast<std::int64_t>(reader->number<std::uint64_t>());
    reader->skip(8);  // time of publication
    if (found != channels_.end())
      sink_->message(found->second, logged, reader->read_bytes(reader->left()));
  }

  void read_chunk(ByteReader* reader) {
    reader->skip(16);  // first and last time
    const auto size = reader->number<std::uint64_t>();
    const auto checksum = reader->number<std::uint32_t>();
    const std::string_view compression = reader->sized_text();
    const std::string_view packed = reader->read_bytes(reader->number<std::uint64_t>());
    Inflated inflated;
    std::string_view records = packed;
    if (!compression.empty()) {
      try {
        inflated = inflate(compression, packed, std::min<std::uint64_t>(size, kInflateLimit));
      } catch (const InvalidInput& error) {
        throw InvalidInput(path_ + ": " + error.what());
      }
      records = inflated.bytes;
    }
    const bool whole = records.size() == size && (compression.empty() || inflated.whole);
    const bool intact = checksum == 0 || checksum == crc_of(records);
    if (!whole || !intact || !read(records, true)) ++damaged_;
  }

  static std::uint32_t crc_of(std::string_view bytes) {
    return static_cast<std::uint32_t>(
        crc32_z(0, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()));
  }

  const std::string& path_;
  BagSink* sink_;
  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, int> channels_;
  int damaged_ = 0;
  int broken_ = 0;
};

}  // namespace

void read_mcap(std::string_view bytes, const std::string& path, BagSink* sink) {
  require(bytes.substr(0, kMagic.size()) == kMagic, path,
          ": found other first bytes, expected an MCAP file.");
  Mcap file(path, sink);
  if (!file.read(bytes.substr(kMagic.size()), false))
    sink->remarks.emplace_back("the file ends early: it is read up to its last whole record.");
  if (file.damaged_chunks() > 0)
    sink->remarks.push_back(
        text(file.damaged_chunks(), " of its chunks are damaged and left out."));
  if (file.damaged_records() > 0)
    sink->remarks.push_back(
        text(file.damaged_records(), " of its records are damaged and left out."));
}

}  // namespace veridyn::bags
