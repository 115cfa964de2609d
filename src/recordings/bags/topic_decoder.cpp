#include "recordings/bags/topic_decoder.hpp"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "files/words.hpp"
#include "recordings/files/byte_reader.hpp"
#include "recordings/signals/joint_fields.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::bags {
namespace {

using recordings::RawField;
using recordings::RawStream;

constexpr std::size_t kLongestArray = 256;  // largest number of values that are kept of an array
constexpr std::size_t kStreams = 64;        // largest number of different sets of names and sizes on a topic
constexpr int kDeepestJson = 12;

bool ends_with_word(const std::string& path, const std::string& word) {
  return path == word || ends_with(path, "/" + word);
}

bool is_json_time(const nlohmann::json& value) {
  return value.size() == 2 && value.contains("sec") &&
         (value.contains("nsec") || value.contains("nanosec")) &&
         value["sec"].is_number_integer();
}

// Collects the numbers, texts and times of a JSON object by their paths.
template <typename Sink, typename LeafOf>
void flatten(const nlohmann::json& value, const std::string& path, int depth, LeafOf&& leaf_of,
             Sink* sink) {
  if (depth > kDeepestJson) return;
  if (value.is_object() && is_json_time(value)) {
    const nlohmann::json& fraction = value.contains("nsec") ? value["nsec"] : value["nanosec"];
    if (!fraction.is_number_integer()) return;
    const auto seconds = value["sec"].get<std::int64_t>();
    if (seconds < 0 || seconds > 9000000000) return;
    sink->time(leaf_of(path), seconds * 1000000000 + fraction.get<std::int64_t>() % 1000000000);
  } else if (value.is_object()) {
    for (const auto& [key, inner] : value.items())
      flatten(inner, path.empty() ? key : path + "/" + key, depth + 1, leaf_of, sink);
  } else if (value.is_array()) {
    for (const nlohmann::json& inner : value) flatten(inner, path, depth + 1, leaf_of, sink);
  } else if (value.is_number()) {
    sink->number(leaf_of(path), value.get<double>());
  } else if (value.is_null()) {
    sink->number(leaf_of(path), std::numeric_limits<double>::quiet_NaN());
  } else if (value.is_boolean()) {
    sink->number(leaf_of(path), value.get<bool>() ? 1.0 : 0.0);
  } else if (value.is_string()) {
    sink->text(leaf_of(path), value.get_ref<const std::string&>());
  }
}

bool is_plain_number(const std::string& type) {
  const std::string brief = short_type(type);
  return brief == "std_msgs/Float64" || brief == "std_msgs/Float32" ||
         brief == "std_msgs/Float64MultiArray" || brief == "std_msgs/Float32MultiArray";
}

}  // namespace

TopicDecoder::TopicDecoder(const Channel& channel, bool definite) : channel_(channel) {
  ros2_ = channel.encoding == "cdr";
  if (channel.encoding == "json") {
    useful_ = true;
    return;
  }
  if (channel.encoding != "ros1" && channel.encoding != "cdr") {
    problem_ = "its messages are encoded as " +
               (channel.encoding.empty() ? "nothing known" : channel.encoding) +
               ", expected ros1, cdr or json";
    return;
  }
  try {
    plan_ = plan_of(channel.type, channel.definition, ros2_);
  } catch (const InvalidInput& error) {
    problem_ = error.what();
    return;
  }
  bool names = false;
  bool positions = false;
  // leaf_of() numbers the leaves in the order of plan_.paths.
  for (const std::string& path : plan_.paths) {
    names = names || ends_with_word(path, "name");
    positions = positions || ends_with_word(path, "position");
    const bool signal = path.find('/') == std::string::npos &&
                        recordings::field_of(path + "/0").signal >= 0;
    useful_ = useful_ || signal;
    leaf_of(path);
  }
  if (leaves_.size() != plan_.paths.size()) {
    problem_ = "its definition gives two fields one name";
    return;
  }
  useful_ = useful_ || definite || (names && positions) || is_plain_number(channel.type);
}

int TopicDecoder::leaf_of(const std::string& path) {
  const auto [at, fresh] = leaf_by_path_.try_emplace(path, static_cast<int>(leaves_.size()));
  if (!fresh) return at->second;
  Leaf leaf;
  leaf.path = path;
  if (ends_with_word(path, "name") || ends_with_word(path, "joint_names")) leaf.role = Role::kNames;
  if (ends_with_word(path, "position")) leaf.role = Role::kPosition;
  if (ends_with_word(path, "velocity")) leaf.role = Role::kVelocity;
  if (ends_with_word(path, "effort")) leaf.role = Role::kEffort;
  if (ends_with_word(path, "stamp")) leaf.role = Role::kStamp;
  leaves_.push_back(std::move(leaf));
  return at->second;
}

