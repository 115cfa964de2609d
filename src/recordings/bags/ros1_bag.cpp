#include <map>
#include <optional>
#include <vector>

#include "recordings/bags/bag_sink.hpp"
#include "recordings/files/byte_reader.hpp"
#include "recordings/bags/inflate.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::bags {
namespace {

constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
constexpr std::int64_t kNanoseconds = 1000000000;

enum Operation : std::uint8_t {
  kMessage = 0x02,
  kFileHeader = 0x03,
  kIndexData = 0x04,
  kChunk = 0x05,
  kChunkInfo = 0x06,
  kConnection = 0x07
};

using Fields = std::map<std::string_view, std::string_view>;

// Parses fields `name=value`, each after its length. The value is binary and may contain '='.
Fields fields_of(std::string_view header) {
  Fields fields;
  ByteReader reader(header);
  while (reader.left() > 0) {
    const std::string_view field = reader.sized_text();
    const std::size_t equals = field.find('=');
    if (equals == std::string_view::npos) throw CutShort("a field without '='");
    fields[field.substr(0, equals)] = field.substr(equals + 1);
  }
  return fields;
}

template <typename T>
T number_in(const Fields& fields, std::string_view name) {
  const auto found = fields.find(name);
  if (found == fields.end()) throw CutShort("a header without " + std::string(name));
  return ByteReader(found->second).number<T>();
}

std::string text_in(const Fields& fields, std::string_view name) {
  const auto found = fields.find(name);
  return found == fields.end() ? std::string() : std::string(found->second);
}

// [ns] since 1970. Throws CutShort without the field `time`.
std::int64_t time_in(const Fields& fields) {
  const auto found = fields.find("time");
  if (found == fields.end()) throw CutShort("a message without time");
  ByteReader reader(found->second);
  const std::int64_t seconds = reader.number<std::uint32_t>();
  return seconds * kNanoseconds + reader.number<std::uint32_t>();
}

struct Record {
  Fields fields;
  std::uint8_t operation = 0;
  std::string_view data;
};

Record next_record(ByteReader* reader) {
  Record record;
  record.fields = fields_of(reader->sized_text());
  record.operation = number_in<std::uint8_t>(record.fields, "op");
  const auto size = reader->number<std::uint32_t>();
  // Very old bags have a wrong size here, but the count is correct.
  const bool by_count = record.operation == kIndexData && record.fields.count("count") > 0;
  record.data = reader->read_bytes(
      by_count ? std::uint64_t{12} * number_in<std::uint32_t>(record.fields, "count") : size);
  return record;
}

class Bag {
 public:
  Bag(std::string_view bytes, const std::string& path, BagSink* sink)
      : bytes_(bytes), path_(path), sink_(sink) {}

  void read() {
    ByteReader reader(bytes_);
    reader.skip(kMagic.size());
    Record header;
    try {
      header = next_record(&reader);
    } catch (const CutShort&) {
      throw InvalidInput(path_ + ": found the start of a ROS 1 bag and no header, expected more.");
    }
    require(header.operation == kFileHeader, path_,
            ": found no file header, expected a ROS 1 bag of format 2.0.");
    const std::string cipher = text_in(header.fields, "encryptor");
    require(cipher.empty(), path_, ": found a bag that is encrypted with ", cipher,
            ", expected a plain one (rosbag decrypt).");
    const std::size_t first = reader.position();
    if (!read_by_index(header.fields)) read_on(first);
  }

 private:
  // Reads chunks in the order of the index at the end of the file. Returns false, and delivers
  // nothing, if there is no valid index.
  bool read_by_index(const Fields& header) {
    std::vector<std::uint64_t> chunks;
    try {
      const auto index = number_in<std::uint64_t>(header, "index_pos");
      if (index == 0) return false;
      ByteReader reader(bytes_);
      reader.go_to(index);
      const auto count = number_in<std::uint32_t>(header, "chunk_count");
      while (reader.left() > 0) {
        const Record record = next_record(&reader);
        if (record.operation == kChunkInfo)
          chunks.push_back(number_in<std::uint64_t>(record.fields, "chunk_pos"));
      }
      if (chunks.size() != count) return false;
      for (const std::uint64_t chunk : chunks) {
        reader.go_to(chunk);
        if (next_record(&reader).operation != kChunk) return false;
      }
    } catch (const CutShort&) {
      return false;
    }
    for (const std::uint64_t chunk : chunks) {
      ByteReader reader(bytes_);
      reader.go_to(chunk);
      read_record(next_record(&reader));
    }
    return true;
  }

