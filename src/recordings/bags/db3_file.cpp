#include <sqlite3.h>

#include <filesystem>
#include <map>
#include <memory>

#include "model/excerpt.hpp"
#include "recordings/bags/bag_sink.hpp"
#include "recordings/bags/inflate.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::bags {
namespace {

constexpr std::string_view kZstd = "\x28\xB5\x2F\xFD";

struct CloseDatabase {
  void operator()(sqlite3* database) const { sqlite3_close(database); }
};
struct EndStatement {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Database = std::unique_ptr<sqlite3, CloseDatabase>;
using Statement = std::unique_ptr<sqlite3_stmt, EndStatement>;

// Opens the database in memory; it refers to the bytes, which are never modified.
Database open_bytes(std::string_view bytes, const std::string& path) {
  sqlite3* raw = nullptr;
  const int opened = sqlite3_open_v2(":memory:", &raw, SQLITE_OPEN_READWRITE, nullptr);
  Database database(raw);
  require(opened == SQLITE_OK, path, ": sqlite3 cannot open a database in memory.");
  auto* data = reinterpret_cast<unsigned char*>(const_cast<char*>(bytes.data()));
  const auto size = static_cast<sqlite3_int64>(bytes.size());
  require(sqlite3_deserialize(raw, "main", data, size, size, SQLITE_DESERIALIZE_READONLY) ==
              SQLITE_OK,
          path, ": found no database of sqlite3, expected the storage of a ROS 2 bag.");
  return database;
}

// Opens a database that has a write-ahead log next to it (after a crash); sqlite3 merges the log.
Database open_with_log(const std::string& path) {
  sqlite3* raw = nullptr;
  const int opened = sqlite3_open_v2(path.c_str(), &raw, SQLITE_OPEN_READONLY, nullptr);
  Database database(raw);
  if (opened != SQLITE_OK ||
      sqlite3_exec(raw, "SELECT count(*) FROM topics", nullptr, nullptr, nullptr) != SQLITE_OK)
    return nullptr;
  return database;
}

// The last error message of sqlite3, which may quote the schema.
std::string sqlite_error(const Database& database) {
  return excerpt(sqlite3_errmsg(database.get()), 200);
}

Statement prepared(const Database& database, const char* sql) {
  sqlite3_stmt* raw = nullptr;
  sqlite3_prepare_v2(database.get(), sql, -1, &raw, nullptr);
  return Statement(raw);
}

std::string text_at(const Statement& statement, int column) {
  const void* text = sqlite3_column_blob(statement.get(), column);
  const int size = sqlite3_column_bytes(statement.get(), column);
  return text == nullptr ? std::string()
                         : std::string(static_cast<const char*>(text), static_cast<size_t>(size));
}

// Message definitions by type, if the writer stored them (since ROS 2 Iron).
std::map<std::string, std::string> definitions_in(const Database& database) {
  std::map<std::string, std::string> definitions;
  const Statement rows = prepared(database,
                                  "SELECT topic_type, encoded_message_definition FROM "
                                  "message_definitions WHERE encoding = 'ros2msg'");
  while (rows != nullptr && sqlite3_step(rows.get()) == SQLITE_ROW)
    definitions[text_at(rows, 0)] = text_at(rows, 1);
  return definitions;
}

// Opens a channel of the sink for each topic; @returns the channels by the ids of the topics.
std::map<sqlite3_int64, int> open_channels(const Database& database, const std::string& path,
                                         BagSink* sink) {
  const std::map<std::string, std::string> definitions = definitions_in(database);
  std::map<sqlite3_int64, int> channels;
  const Statement rows =
      prepared(database, "SELECT id, name, type, serialization_format FROM topics ORDER BY id");
  require(rows != nullptr, path,
          ": found a database without the tables of a ROS 2 bag (", sqlite_error(database), "), expected topics and messages.");
  while (sqlite3_step(rows.get()) == SQLITE_ROW) {
    Channel channel;
    channel.topic = text_at(rows, 1);
    channel.type = text_at(rows, 2);
    channel.encoding = text_at(rows, 3);
    const auto definition = definitions.find(channel.type);
    if (definition != definitions.end()) channel.definition = definition->second;
    channels[sqlite3_column_int64(rows.get(), 0)] = sink->open(channel);
  }
  return channels;
}

void read_messages(const Database& database, const std::string& path, bool packed, BagSink* sink) {
  const std::map<sqlite3_int64, int> channels = open_channels(database, path, sink);
  const Statement rows = prepared(database, "SELECT topic_id, timestamp, data FROM messages");
  require(rows != nullptr, path,
          ": found a database without the tables of a ROS 2 bag (", sqlite_error(database), "), expected topics and messages.");
  long damaged = 0;
  int state = SQLITE_ROW;
  while ((state = sqlite3_step(rows.get())) == SQLITE_ROW) {
    const auto channel = channels.find(sqlite3_column_int64(rows.get(), 0));
    if (channel == channels.end() || channel->second < 0) continue;
    const std::int64_t recorded = sqlite3_column_int64(rows.get(), 1);
    const void* data = sqlite3_column_blob(rows.get(), 2);
    const auto size = static_cast<std::size_t>(sqlite3_column_bytes(rows.get(), 2));
    const std::string_view bytes(static_cast<const char*>(data), data == nullptr ? 0 : size);
    if (packed && bytes.substr(0, 4) == kZstd) {
      const Inflated message = inflate("zstd", bytes, kInflateLimit);
      if (message.whole) sink->message(channel->second, recorded, message.bytes);
      damaged += message.whole ? 0 : 1;
    } else {
      sink->message(channel->second, recorded, bytes);
    }
  }
  if (state != SQLITE_DONE)
    sink->remarks.push_back(text("the database is damaged or cut (", sqlite_error(database), "): it is read up to there."));
  if (damaged > 0) sink->remarks.push_back(text(damaged, " of its messages cannot be unpacked."));
}

}  // namespace

void read_db3(std::string_view bytes, const std::string& path, bool message_compression,
              BagSink* sink) {
  Inflated whole;
  if (bytes.substr(0, kZstd.size()) == kZstd) {
    whole = inflate("zstd", bytes, kInflateLimit);
    if (!whole.whole)
      sink->remarks.emplace_back("the compressed database is cut: its beginning is read.");
    bytes = whole.bytes;
  }
  std::string plain;
  if (bytes.size() > 20 && bytes[18] == 2) {  // written with a write-ahead log
    if (const Database joined = open_with_log(path)) {
      read_messages(joined, path, message_compression, sink);
      return;
    }
    // A database in memory has no write-ahead log, so its flag is cleared; rows that are only in the log are
    // lost.
    plain.assign(bytes);
    plain[18] = plain[19] = 1;
    bytes = plain;
    std::error_code none;
    if (std::filesystem::file_size(path + "-wal", none) > 0 && !none)
      sink->remarks.emplace_back(
          "the log beside the database (-wal) cannot be opened: what it holds is not read.");
  }
  read_messages(open_bytes(bytes, path), path, message_compression, sink);
}

}  // namespace veridyn::bags
