#pragma once

#include <memory>
#include <string>

namespace veridyn::cli {

/// Serves a page on this machine: http://127.0.0.1:PORT shows the last page of show(), and an open browser is
/// notified of every new one (server-sent events). Other machines cannot reach it.
class LivePage {
 public:
  /// @param port  port number; 0: any free one. @throws InvalidInput  the port is in use, or the tool was built
  ///   without cpp-httplib.
  explicit LivePage(int port);
  ~LivePage();
  LivePage(const LivePage&) = delete;
  LivePage& operator=(const LivePage&) = delete;

  int port() const;  ///< 0 without a page
  void show(const std::string& html);  ///< replaces the page that browsers get

 private:
  class Implementation;
  std::unique_ptr<Implementation> own_;
};

}  // namespace veridyn::cli