  // Reads records in sequence until the data end.
  void read_on(std::size_t first) {
    sink_->remarks.push_back(
        "the bag has no sound index, as after a crash: it is read up to its last whole message.");
    ByteReader reader(bytes_);
    reader.go_to(first);
    try {
      while (reader.left() > 0) {
        const Record record = next_record(&reader);
        // A chunk that was never closed has a size of 0; if it is compressed, its stream is the rest of the
        // file.
        const bool open = record.operation == kChunk && record.data.empty();
        const std::string compression = text_in(record.fields, "compression");
        if (open && compression != "none") {
          read_chunk(compression, reader.read_bytes(reader.left()), true);
          return;
        }
        read_record(record);
      }
    } catch (const CutShort&) {
      // The last record is incomplete.
    }
  }

  void read_record(const Record& record) {
    if (record.operation == kChunk) {
      read_chunk(text_in(record.fields, "compression"), record.data, false);
    } else if (record.operation == kConnection) {
      read_connection(record);
    } else if (record.operation == kMessage) {
      read_message(record);
    }
  }

  void read_chunk(const std::string& compression, std::string_view packed, bool open) {
    std::string_view content = packed;
    Inflated inflated;
    if (compression != "none") {
      try {
        inflated = inflate(compression, packed, kInflateLimit);
      } catch (const InvalidInput& error) {
        throw InvalidInput(path_ + ": " + error.what());
      }
      content = inflated.bytes;
      if (!inflated.whole && !open) {
        sink_->remarks.push_back(
            text("a chunk (", compression, ") is damaged: its sound beginning is kept."));
      }
    }
    ByteReader reader(content);
    try {
      while (reader.left() > 0) {
        const Record record = next_record(&reader);
        if (record.operation == kConnection) read_connection(record);
        if (record.operation == kMessage) read_message(record);
      }
    } catch (const CutShort&) {
      if (!open && (compression == "none" || inflated.whole))
        sink_->remarks.emplace_back("a chunk ends within a record: its whole ones are kept.");
    }
  }

  void read_connection(const Record& record) {
    const auto id = number_in<std::uint32_t>(record.fields, "conn");
    if (channels_.count(id) > 0) return;
    const Fields inner = fields_of(record.data);
    Channel channel;
    channel.topic = text_in(record.fields, "topic");  // the inner header may omit it
    if (channel.topic.empty()) channel.topic = text_in(inner, "topic");
    channel.type = text_in(inner, "type");
    channel.encoding = "ros1";
    channel.definition = text_in(inner, "message_definition");
    channel.publisher = text_in(inner, "callerid");
    channels_[id] = sink_->open(channel);
  }

  void read_message(const Record& record) {
    const auto found = channels_.find(number_in<std::uint32_t>(record.fields, "conn"));
    if (found != channels_.end()) sink_->message(found->second, time_in(record.fields), record.data);
  }

  std::string_view bytes_;
  const std::string& path_;
  BagSink* sink_;
  std::map<std::uint32_t, int> channels_;
};

}  // namespace

void read_ros1_bag(std::string_view bytes, const std::string& path, BagSink* sink) {
  require(bytes.substr(0, kMagic.size()) == kMagic, path, ": found '",
          std::string(bytes.substr(0, std::min(bytes.find('\n'), std::size_t{24}))),
          "', expected a ROS 1 bag of format 2.0 (rosbag fix or rosbag migrate turn older ones into "
          "it).");
  Bag(bytes, path, sink).read();
}

}  // namespace veridyn::bags
