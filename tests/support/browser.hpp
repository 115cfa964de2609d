#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace veridyn {

/// An element of a page as a browser made it.
struct PageElement {
  std::string tag;
  std::map<std::string, std::string> attributes;
  std::string content;  ///< what stands between its tags, markup and all

  /// An attribute, or "" where it is not there.
  std::string at(const std::string& attribute) const;
  /// Its text without markup, with plain minus signs and spaces.
  std::string text() const;
};

/// A page after its scripts have run.
struct OpenedPage {
  std::string html;
  std::string console;  ///< what scripts and the browser complained about, one line each

  /// All elements that have the attribute, in the order of the page; scripts are not looked into.
  std::vector<PageElement> with(const std::string& attribute) const;
  /// Attributes of the root element.
  PageElement root() const;
};

/// "chromium" or another browser of its family that is installed; "" if there is none.
std::string browser();

enum class Scheme { kLight, kDark };

/// A file to open in a frame of this width.
struct PageToOpen {
  std::string path;
  int width;
  std::string script = "";  ///< runs when all frames are ready, with `page` as its window
};

/// Opens pages side by side in one browser, without a network: a browser takes longer to start than a page to draw.
std::vector<OpenedPage> open_pages(const std::vector<PageToOpen>& pages, Scheme scheme = Scheme::kLight);

OpenedPage open_page(const std::string& path, int width, const std::string& script = "");

/// What the page says about itself is as it should be: no fault, nothing wider than the page, and
/// every plot has points and pixels of every curve.
void expect_faultless(const OpenedPage& page, int width);

/// A shown number is the number at its place in the result, to half a unit of its last digit.
void expect_number(const PageElement& shown, const nlohmann::json& result);

/// A page without its script elements, which may hold anything.
std::string without_scripts(const std::string& html);

/// The JSON in one of the page's script elements.
nlohmann::json embedded(const std::string& html, const std::string& id);

/// A column of numbers as a page's series has it, packed or as a list; NaN where there is none.
std::vector<double> column(const nlohmann::json& packed);

/// "measured:12 model:30" as a map.
std::map<std::string, long> counts(const std::string& words);

}  // namespace veridyn
