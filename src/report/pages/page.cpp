#include "report/pages/page.hpp"

#include <string_view>
#include <utility>
#include <vector>

#include "report/pages/page_files.hpp"
#include "report/pages/page_series.hpp"
#include "veridyn/files/model_origin.hpp"

namespace veridyn {
namespace {

// A placeholder's name in the page's source, and the text that replaces it.
using Part = std::pair<std::string_view, std::string>;

std::string with_replaced(std::string_view text, char from, std::string_view to) {
  std::string out;
  for (const char c : text) {
    if (c == from) {
      out += to;
    } else {
      out += c;
    }
  }
  return out;
}

std::string html_text(std::string_view text) {
  return with_replaced(with_replaced(text, '&', "&amp;"), '<', "&lt;");
}

// Escapes JSON for a script element, which "</script>" in a file name would end. Only strings can contain '<'.
std::string json_in_html(std::string_view json) {
  return with_replaced(json, '<', "\\u003c");
}

// Replaces every {{name}} in the source by its text.
std::string filled(std::string_view source, const std::vector<Part>& parts) {
  std::string out;
  std::size_t at = 0;
  for (std::size_t open = source.find("{{"); open != std::string_view::npos;
       open = source.find("{{", at)) {
    out += source.substr(at, open - at);
    const std::size_t close = source.find("}}", open);
    const std::string_view name = source.substr(open + 2, close - open - 2);
    for (const Part& part : parts) {
      if (part.first == name) out += part.second;
    }
    at = close + 2;
  }
  out += source.substr(at);
  return out;
}

std::string part(std::string_view name) {
  return std::string(page_file(name));
}

// three.js as gzip in base64, preceded by its licence; empty for pages without arms.
std::string packed_three_js(const Json& series) {
  const std::string_view packed = page_file("three.gz");
  const bool has_arms = !packed.empty() && series.contains("arms") && !series["arms"].empty();
  if (!has_arms && !series.contains("space")) return "";
  return "<!-- Arms are drawn by this library:\n" + html_text(page_file("three-licence.txt")) +
         "-->\n<script type=\"text/plain\" id=\"three\">" + base64(packed) + "</script>";
}

}  // namespace

std::string html_page(const std::string& title, const std::string& result, const Json& series,
                      const std::string& report, std::string_view script) {
  Json figures = series;
  figures["made"] = origin_now("", {}).date;
  return filled(page_file("page.html"),
                {{"title", html_text(title)},
                 {"plot style", part("dygraph.css")},
                 {"style", part("page.css")},
                 {"report", html_text(report)},
                 {"result", json_in_html(result)},
                 {"series", json_in_html(figures.dump(-1, ' ', false, Json::error_handler_t::replace))},
                 {"three", packed_three_js(series)},
                 {"plot licence", html_text(page_file("dygraph-licence.txt"))},
                 {"plots", part("dygraph.js")},
                 {"script", part("script.js") + std::string(script) + part("start.js")}});
}

}  // namespace veridyn
