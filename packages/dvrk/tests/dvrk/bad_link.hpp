#pragma once

#include <algorithm>
#include <cstring>
#include <vector>

#include "dvrk/mischief.hpp"
#include "emulator/emulated_link.hpp"

namespace veridyn::dvrk {

/// A link to an emulator in the same process over a bad network, with a clock that tests move: the
/// same drill gives the same result on every machine.
class BadLink final : public DatagramLink {
 public:
  explicit BadLink(BoardEmulator& emulator, std::uint64_t seed = 1)
      : link_(emulator), fate_(seed) {}

  bool send(ByteView datagram, Destination to) noexcept override {
    if (is_write(datagram)) ++writes;
    for (Copy& copy : fate_.of(datagram, up)) {
      if (copy.delay <= 0.0) {
        link_.send({copy.bytes.data(), copy.bytes.size()}, to);
      } else {
        going_.push_back({std::move(copy.bytes), link_.now() + copy.delay});
      }
    }
    return true;
  }
  Arrival receive(ByteSpan buffer, double timeout) noexcept override {
    const double until = link_.now() + std::max(0.0, timeout);
    while (true) {
      pass(0.0);
      collect_replies();
      const auto first = std::min_element(coming_.begin(), coming_.end(),
                                          [](const Held& a, const Held& b) { return a.at < b.at; });
      if (first != coming_.end() && first->at <= link_.now()) {
        const Arrival arrival{true, std::min(first->bytes.size(), buffer.size), true, 0.0};
        std::memcpy(buffer.data, first->bytes.data(), arrival.size);
        coming_.erase(first);
        return arrival;
      }
      if (link_.now() >= until) return {};
      pass(std::min(kStep, until - link_.now()));
    }
  }
  double now() noexcept override { return link_.now(); }
  void wait(double seconds) noexcept override {
    const double until = link_.now() + seconds;
    while (link_.now() < until) pass(std::min(kStep, until - link_.now()));
  }
  std::uint32_t address_word() const noexcept override { return link_.address_word(); }

  Mischief up, down;
  long writes = 0;  ///< that the client sent

 private:
  struct Held {
    std::vector<std::uint8_t> bytes;
    double at = 0.0;
  };
  static constexpr double kStep = 20e-6;

  // Advances the time and delivers due datagrams to the boards.
  void pass(double seconds) {
    if (seconds > 0.0) link_.advance(std::max(seconds, 1e-7));
    for (auto one = going_.begin(); one != going_.end();) {
      if (one->at > link_.now()) {
        ++one;
        continue;
      }
      link_.send({one->bytes.data(), one->bytes.size()}, Destination::kBoard);
      one = going_.erase(one);
    }
  }
  void collect_replies() {
    std::uint8_t buffer[kDatagramBuffer];
    for (Arrival a = link_.receive({buffer, sizeof buffer}, 0.0); a.any;
         a = link_.receive({buffer, sizeof buffer}, 0.0)) {
      for (Copy& copy : fate_.of({buffer, a.size}, down))
        coming_.push_back({std::move(copy.bytes), link_.now() + copy.delay});
    }
  }

  EmulatedLink link_;
  Fate fate_;
  std::vector<Held> going_, coming_;
};

}  // namespace veridyn::dvrk
