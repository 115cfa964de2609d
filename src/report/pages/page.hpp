#pragma once

#include <string>

namespace veridyn {

/// What goes into one page.
struct PageContent {
  std::string title;
  std::string body;    ///< name of the body's source in src/report/pages/html/
  std::string result;  ///< JSON: every number that the page's text shows
  std::string series;  ///< JSON of page_series.hpp: what the plots show
  std::string report;  ///< plain text for a reader without scripts
};

/// One HTML file that needs no other: styles, scripts, plot library and data are inside.
std::string html_page(const PageContent& content);

}  // namespace veridyn