void TopicDecoder::number(int leaf, double value) {
  std::vector<double>& numbers = leaves_[leaf].numbers;
  if (numbers.size() < kLongestArray) numbers.push_back(value);
}

void TopicDecoder::text(int leaf, std::string_view value) {
  if (leaves_[leaf].role == Role::kNames && names_.size() < kLongestArray)
    names_.emplace_back(value.substr(0, 200));
}

void TopicDecoder::time(int leaf, std::int64_t nanoseconds) {
  if (stamp_ == 0 && leaves_[leaf].role == Role::kStamp)
    stamp_ = nanoseconds > recordings::kLargestTime ? 0 : nanoseconds;
}

void TopicDecoder::decode_json(std::string_view bytes) {
  const nlohmann::json message =
      nlohmann::json::parse(bytes.begin(), bytes.end(), nullptr, /*allow_exceptions=*/false);
  if (!message.is_object()) throw CutShort("text that is no JSON object");
  flatten(message, "", 0, [this](const std::string& path) { return leaf_of(path); }, this);
}

void TopicDecoder::add(std::int64_t recorded, std::string_view bytes) {
  for (Leaf& leaf : leaves_) leaf.numbers.clear();
  names_.clear();
  stamp_ = 0;
  try {
    if (channel_.encoding == "json") {
      decode_json(bytes);
    } else if (ros2_) {
      decode_cdr(plan_, bytes, this);
    } else {
      decode_ros1(plan_, bytes, this);
    }
  } catch (const CutShort& error) {
    ++bad_;
    bad_reason_ = error.what();
    return;
  }
  store_row(recorded);
}

// The columns of the current message. Arrays as long as the message's list of names are signals of these
// joints; without such a list, joints are numbered from 0.
std::vector<RawField> TopicDecoder::fields() const {
  std::vector<RawField> out;
  for (const Leaf& leaf : leaves_) {
    const int signal = leaf.role == Role::kPosition   ? 0
                       : leaf.role == Role::kVelocity ? 1
                       : leaf.role == Role::kEffort   ? 3
                                                      : -1;
    const bool of_joints = signal >= 0 && (names_.empty() || leaf.numbers.size() == names_.size());
    for (std::size_t k = 0; k < leaf.numbers.size(); ++k) {
      if (of_joints) {
        const std::string joint = names_.empty() ? std::to_string(k) : names_[k];
        const char* word = signal == 0 ? "/position" : signal == 1 ? "/velocity" : "/effort";
        out.push_back({joint + word, joint, signal});
      } else if (leaf.numbers.size() == 1) {
        out.push_back({leaf.path, "", -1});
      } else {
        out.push_back(recordings::field_of(leaf.path + "/" + std::to_string(k)));
      }
    }
  }
  return out;
}

RawStream& TopicDecoder::stream_of_message() {
  std::vector<std::string> key = names_;
  for (const Leaf& leaf : leaves_) key.push_back(std::to_string(leaf.numbers.size()));
  if (!streams_.empty() && key == key_) return streams_[current_];
  key_ = std::move(key);
  const auto known = stream_by_key_.find(key_);
  if (known != stream_by_key_.end()) {
    current_ = known->second;
  } else if (streams_.size() < kStreams) {
    current_ = stream_by_key_[key_] = streams_.size();
    streams_.push_back({channel_.topic, channel_.publisher, fields(), {}, {}, {}});
  } else {
    throw CutShort("too many kinds of messages on one topic");
  }
  return streams_[current_];
}

void TopicDecoder::store_row(std::int64_t recorded) {
  try {
    RawStream& out = stream_of_message();
    out.recorded.push_back(
        std::clamp(recorded, std::int64_t{0}, recordings::kLargestTime));
    out.stamped.push_back(stamp_);
    for (const Leaf& leaf : leaves_)
      out.values.insert(out.values.end(), leaf.numbers.begin(), leaf.numbers.end());
  } catch (const CutShort& error) {
    key_.clear();
    ++bad_;
    bad_reason_ = error.what();
  }
}

std::vector<RawStream> TopicDecoder::extract_streams() {
  return std::move(streams_);
}

}  // namespace veridyn::bags
