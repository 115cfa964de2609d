#include "support/browser.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

namespace veridyn {
namespace {

namespace fs = std::filesystem;

std::string read(const fs::path& path) {
  std::ostringstream content;
  content << std::ifstream(path, std::ios::binary).rdbuf();
  return content.str();
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos;
       at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
  return text;
}

// The pages in frames of the wanted widths, for a window cannot be narrower than 500 pixels; all lie in its
// corner, for what is out of sight is not drawn. When all are, what they hold takes their place as a list of
// texts, and the browser writes it out.
std::string frames_of(const std::vector<PageToOpen>& pages) {
  std::string frames, scripts;
  for (const PageToOpen& page : pages) {
    frames += "<iframe style='border:0;position:absolute;left:0;top:0;height:900px;width:" + std::to_string(page.width) +
              "px' src='file://" + page.path + "'></iframe>";
    scripts += "(page) => {" + page.script + "\n},\n";
  }
  return "<!DOCTYPE html><body style='margin:0'>" + frames + "<script>window.onload = () => {\nconst scripts = [" + scripts +
         R"(];
const texts = [...document.querySelectorAll('iframe')].map((frame, k) => {
  scripts[k](frame.contentWindow);
  return frame.contentDocument.documentElement.outerHTML;
});
document.body.textContent = '';
const list = document.createElement('script');
list.type = 'application/json';
list.id = 'pages';
list.textContent = JSON.stringify(texts).replaceAll('<', '\\u003c');
document.body.append(list);
};</script>)";
}

std::map<std::string, std::string> attributes_of(const std::string& tag) {
  std::map<std::string, std::string> out;
  static const std::regex kAttribute("([a-z-]+)=\"([^\"]*)\"");
  for (std::sregex_iterator at(tag.begin(), tag.end(), kAttribute), end; at != end; ++at) {
    out[(*at)[1]] = replaced(replaced((*at)[2], "&quot;", "\""), "&amp;", "&");
  }
  return out;
}

// What stands between an element's tags; `from` is behind its opening one.
std::string content_at(const std::string& html, const std::string& tag, std::size_t from) {
  int depth = 1;
  for (std::size_t at = html.find('<', from); at != std::string::npos;
       at = html.find('<', at + 1)) {
    const bool closes = html.compare(at, tag.size() + 3, "</" + tag + ">") == 0;
    const bool opens = html.compare(at, tag.size() + 1, "<" + tag) == 0 &&
                       !std::isalnum(static_cast<unsigned char>(html[at + tag.size() + 1]));
    depth += opens ? 1 : closes ? -1 : 0;
    if (depth == 0) return html.substr(from, at - from);
  }
  return "";
}

fs::path new_folder() {
  std::string folder = (fs::temp_directory_path() / "veridyn-browser-XXXXXX").string();
  if (::mkdtemp(folder.data()) == nullptr) throw std::runtime_error("no temporary folder");
  return folder;
}

void run_browser(const fs::path& work, const std::string& words) {
  const std::string folder = work.string();
  const std::string command =
      "timeout 180 " + browser() +
      " --headless=new --no-sandbox --disable-gpu --hide-scrollbars --allow-file-access-from-files --disable-extensions --no-first-run"
      " --disable-background-networking --disable-sync --disable-component-update --disable-default-apps"
      " --enable-logging=stderr --user-data-dir=" +
      folder + "/profile " + words + " >" + folder + "/dom 2>" + folder + "/log </dev/null";
  EXPECT_EQ(std::system(command.c_str()), 0) << read(work / "log");
}

}  // namespace

std::vector<double> column(const nlohmann::json& packed) {
  std::vector<double> out;
  if (packed.is_array()) {
    for (const auto& value : packed) out.push_back(value.is_null() ? NAN : value.get<double>());
    return out;
  }
  static const std::string kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<unsigned> bytes;
  unsigned bits = 0;
  int count = 0;
  for (const char c : packed["int16"].get<std::string>()) {
    if (c == '=') break;
    bits = (bits << 6 | static_cast<unsigned>(kDigits.find(c))) & 0xffffu;
    count += 6;
    if (count >= 8) bytes.push_back(bits >> (count -= 8) & 255u);
  }
  for (std::size_t k = 0; k + 1 < bytes.size(); k += 2) {
    const unsigned step = bytes[k] | bytes[k + 1] << 8;
    out.push_back(step == 65535u ? NAN : packed["from"].get<double>() + step * packed["step"].get<double>());
  }
  return out;
}

std::string without_scripts(const std::string& html) {
  std::string out;
  std::size_t at = 0;
  for (std::size_t open = html.find("<script"); open != std::string::npos;
       open = html.find("<script", at)) {
    out += html.substr(at, open - at);
    at = html.find("</script>", open);
    if (at == std::string::npos) return out;
    at += 9;
  }
  return out + html.substr(at);
}

std::string PageElement::at(const std::string& attribute) const {
  const auto found = attributes.find(attribute);
  return found == attributes.end() ? "" : found->second;
}

std::string PageElement::text() const {
  std::string out = replaced(content, "\u00d7\u202f10<sup>", "e");
  out = std::regex_replace(out, std::regex("<[^>]*>"), "");
  for (const char* space : {"\u202f", "&nbsp;", "\u00a0"}) out = replaced(out, space, "");
  return replaced(out, "\u2212", "-");
}

