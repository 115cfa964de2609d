#include "report/pages/page.hpp"

#include <cctype>
#include <string_view>
#include <utility>
#include <vector>

#include "report/pages/page_files.hpp"

namespace veridyn {
namespace {

using Part = std::pair<std::string_view, std::string>;  // name in the page's source, text for it

std::string replaced(std::string_view text, char from, std::string_view to) {
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
  return replaced(replaced(text, '&', "&amp;"), '<', "&lt;");
}

// JSON between script tags: "</script>" in a file's name must not end it. Only strings can hold
// '<'.
std::string json_in_html(std::string_view json) {
  return replaced(json, '<', "\\u003c");
}

// The source with every {{name}} replaced.
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

// A part of several bodies, for a line that holds its name alone.
std::string shared(std::string_view name) {
  std::string_view text = page_file(name);
  if (!text.empty() && text.back() == '\n') text.remove_suffix(1);
  return std::string(text);
}

// The body, with the parts that pages share. Its file is named for what the page is about.
std::string body_of(const std::string& file) {
  std::string kind = file.substr(0, file.find('.'));
  kind[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(kind[0])));
  return filled(page_file(file), {{"head", filled(shared("head.html"), {{"kind", kind}})},
                                  {"run", shared("run.html")},
                                  {"torques", shared("torques.html")}});
}

}  // namespace

std::string html_page(const PageContent& content) {
  return filled(page_file("page.html"),
                {{"title", html_text(content.title)},
                 {"plot style", part("dygraph.css")},
                 {"style", part("page.css")},
                 {"body", body_of(content.body)},
                 {"report", html_text(content.report)},
                 {"result", json_in_html(content.result)},
                 {"series", json_in_html(content.series)},
                 {"plot licence", html_text(page_file("dygraph-licence.txt"))},
                 {"plots", part("dygraph.js")},
                 {"script", part("script.js")}});
}

}  // namespace veridyn
