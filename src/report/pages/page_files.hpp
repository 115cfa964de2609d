#pragma once

#include <string_view>

namespace veridyn {

/// A file that pages contain, embedded at build time: "page.html", "page.css", all scripts together
/// as "script.js", and of Debian's packages "dygraph.js", "dygraph.css" and "three.gz" with their
/// licences "dygraph-licence.txt" and "three-licence.txt". Empty if the package was not installed
/// at build time.
std::string_view page_file(std::string_view name);

}  // namespace veridyn
