#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace veridyn::dvrk {

/// Parses JSON; comments are let pass, since the laboratories' files begin with one for their
/// editors.
/// @throws InvalidInput  "file:line:column: found ..., expected ...".
nlohmann::ordered_json parse_json_text(const std::string& content, const std::string& file);

}  // namespace veridyn::dvrk
