#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

std::string content_of(const fs::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// Numbers of equations, sections, tables and figures that stand after the word "thesis": "thesis 7.6 to 7.9",
// "Thesis (5.28)", "thesis Table 4.3", "thesis 7.7.4, figure 7.11".
std::set<std::string> cited(const std::string& text) {
  static const std::regex kCitation(
      R"([Tt]hesis,? ((?:Tables?|Figures?|tables?|figures?|sections?|chapters?|listing|and|to|errata|,| |\(|\)|[0-9]+(?:\.[0-9]+)*)+))");
  static const std::regex kNumber(R"([0-9]+(?:\.[0-9]+)+)");
  std::set<std::string> found;
  for (std::sregex_iterator c(text.begin(), text.end(), kCitation), end; c != end; ++c) {
    if (c->position() > 2 && text.compare(c->position() - 2, 2, "po") == 0) continue;  // hypothesis
    const std::string words = (*c)[1];
    for (std::sregex_iterator n(words.begin(), words.end(), kNumber); n != end; ++n)
      found.insert(n->str());
  }
  return found;
}

// What a page has an entry for. "(4.10) to (4.16)" and "7.6 to 7.9" stand for all between.
std::set<std::string> entries(const std::string& page) {
  static const std::regex kNumber(R"([0-9]+(?:\.[0-9]+)+)");
  static const std::regex kRange(R"(\(?([0-9]+)\.([0-9]+)\)? to \(?([0-9]+)\.([0-9]+)\)?)");
  std::set<std::string> found;
  const std::sregex_iterator end;
  for (std::sregex_iterator n(page.begin(), page.end(), kNumber); n != end; ++n)
    found.insert(n->str());
  for (std::sregex_iterator r(page.begin(), page.end(), kRange); r != end; ++r)
    for (int k = std::stoi((*r)[2]); k <= std::stoi((*r)[4]); ++k)
      found.insert((*r)[1].str() + "." + std::to_string(k));
  return found;
}

// Every citation of the thesis leads to an entry of docs/thesis.md, so that a reader can resolve it.
TEST(References, EveryCitationOfTheThesisHasAnEntryInItsNotes) {
  const fs::path root = VERIDYN_SOURCE_DIR;
  const std::set<std::string> known = entries(content_of(root / "docs/thesis.md"));
  int citations = 0;
  for (const char* top : {"include", "src", "packages", "tests", "data", "examples"}) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / top)) {
      if (!entry.is_regular_file() || entry.path().filename() == "references_test.cpp") continue;
      const std::string extension = entry.path().extension();
      if (extension != ".hpp" && extension != ".cpp" && extension != ".yaml") continue;
      for (const std::string& number : cited(content_of(entry.path()))) {
        EXPECT_EQ(known.count(number), 1U)
            << entry.path() << " cites the thesis's " << number << ", which docs/thesis.md does not explain";
        ++citations;
      }
    }
  }
  EXPECT_GT(citations, 30);
}

// Links between pages lead to files that exist.
TEST(References, LinksOfThePagesResolve) {
  const fs::path root = VERIDYN_SOURCE_DIR;
  static const std::regex kLink(R"(\]\(([^)#:]+)(#[^)]*)?\))");
  std::vector<fs::path> pages = {root / "README.md"};
  for (const char* top : {"docs", "packages"}) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / top))
      if (entry.path().extension() == ".md") pages.push_back(entry.path());
  }
  EXPECT_GT(pages.size(), 5U);
  for (const fs::path& page : pages) {
    const std::string text = content_of(page);
    for (std::sregex_iterator l(text.begin(), text.end(), kLink), end; l != end; ++l)
      EXPECT_TRUE(fs::exists(page.parent_path() / (*l)[1].str())) << page << " links to " << (*l)[1];
  }
}

TEST(References, CitationsAreRecognised) {
  EXPECT_EQ(cited("Source: thesis (4.14) with the errata; hypothesis 9.9; thesis 7.6 to 7.9; 3.3 m"),
            (std::set<std::string>{"4.14", "7.6", "7.9"}));
  EXPECT_EQ(entries("(6.2) to (6.4) and 7.1"), (std::set<std::string>{"6.2", "6.3", "6.4", "7.1"}));
}

}  // namespace
