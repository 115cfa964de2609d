#include "recordings/bags/message_decoder.hpp"

#include <algorithm>
#include <cstring>
#include <type_traits>

#include "recordings/files/byte_reader.hpp"

namespace veridyn::bags {
namespace {

constexpr std::int64_t kNanoseconds = 1000000000;
constexpr std::size_t kStepsPerByte = 4;

// Reads ROS 1 messages: packed, little-endian, strings without terminator.
class Ros1Source {
 public:
  explicit Ros1Source(std::string_view bytes) : reader_(bytes) {}
  template <typename T>
  T number() {
    return reader_.number<T>();
  }
  std::string_view text() { return reader_.sized_text(); }
  std::size_t left() const { return reader_.left(); }

 private:
  ByteReader reader_;
};

// Reads CDR: every number is aligned to its own size, relative to the end of the header; strings end with a
// zero byte.
class CdrSource {
 public:
  explicit CdrSource(std::string_view bytes) : reader_(open(bytes)) {}

  template <typename T>
  T number() {
    const std::size_t align = std::min(sizeof(T), largest_);
    reader_.skip((align - reader_.position() % align) % align);
    T value = reader_.number<T>();
    if (big_endian_) {
      unsigned char raw[sizeof(T)];
      std::memcpy(raw, &value, sizeof(T));
      std::reverse(raw, raw + sizeof(T));
      std::memcpy(&value, raw, sizeof(T));
    }
    return value;
  }

  std::string_view text() {
    const auto size = number<std::uint32_t>();
    const std::string_view raw = reader_.read_bytes(size);
    return raw.substr(0, size > 0 && raw.back() == '\0' ? size - 1 : size);
  }

  std::size_t left() const { return reader_.left(); }

 private:
  ByteReader open(std::string_view bytes) {
    if (bytes.size() < 4) throw CutShort("a message without the header of CDR");
    const auto form = static_cast<unsigned char>(bytes[1]);
    const bool version2 = form == 0x06 || form == 0x07 || form == 0x10 || form == 0x11;
    if (bytes[0] != 0 || !(form <= 1 || version2)) throw CutShort("an encapsulation other than plain CDR");
    big_endian_ = form % 2 == 0;
    largest_ = version2 ? 4 : 8;
    return ByteReader(bytes.substr(4));
  }

  bool big_endian_ = false;
  std::size_t largest_ = 8;
  ByteReader reader_;
};

template <typename Source>
class Decoder {
 public:
  Decoder(Source* source, ValueSink* sink, bool signed_time)
      : source_(*source),
        sink_(*sink),
        signed_time_(signed_time),
        steps_(kStepsPerByte * (source->left() + 1024)) {}

  void decode(const std::vector<FieldNode>& fields) {
    for (const FieldNode& field : fields) {
      std::uint32_t count = 1;
      if (field.repeat == FieldNode::Repeat::kFixed) count = field.count;
      if (field.repeat == FieldNode::Repeat::kSequence) count = source_.template number<std::uint32_t>();
      // Each element has at least one byte, which bounds the count.
      if (field.repeat != FieldNode::Repeat::kOne && count > source_.left())
        throw CutShort("an array longer than the message");
      for (std::uint32_t k = 0; k < count; ++k) decode_field(field);
    }
  }

 private:
  template <typename T>
  void decode_number(const FieldNode& field) {
    sink_.number(field.leaf, static_cast<double>(source_.template number<T>()));
  }

  void decode_time(const FieldNode& field, bool is_signed) {
    const auto raw = source_.template number<std::uint32_t>();
    const auto fraction = source_.template number<std::uint32_t>();
    const std::int64_t seconds =
        is_signed ? static_cast<std::int32_t>(raw) : static_cast<std::int64_t>(raw);
    sink_.time(field.leaf, seconds * kNanoseconds + fraction);
  }

  void decode_field(const FieldNode& field) {
    if (steps_-- == 0) throw CutShort("more fields than bytes");
    switch (field.kind) {
      case FieldKind::kBool:
      case FieldKind::kUint8: return decode_number<std::uint8_t>(field);
      case FieldKind::kInt8: return decode_number<std::int8_t>(field);
      case FieldKind::kInt16: return decode_number<std::int16_t>(field);
      case FieldKind::kUint16: return decode_number<std::uint16_t>(field);
      case FieldKind::kInt32: return decode_number<std::int32_t>(field);
      case FieldKind::kUint32: return decode_number<std::uint32_t>(field);
      case FieldKind::kInt64: return decode_number<std::int64_t>(field);
      case FieldKind::kUint64: return decode_number<std::uint64_t>(field);
      case FieldKind::kFloat32: return decode_number<float>(field);
      case FieldKind::kFloat64: return decode_number<double>(field);
      case FieldKind::kString: return sink_.text(field.leaf, source_.text());
      case FieldKind::kTime: return decode_time(field, signed_time_);
      case FieldKind::kDuration: return decode_time(field, true);
      case FieldKind::kMessage: return decode(field.children);
    }
  }

  Source& source_;
  ValueSink& sink_;
  bool signed_time_;
  std::size_t steps_;  // remaining steps; their limit ends arrays of empty messages
};

}  // namespace

void decode_ros1(const MessagePlan& plan, std::string_view bytes, ValueSink* sink) {
  Ros1Source source(bytes);
  Decoder<Ros1Source>(&source, sink, false).decode(plan.fields);
}

void decode_cdr(const MessagePlan& plan, std::string_view bytes, ValueSink* sink) {
  CdrSource source(bytes);
  Decoder<CdrSource>(&source, sink, true).decode(plan.fields);
}

}  // namespace veridyn::bags
