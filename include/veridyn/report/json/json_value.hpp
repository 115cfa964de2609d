#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "veridyn/math/types.hpp"

namespace veridyn {

/// A JSON value whose keys keep the order in which they were added.
using Json = nlohmann::ordered_json;

/// The first members of every result: {"veridyn": version, "command": command}.
Json json_head(const std::string& command);

/// A list; entries that are not finite become null when written.
Json json_list(const VectorRef& values);

/// JSON list of act(item) for each item.
template <typename Items, typename Act>
Json json_each(const Items& items, const Act& act) {
  Json list = Json::array();
  for (const auto& item : items) list.push_back(act(item));
  return list;
}

/// The value as text, indented by two, with a line end. Bytes that are not UTF-8 (in file names) are replaced.
std::string json_text(const Json& value);

}  // namespace veridyn
