# Turns files into one C++ source that holds their bytes.
#
#   cmake -DOUT=page_files.cpp "-DFILES=name|path;name|path|path" -P embed_files.cmake
#
# Files under one name are joined in their order. -DFUNCTION=name: the function that returns them [page_file].
# Comments that point a browser to a source map are left out: a page that holds the file has none beside it.
if(NOT FUNCTION)
  set(FUNCTION page_file)
endif()
set(arrays "")
set(cases "")
set(number 0)
foreach(file IN LISTS FILES)
  string(REPLACE "|" ";" file "${file}")
  list(GET file 0 name)
  list(SUBLIST file 1 -1 paths)
  set(hex "")
  foreach(path IN LISTS paths)
    file(READ "${path}" content HEX)
    string(APPEND hex "${content}")
  endforeach()
  # "//# sourceMappingURL=" and "/*# sourceMappingURL=", which stand in a last line of their own.
  string(REGEX REPLACE "0a2f(2f|2a)2320736f757263654d617070696e6755524c3d[0-9a-f]*$" "0a" hex "${hex}")
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${hex}")
  string(APPEND arrays "const unsigned char kFile${number}[] = {${bytes}0};\n")
  string(APPEND cases "  if (name == \"${name}\") return text_of(kFile${number}, sizeof kFile${number} - 1);\n")
  math(EXPR number "${number} + 1")
endforeach()
file(WRITE "${OUT}" "// Made by cmake/embed_files.cmake.
#include <string_view>

namespace veridyn {

std::string_view ${FUNCTION}(std::string_view name);

namespace {

${arrays}
std::string_view text_of(const unsigned char* bytes, std::size_t size) {
  return {reinterpret_cast<const char*>(bytes), size};
}

}  // namespace

std::string_view ${FUNCTION}(std::string_view name) {
${cases}  return {};
}

}  // namespace veridyn
")
