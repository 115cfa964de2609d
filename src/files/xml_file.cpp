#include "files/xml_file.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "model/excerpt.hpp"
#include "files/input_file.hpp"
#include "math/numbers.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr int kDeepestElement = 500;  // bodies are nested once for each joint, and readers recurse once for each

// The position of a character as "line:column".
std::string place_in(const std::string& text, std::ptrdiff_t offset) {
  const auto end = text.begin() + std::clamp<std::ptrdiff_t>(offset, 0, static_cast<std::ptrdiff_t>(text.size()));
  const auto line = 1 + std::count(text.begin(), end, '\n');
  const auto newline = std::find(std::make_reverse_iterator(end), text.rend(), '\n');
  return std::to_string(line) + ":" + std::to_string(std::max<std::ptrdiff_t>(1, end - newline.base()));
}

// True if an element lies deeper than allowed; the walk does not recurse.
struct DepthWalker : pugi::xml_tree_walker {
  bool for_each(pugi::xml_node& node) override {
    if (depth() < kDeepestElement) return true;
    deep = node;
    return false;
  }
  pugi::xml_node deep;
};

// Parses the number at the beginning and moves `at` to its end; NaN if there is none.
double parse_leading_number(const char*& at, const char* end) {
  if (at != end && *at == '+') ++at;
  double value = kNaN;
  const auto [after, error] = std::from_chars(at, end, value);
  const bool ends = after == end || std::isspace(static_cast<unsigned char>(*after));
  if (error != std::errc() || !ends) return kNaN;
  at = after;
  return value;
}

std::string quoted(const std::string& words) { return "'" + excerpt(words) + "'"; }

}  // namespace

XmlFile::XmlFile(std::string path, const char* root, const std::string& expected)
    : path_(std::move(path)), text_(content_of_file(path_, expected)) {
  const pugi::xml_parse_result parsed = document_.load_buffer(text_.data(), text_.size());
  require(bool(parsed), path_, ":", place_in(text_, parsed.offset), ": found text that is not XML (", parsed.description(),
          "), expected ", expected, ".");
  DepthWalker depth;
  document_.traverse(depth);
  if (depth.deep) fail(depth.deep, "elements nested deeper than " + std::to_string(kDeepestElement), expected);
  if (std::string(this->root().name()) != root)
    fail(this->root(), "the root element " + quoted(this->root().name()), expected + ", which begins with <" + root + ">");
}

void XmlFile::fail(pugi::xml_node at, const std::string& found, const std::string& expected) const {
  throw InvalidInput(text(path_, ":", place_in(text_, at.offset_debug()), ": found ", excerpt(found, 400), ", expected ", expected, "."));
}

long XmlFile::line(pugi::xml_node at) const {
  return 1 + std::count(text_.begin(), text_.begin() + std::max<std::ptrdiff_t>(0, at.offset_debug()), '\n');
}

std::vector<double> XmlFile::numbers(pugi::xml_node at, const std::string& name, const std::string& words, int least,
                                     int most) const {
  std::vector<double> out;
  const char* next = words.data();
  const char* const end = next + words.size();
  while (true) {
    while (next != end && std::isspace(static_cast<unsigned char>(*next))) ++next;
    if (next == end) break;
    out.push_back(parse_leading_number(next, end));
    if (!std::isfinite(out.back())) fail(at, name + " " + quoted(words), "finite numbers");
  }
  const int count = static_cast<int>(out.size());
  if (count < least || count > most) {
    fail(at, text(name, " with ", count, count == 1 ? " number" : " numbers"),
         least == most ? std::to_string(least) : text(least, " to ", most));
  }
  return out;
}

double XmlFile::number(pugi::xml_node at, const std::string& name, const std::string& words) const {
  const auto first = words.find_first_not_of(" \t\r\n");
  const auto last = words.find_last_not_of(" \t\r\n");
  const std::string trimmed = first == std::string::npos ? std::string() : words.substr(first, last + 1 - first);
  const char* next = trimmed.data();
  const double value = parse_leading_number(next, trimmed.data() + trimmed.size());
  if (std::isnan(value) || next != trimmed.data() + trimmed.size()) fail(at, name + " " + quoted(words), "a number");
  return value;
}

std::string root_element(const std::string& path) {
  pugi::xml_document document;
  const std::string bytes = content_of_file(path, "a robot file");
  document.load_buffer(bytes.data(), bytes.size());
  return document.document_element().name();
}

}  // namespace veridyn
