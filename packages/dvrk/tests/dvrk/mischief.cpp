#include "dvrk/mischief.hpp"

namespace veridyn::dvrk {

double Fate::uniform() {
  state_ ^= state_ << 13;
  state_ ^= state_ >> 7;
  state_ ^= state_ << 17;
  return static_cast<double>(state_ >> 11) * 0x1p-53;
}

std::vector<Copy> Fate::of(ByteView datagram, const Mischief& m) {
  if (uniform() < m.lose || (m.lose_writes && is_write(datagram))) return {};
  Copy copy;
  copy.bytes.assign(datagram.data, datagram.data + datagram.size);
  copy.delay = m.delay + m.jitter * uniform() + (uniform() < m.hold ? m.held_for : 0.0);
  if (uniform() < m.corrupt && !copy.bytes.empty()) {
    const auto bit =
        static_cast<std::size_t>(uniform() * 8.0 * static_cast<double>(copy.bytes.size()));
    copy.bytes[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
  }
  std::vector<Copy> copies{copy};
  if (uniform() < m.repeat) copies.push_back(copy);
  return copies;
}

bool is_write(ByteView datagram) {
  if (datagram.size < 6) return false;
  const int tcode = datagram.data[5] >> 4;
  return tcode == 0 || tcode == 1;
}

}  // namespace veridyn::dvrk
