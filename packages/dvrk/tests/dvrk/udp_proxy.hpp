#pragma once

#include <netinet/in.h>

#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

#include "dvrk/mischief.hpp"

namespace veridyn::dvrk {

/// Stands on a UDP port of its own between clients and a board server on this machine, and does to
/// their datagrams what a bad network does. Counts what goes up.
class UdpProxy {
 public:
  explicit UdpProxy(std::uint16_t server, std::uint64_t seed = 1);
  ~UdpProxy();
  UdpProxy(const UdpProxy&) = delete;
  UdpProxy& operator=(const UdpProxy&) = delete;

  std::uint16_t port() const { return port_; }
  void set(const Mischief& up, const Mischief& down);

  long writes() const { return writes_.load(); }  ///< requests that write, sent by clients
  long reads() const { return reads_.load(); }

 private:
  struct Held {
    std::vector<std::uint8_t> bytes;
    double at = 0.0;
    int from = -1;     ///< socket that sends it
    sockaddr_in to{};  ///< and where to
  };
  void run();
  void pass_up();
  void pass_down(int socket, const sockaddr_in& client);
  void send_due();

  std::uint16_t server_;
  std::uint16_t port_ = 0;
  int socket_ = -1;
  std::map<std::uint64_t, std::pair<int, sockaddr_in>> clients_;  ///< by address and port
  Fate fate_;
  std::mutex mutex_;
  Mischief up_, down_;
  std::vector<Held> held_;
  std::atomic<long> writes_{0}, reads_{0};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace veridyn::dvrk
