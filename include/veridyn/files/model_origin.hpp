#pragma once

#include <optional>
#include <string>
#include <vector>

namespace veridyn {

/// A file from which a model was computed.
struct OriginFile {
  std::string file;  ///< file name without folders, or the name of a recording in memory
  /// SHA-256 of its bytes, as `sha256sum` prints it; empty for a recording in memory
  std::string sha256;
};

/// Provenance of a model file: command, date and inputs. The file keeps it under `made:`
///
///   made:
///     date: 2026-11-22T02:13:00Z
///     veridyn: 1.2.3
///     command: identify
///     inputs:
///       - {file: one.csv, sha256: 5f7c...}
struct ModelOrigin {
  std::string date;     ///< UTC
  std::string version;  ///< version of veridyn
  std::string command;  ///< "identify", "diagnose"
  std::vector<OriginFile> inputs;
};

/// The origin of a model that is computed now. The date is that of $SOURCE_DATE_EPOCH if it is set, so that
/// two runs can give the same file.
/// @param inputs  paths of files, or names of recordings in memory; each counts once.
ModelOrigin origin_now(const std::string& command, const std::vector<std::string>& inputs);

/// Reads the origin from a model file; nullopt if the file has none.
/// @throws InvalidInput  the file cannot be read, or is no YAML.
std::optional<ModelOrigin> read_origin(const std::string& path);

/// The YAML of a robot file with its origin inserted after the header.
std::string with_origin(const std::string& yaml, const ModelOrigin& origin);

}  // namespace veridyn
