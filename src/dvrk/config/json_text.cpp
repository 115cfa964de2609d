#include "json_text.hpp"

#include <algorithm>
#include <cctype>

#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kShown = 20;  // characters of what was found

// "file:line:column" of a character.
std::string place_of(const std::string& content, std::size_t at, const std::string& file) {
  const auto end = content.begin() + static_cast<std::ptrdiff_t>(std::min(at, content.size()));
  const auto line = std::count(content.begin(), end, '\n');
  const std::size_t start = at > 0 ? content.rfind('\n', at - 1) : std::string::npos;
  return text(file, ":", 1 + line, ":", start == std::string::npos ? at + 1 : at - start);
}

bool in_word(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '+' || c == '-' ||
         c == '_';
}

// Start of the word that contains a character.
std::size_t word_start(const std::string& content, std::size_t at) {
  while (at > 0 && in_word(content[at]) && in_word(content[at - 1])) --at;
  return at;
}

// The text at a position: a whole word, or one character.
std::string word_at(const std::string& content, std::size_t at) {
  std::size_t end = at;
  while (end < content.size() && in_word(content[end]) && end - at < kShown) ++end;
  if (end > at) return "'" + content.substr(at, end - at) + "'";
  const auto c = static_cast<unsigned char>(content[at]);
  if (c == '\n') return "the end of the line";
  if (c < 0x20) return "a control character";
  return c < 0x80 ? text("'", content[at], "'") : "a character that is not UTF-8";
}

// @param read  characters that were read until it was wrong, the wrong one included.
[[noreturn]] void fail_at(const std::string& content, std::size_t read, const std::string& file) {
  if (content.find_first_not_of(" \t\r\n") == std::string::npos)
    throw InvalidInput(text(file, ":1:1: found nothing, expected JSON."));
  if (read > content.size())
    throw InvalidInput(text(place_of(content, content.size(), file),
                            ": found the end of the file, expected the JSON to go on."));
  const std::size_t at = word_start(content, std::max<std::size_t>(read, 1) - 1);
  throw InvalidInput(text(place_of(content, at, file), ": found ", word_at(content, at),
                          ", expected JSON, which has nothing like it there."));
}

}  // namespace

nlohmann::ordered_json parse_json_text(const std::string& content, const std::string& file) {
  try {
    return Json::parse(content, nullptr, true, true);
  } catch (const Json::parse_error& error) {
    fail_at(content, error.byte, file);
  } catch (const Json::exception&) {
    // Well formed, but a number has no place in a double.
    throw InvalidInput(text(file, ": found a number too large to hold, expected finite ones."));
  }
}

}  // namespace veridyn::dvrk
