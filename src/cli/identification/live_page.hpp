#pragma once

#include <functional>
#include <memory>
#include <string>

namespace veridyn::cli {

/// A page in a browser on this machine: http://127.0.0.1:PORT shows what show() gave last, and a
/// browser that has it open is told of every new one (server-sent events). Nothing else on the
/// network sees it.
class LivePage {
 public:
  /// @param port  0: any that is free. @throws InvalidInput  the port is taken, or the tool was built
  /// without cpp-httplib.
  explicit LivePage(int port);
  ~LivePage();
  LivePage(const LivePage&) = delete;
  LivePage& operator=(const LivePage&) = delete;

  int port() const;
  void show(const std::string& html);

 private:
  class Implementation;
  std::unique_ptr<Implementation> own_;
};

}  // namespace veridyn::cli
