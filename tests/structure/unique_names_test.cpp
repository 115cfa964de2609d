#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

// Two types of one name in two files link without a word, and one of them is then used for both.

namespace {

namespace fs = std::filesystem;

// The text without comments, preprocessor lines, strings and characters.
std::string code_of(const std::string& content) {
  static const std::regex kNoCode(
      "//[^\n]*|/\\*[^*]*\\*+([^/*][^*]*\\*+)*/|R\"\\([^)]*(\\)[^\"][^)]*)*\\)\""
      "|\"(\\\\.|[^\"\\\\\n])*\"|\\b[0-9][0-9a-fA-FxX.]*('[0-9a-fA-F]+)+|'(\\\\.|[^'\\\\\n])+'"
      "|(^|\n)[ \t]*#([^\\\\\n]|\\\\[^]|\\\\\n)*");
  return std::regex_replace(content, kNoCode, " ");
}

// Types that a file defines at namespace scope, as "veridyn::cli::Name"; those of anonymous
// namespaces are the file's own.
std::set<std::string> types_of(const std::string& content) {
  static const std::regex kNamespace("\\bnamespace(\\s+([\\w:]+))?\\s*$");
  static const std::regex kType("\\b(struct|class|union)\\s+(\\w+)\\s*(final\\s*)?(:[^:][^]*)?$");
  struct Scope {
    bool of_names = false;  // a namespace with a name
    std::string name;
  };
  std::set<std::string> types;
  std::vector<Scope> scopes;
  std::string statement;
  for (const char c : code_of(content)) {
    if (c == '{') {
      std::smatch match;
      const bool all_named = std::all_of(scopes.begin(), scopes.end(),
                                         [](const Scope& scope) { return scope.of_names; });
      if (std::regex_search(statement, match, kNamespace)) {
        scopes.push_back({match[2].matched, match[2].str() + "::"});
      } else {
        if (all_named && std::regex_search(statement, match, kType)) {
          std::string name;
          for (const Scope& scope : scopes) name += scope.name;
          types.insert(name + match[2].str());
        }
        scopes.push_back({});
      }
    }
    if (c == '}' && !scopes.empty()) scopes.pop_back();
    if (c == '{' || c == '}' || c == ';')
      statement.clear();
    else
      statement += c;
  }
  return types;
}

TEST(UniqueNames, NoTypeIsDefinedInTwoFiles) {
  const fs::path root = VERIDYN_SOURCE_DIR;
  std::map<std::string, std::vector<std::string>> files;
  for (const fs::path& top : {root / "include/veridyn", root / "src", root / "packages"}) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(top)) {
      const std::string extension = entry.path().extension();
      if (extension != ".hpp" && extension != ".cpp") continue;
      std::ifstream stream(entry.path());
      const std::string content{std::istreambuf_iterator<char>(stream), {}};
      for (const std::string& type : types_of(content))
        files[type].push_back(fs::relative(entry.path(), root).string());
    }
  }
  EXPECT_GT(files.size(), 300U);
  EXPECT_EQ(files.count("veridyn::Model"), 1U);
  for (const auto& [type, where] : files)
    EXPECT_EQ(where.size(), 1U) << type << " in " << testing::PrintToString(where);
}

TEST(UniqueNames, TypesAreSeenWhereTheyStand) {
  const std::string content =
      "#define X {\n"
      "namespace veridyn {\n"
      "namespace { struct Own { int x; }; }\n"
      "struct Forward;  // struct Comment {\n"
      "template <class T> struct Box final : Base<T> { struct Inner {}; };\n"
      "enum class Kind { kOne = 1'000 };\n"
      "void f() { struct Local {}; const char* s = \"struct Text {\"; char c = '{'; }\n"
      "}\n"
      "namespace veridyn::cli {\n"
      "class Command {};\n"
      "}\n";
  EXPECT_EQ(types_of(content),
            (std::set<std::string>{"veridyn::Box", "veridyn::Kind", "veridyn::cli::Command"}));
}

}  // namespace
