#pragma once

#include <string>

#include "report/json/json_value.hpp"

namespace veridyn {

/// One HTML file that needs no other: styles, scripts, plot library and data are inside. What it
/// shows is a list of sections that its command has in src/report/pages/scripts.
///
/// @param result  JSON: every number that the page's text shows.
/// @param series  what figures show, see page_series.hpp; a page with arms gets three.js, too.
/// @param report  plain text for a reader without scripts.
std::string html_page(const std::string& title, const std::string& result, const Json& series,
                      const std::string& report);

}  // namespace veridyn
