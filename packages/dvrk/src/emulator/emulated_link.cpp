#include "emulator/emulated_link.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace veridyn::dvrk {

void EmulatedLink::advance(double seconds) noexcept {
  ticks_ += static_cast<Ticks>(seconds * kTicksPerSecond + 0.5);
  emulator_.advance(ticks_);
}

EmulatedLink::Waiting* EmulatedLink::free_slot() noexcept {
  const auto place =
      std::find_if(queue_.begin(), queue_.end(), [](const Waiting& w) { return w.size == 0; });
  return place == queue_.end() ? nullptr : &*place;
}

EmulatedLink::Waiting* EmulatedLink::oldest() noexcept {
  Waiting* first = nullptr;
  for (Waiting& w : queue_) {
    if (w.size > 0 && (first == nullptr || w.at < first->at)) first = &w;
  }
  return first;
}

bool EmulatedLink::send(ByteView datagram, Destination) noexcept {
  if (cut) return false;
  std::array<std::uint8_t, kDatagramBuffer> bytes{};
  const Answer answer = emulator_.handle(datagram, ticks_, {bytes.data(), bytes.size()});
  Waiting* place = free_slot();
  if (answer.size == 0 || place == nullptr) return true;
  std::memcpy(place->bytes.data(), bytes.data(), answer.size);
  place->size = answer.size;
  place->known = !answer.foreign;
  place->at = ticks_ + static_cast<Ticks>((answer.delay + round_trip) * kTicksPerSecond);
  return true;
}

Arrival EmulatedLink::receive(ByteSpan buffer, double timeout) noexcept {
  Waiting* first = oldest();
  const Ticks until =
      ticks_ + static_cast<Ticks>(std::ceil(std::max(0.0, timeout) * kTicksPerSecond));
  const bool comes = first != nullptr && first->at <= until;
  const Ticks then = comes ? std::max(ticks_, first->at) : until;
  if (then > ticks_) {
    ticks_ = then;
    emulator_.advance(ticks_);
  }
  if (!comes) return {};
  const Arrival arrival{true, std::min(first->size, buffer.size), first->known};
  std::memcpy(buffer.data, first->bytes.data(), arrival.size);
  first->size = 0;
  return arrival;
}

void EmulatedLink::push(ByteView datagram, bool known_source) noexcept {
  Waiting* place = free_slot();
  if (place == nullptr) return;
  place->size = std::min(datagram.size, place->bytes.size());
  std::memcpy(place->bytes.data(), datagram.data, place->size);
  place->known = known_source;
  place->at = ticks_;
}

}  // namespace veridyn::dvrk
