#include "cli/identification/live_page.hpp"

#include "veridyn/math/require.hpp"

#ifdef VERIDYN_WITH_HTTPLIB

#include <httplib.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace veridyn::cli {
namespace {

constexpr const char* kHere = "127.0.0.1";
constexpr std::chrono::seconds kFarewell{1};        // time for a browser to fetch the last page
constexpr std::chrono::milliseconds kSilence{500};  // time until a closed browser is noticed

}  // namespace

class LivePage::Implementation {
 public:
  explicit Implementation(int wanted) {
    server_.Get("/", [this](const httplib::Request&, httplib::Response& answer) {
      const std::lock_guard<std::mutex> hold(guard_);
      answer.set_header("Cache-Control", "no-store");
      seen_ = true;
      answer.set_content(html_, "text/html; charset=utf-8");
    });
    server_.Get("/events", [this](const httplib::Request&, httplib::Response& answer) {
      answer.set_header("Cache-Control", "no-store");
      answer.set_chunked_content_provider(
          "text/event-stream",
          [this, seen = count()](size_t, httplib::DataSink& sink) mutable { return send_pages(seen, sink); });
    });
    port_ = wanted > 0 ? (server_.bind_to_port(kHere, wanted) ? wanted : -1)
                       : server_.bind_to_any_port(kHere);
    require(port_ > 0, "--serve: port ", wanted, " is taken, expected a free one.");
    thread_ = std::thread([this] { server_.listen_after_bind(); });
  }

  ~Implementation() {
    if (seen()) std::this_thread::sleep_for(kFarewell);
    {
      const std::lock_guard<std::mutex> hold(guard_);
      ended_ = true;
    }
    changed_.notify_all();
    server_.stop();
    thread_.join();
  }

  void show(const std::string& html) {
    {
      const std::lock_guard<std::mutex> hold(guard_);
      html_ = html;
      ++count_;
    }
    changed_.notify_all();
  }

  int port() const { return port_; }

 private:
  bool seen() {
    const std::lock_guard<std::mutex> hold(guard_);
    return seen_;
  }

  long count() {
    const std::lock_guard<std::mutex> hold(guard_);
    return count_;
  }

  // Sends one event for each new page, and comments to keep the connection.
  bool send_pages(long& seen, httplib::DataSink& sink) {
    std::unique_lock<std::mutex> hold(guard_);
    changed_.wait_for(hold, kSilence, [&] { return ended_ || count_ != seen; });
    if (ended_) return false;
    const std::string words = count_ != seen ? "data: new\n\n" : ": here\n\n";
    seen = count_;
    hold.unlock();
    return sink.write(words.data(), words.size());
  }

  httplib::Server server_;
  std::mutex guard_;
  std::condition_variable changed_;
  std::string html_ = "<!DOCTYPE html><title>veridyn</title><p>Waiting for the first rows.";
  long count_ = 0;
  bool ended_ = false, seen_ = false;
  int port_ = 0;
  std::thread thread_;
};

LivePage::LivePage(int port) : own_(std::make_unique<Implementation>(port)) {}
LivePage::~LivePage() = default;
int LivePage::port() const { return own_->port(); }
void LivePage::show(const std::string& html) { own_->show(html); }

}  // namespace veridyn::cli

#else

namespace veridyn::cli {

class LivePage::Implementation {};

LivePage::LivePage(int) {
  require(false, "--serve: this tool was built without cpp-httplib, expected --report and a browser.");
}
LivePage::~LivePage() = default;
int LivePage::port() const { return 0; }
void LivePage::show(const std::string&) {}

}  // namespace veridyn::cli

#endif
