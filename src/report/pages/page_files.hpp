#pragma once

#include <string_view>

namespace veridyn {

/// A file that a page is made of, as it was when the library was built: HTML and CSS in
/// src/report/pages/html/ by their file names, all of its scripts as "script.js", "dygraph.js" and
/// "dygraph.css" of Debian's libjs-dygraphs, and that package's "dygraph-licence.txt" (empty where
/// the machine that built had none).
std::string_view page_file(std::string_view name);

}  // namespace veridyn
