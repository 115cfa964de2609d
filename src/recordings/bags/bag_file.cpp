#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "files/words.hpp"
#include "recordings/bags/bag_sink.hpp"
#include "recordings/files/whole_file.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::bags {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kProbe = 16;

enum class Container { kNone, kRos1, kMcap, kDb3 };

Container container_of(std::string_view probe) {
  if (starts_with(probe, "#ROSBAG V") || starts_with(probe, "#ROSRECORD V") ||
      starts_with(probe, "#ROSLOG"))
    return Container::kRos1;
  if (starts_with(probe, "\x89MCAP0\r\n")) return Container::kMcap;
  if (starts_with(probe, std::string_view("SQLite format 3\0", 16)) ||
      starts_with(probe, "\x28\xB5\x2F\xFD"))
    return Container::kDb3;
  return Container::kNone;
}

// Natural order: runs of digits compare by value, so that name_2 precedes name_10.
bool in_natural_order(const std::string& a, const std::string& b) {
  const auto digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() && j < b.size()) {
    if (digit(a[i]) && digit(b[j])) {
      const std::size_t ei = std::find_if_not(a.begin() + static_cast<long>(i), a.end(), digit) - a.begin();
      const std::size_t ej = std::find_if_not(b.begin() + static_cast<long>(j), b.end(), digit) - b.begin();
      if (ei - i != ej - j) return ei - i < ej - j;
      const int order = a.compare(i, ei - i, b, j, ej - j);
      if (order != 0) return order < 0;
      i = ei;
      j = ej;
    } else if (a[i] != b[j]) {
      return a[i] < b[j];
    } else {
      ++i;
      ++j;
    }
  }
  return a.size() - i < b.size() - j;
}

// Lists the containers of one kind in a folder.
std::vector<std::string> pieces_in(const std::string& folder) {
  std::vector<std::string> pieces;
  Container kind = Container::kNone;
  std::error_code ignored;
  std::vector<std::string> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    if (entry.is_regular_file(ignored)) files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end(), in_natural_order);
  for (const std::string& file : files) {
    const Container found = container_of(first_bytes(file, kProbe));
    if (found == Container::kNone || (kind != Container::kNone && found != kind)) continue;
    kind = found;
    pieces.push_back(file);
  }
  return pieces;
}

struct Metadata {
  std::vector<std::string> files;
  bool packed_messages = false;
};

Metadata metadata_of(const std::string& folder, BagSink* sink) {
  const std::string path = folder + "/metadata.yaml";
  Metadata metadata;
  try {
    const YAML::Node root = YAML::LoadFile(path)["rosbag2_bagfile_information"];
    require(root.IsDefined() && root.IsMap(), path,
            ": found no rosbag2_bagfile_information, expected the description of a ROS 2 bag.");
    const std::string mode = to_lower(root["compression_mode"].as<std::string>(""));
    metadata.packed_messages = mode == "message";
    if (mode == "message" || mode == "file") {
      const std::string format = to_lower(root["compression_format"].as<std::string>(""));
      require(format == "zstd", path, ": found compression_format '", format, "', expected zstd.");
    }
    for (const YAML::Node& file : root["relative_file_paths"]) {
      const fs::path listed = file.as<std::string>();
      std::string place = (fs::path(folder) / listed).string();
      // Some versions prepend the bag's own name.
      if (!fs::exists(place)) place = (fs::path(folder) / listed.filename()).string();
      if (fs::exists(place)) {
        metadata.files.push_back(place);
      } else {
        sink->remarks.push_back(
            text("metadata.yaml lists ", listed.string(), ", which is not there."));
      }
    }
  } catch (const YAML::Exception& error) {
    throw InvalidInput(text(path, ":", error.mark.line + 1,
                            ": found ", error.msg, ", expected the description of a ROS 2 bag."));
  }
  return metadata;
}

void read_file(const std::string& path, bool packed_messages, BagSink* sink,
               const ByteStream* opened = nullptr) {
  const WholeFile file(path, opened);
  switch (container_of(file.bytes())) {
    case Container::kRos1:
      return read_ros1_bag(file.bytes(), path, sink);
    case Container::kMcap:
      return read_mcap(file.bytes(), path, sink);
    case Container::kDb3:
      return read_db3(file.bytes(), path, packed_messages, sink);
    case Container::kNone:
      break;
  }
  throw InvalidInput(path + ": found other first bytes, expected a ROS bag or MCAP.");
}

// True if a metadata.yaml next to a single file declares its messages to be compressed.
bool packed_beside(const std::string& path) {
  const std::string folder = fs::path(path).parent_path().string();
  const std::string place = folder.empty() ? "." : folder;
  if (!fs::exists(place + "/metadata.yaml")) return false;
  BagSink ignored;
  try {
    return metadata_of(place, &ignored).packed_messages;
  } catch (const InvalidInput&) {
    return false;
  }
}

}  // namespace

bool is_bag(std::string_view first_bytes) {
  return container_of(first_bytes) != Container::kNone;
}

void read_bag(const std::string& path, BagSink* sink, const ByteStream* opened) {
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) {
    read_file(path, packed_beside(path), sink, opened);
    return;
  }
  Metadata metadata;
  if (fs::exists(path + "/metadata.yaml", ignored)) {
    metadata = metadata_of(path, sink);
  } else {
    metadata.files = pieces_in(path);
    require(!metadata.files.empty(), path,
            ": found a folder without a bag, expected metadata.yaml, *.db3, *.mcap or *.bag in it.");
    if (container_of(first_bytes(metadata.files.front(), kProbe)) == Container::kDb3)
      sink->remarks.emplace_back(
          "the folder has no metadata.yaml, as after a crash: its databases are read as they are.");
  }
  require(!metadata.files.empty(), path, ": found none of the files that metadata.yaml lists.");
  for (const std::string& file : metadata.files) read_file(file, metadata.packed_messages, sink);
}

}  // namespace veridyn::bags
