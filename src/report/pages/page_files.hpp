#pragma once

#include <string_view>

namespace veridyn {

/// A file that a page is made of, as it was when the library was built: "page.html", "page.css", all
/// of its scripts as "script.js", and of Debian's packages "dygraph.js", "dygraph.css" and "three.gz"
/// with their licences "dygraph-licence.txt" and "three-licence.txt". Empty where the machine that
/// built had none.
std::string_view page_file(std::string_view name);

}  // namespace veridyn