std::vector<PageElement> OpenedPage::with(const std::string& attribute) const {
  const std::string body = without_scripts(html);
  std::vector<PageElement> out;
  for (std::size_t at = body.find('<'); at != std::string::npos; at = body.find('<', at + 1)) {
    const std::size_t end = body.find('>', at);
    if (end == std::string::npos || !std::isalpha(static_cast<unsigned char>(body[at + 1])))
      continue;
    const std::string tag = body.substr(at + 1, end - at - 1);
    if (tag.find(" " + attribute + "=\"") == std::string::npos) continue;
    PageElement element;
    element.tag = tag.substr(0, tag.find(' '));
    element.attributes = attributes_of(tag);
    element.content = content_at(body, element.tag, end + 1);
    out.push_back(std::move(element));
  }
  return out;
}

PageElement OpenedPage::root() const {
  const std::size_t at = html.find("<html");
  PageElement out;
  out.tag = "html";
  if (at != std::string::npos) {
    out.attributes = attributes_of(html.substr(at, html.find('>', at) - at));
  }
  return out;
}

std::string browser() {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "/usr/bin");
  for (std::string folder; std::getline(folders, folder, ':');) {
    for (const char* name : {"chromium", "chromium-browser", "google-chrome"}) {
      if (fs::exists(fs::path(folder) / name)) return name;
    }
  }
  return "";
}

std::vector<OpenedPage> open_pages(const std::vector<PageToOpen>& pages, Scheme scheme) {
  const fs::path work = new_folder();
  std::ofstream(work / "frames.html") << frames_of(pages);
  const std::string dark = scheme == Scheme::kDark ? "--blink-settings=preferredColorScheme=0 " : "";
  run_browser(work, dark + "--window-size=1400,1000 --dump-dom file://" + (work / "frames.html").string());
  const nlohmann::json texts = embedded(read(work / "dom"), "pages");
  std::vector<OpenedPage> out(pages.size());
  EXPECT_EQ(texts.size(), pages.size());
  for (std::size_t k = 0; k < std::min(texts.size(), pages.size()); ++k) out[k].html = texts[k];
  std::istringstream log(read(work / "log"));
  for (std::string line; std::getline(log, line);) {
    // The browser's own windows write to the console too, as when its fonts load slowly.
    const bool of_browser = line.find("chrome://") != std::string::npos;
    if (line.find("CONSOLE") == std::string::npos || of_browser) continue;
    for (OpenedPage& page : out) page.console += line + "\n";  // a line does not tell in which frame
  }
  std::error_code ignored;
  fs::remove_all(work, ignored);
  return out;
}

OpenedPage open_page(const std::string& path, int width, const std::string& script) {
  return open_pages({{path, width, script}}).front();
}

void expect_faultless(const OpenedPage& page, int width) {
  const PageElement root = page.root();
  EXPECT_EQ(root.at("data-errors"), "0") << page.console;
  EXPECT_EQ(page.console, "");
  EXPECT_EQ(root.at("data-width"), std::to_string(width));
  EXPECT_EQ(root.at("data-overflow"), "0") << root.at("data-overflow-by");
  const std::vector<PageElement> plots = page.with("data-plot");
  EXPECT_EQ(root.at("data-plots"), std::to_string(plots.size()));
  EXPECT_FALSE(plots.empty());
  for (const PageElement& plot : plots) {
    const std::string name = plot.at("data-plot") + " of joint " + plot.at("data-joint");
    const bool over_time = plot.at("data-plot") == "time" || plot.at("data-plot") == "error";
    for (const char* what : {"data-points", "data-pixels"}) {
      const std::map<std::string, long> curves = counts(plot.at(what));
      if (!over_time && std::string(what) == "data-pixels") continue;
      EXPECT_FALSE(curves.empty()) << name << " has no " << what;
      for (const auto& [curve, count] : curves) {
        EXPECT_GT(count, 0) << name << ", " << curve << ", " << what;
      }
    }
  }
}

void expect_number(const PageElement& shown, const nlohmann::json& result) {
  const std::string place = shown.at("data-from");
  const std::string text = shown.text();
  const nlohmann::json::json_pointer pointer(place);
  if (text == "\u2013") {
    EXPECT_TRUE(!result.contains(pointer) || result[pointer].is_null()) << place;
    return;
  }
  ASSERT_TRUE(result.contains(pointer)) << place << " shows " << text;
  ASSERT_TRUE(result[pointer].is_number()) << place << " shows " << text;
  const double value = std::stod(shown.at("data-scale")) * result[pointer].get<double>();
  static const std::regex kShown("(-?\\d+)(?:\\.(\\d+))?(?:e(-?\\d+))?");
  std::smatch parts;
  ASSERT_TRUE(std::regex_match(text, parts, kShown)) << place << " shows '" << text << "'";
  const double exponent = parts[3].matched ? std::stod(parts[3]) : 0.0;
  const double last_digit = std::pow(10.0, exponent - static_cast<double>(parts[2].length()));
  EXPECT_NEAR(std::stod(text), value, 0.5 * last_digit * (1.0 + 1e-9)) << place;
}

nlohmann::json embedded(const std::string& html, const std::string& id) {
  const std::string open = "<script type=\"application/json\" id=\"" + id + "\">";
  const std::size_t at = html.find(open);
  if (at == std::string::npos) return nullptr;
  const std::size_t begin = at + open.size();
  return nlohmann::json::parse(html.substr(begin, html.find("</script>", begin) - begin));
}

std::map<std::string, long> counts(const std::string& words) {
  std::map<std::string, long> out;
  static const std::regex kCount("([^:]+):(\\d+) ?");
  for (std::sregex_iterator at(words.begin(), words.end(), kCount), end; at != end; ++at) {
    out[(*at)[1]] = std::stol((*at)[2]);
  }
  return out;
}

}  // namespace veridyn
