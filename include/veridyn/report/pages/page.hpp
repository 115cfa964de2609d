#pragma once

#include <string>
#include <string_view>

#include "veridyn/report/json/json_value.hpp"

namespace veridyn {

/// Builds one HTML file that needs no other: it contains styles, scripts, plot library and data.
/// Its sections are listed for each command in src/report/pages/scripts.
///
/// @param result  JSON: every number that the page's text shows.
/// @param series  data of the figures, see page_series.hpp; a page with arms includes three.js.
/// @param report  plain text for a reader without scripts.
/// @param script  adds the sections of a command that is not the library's.
std::string html_page(const std::string& title, const std::string& result, const Json& series,
                      const std::string& report, std::string_view script = {});

}  // namespace veridyn
