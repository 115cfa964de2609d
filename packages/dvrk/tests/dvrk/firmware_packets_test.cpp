#include <gtest/gtest.h>

#include <map>

#include "dvrk/bad_link.hpp"
#include "dvrk/rig.hpp"
#include "dvrk/vectors.hpp"

// What a session sends to firmware 7, 8 and 9 from discovery to power-off, packet by packet,
// against the facts of the specification. The packets are taken apart here by byte offsets, not by
// the library's own decoder.

namespace veridyn::dvrk {
namespace {

struct Packet {
  int flags, generation, node, label, tcode;
  std::uint32_t source, address, data, bytes;
  std::vector<std::uint32_t> block;
  Destination to;
  bool crc;
};

std::uint32_t word(const std::vector<std::uint8_t>& b, std::size_t at) {
  return (std::uint32_t{b[at]} << 24) | (std::uint32_t{b[at + 1]} << 16) |
         (std::uint32_t{b[at + 2]} << 8) | b[at + 3];
}

// Section 3.3, bit by bit.
std::uint32_t crc_of(const std::vector<std::uint8_t>& b, std::size_t first, std::size_t last) {
  std::uint32_t crc = 0xFFFFFFFF;
  for (std::size_t k = first; k < last; ++k) {
    for (int bit = 7; bit >= 0; --bit) {
      const bool one = ((b[k] >> bit) & 1U) != ((crc >> 31) & 1U);
      crc = (crc << 1) ^ (one ? 0x04C11DB7U : 0U);
    }
  }
  return ~crc;
}

Packet parsed_packet(const std::vector<std::uint8_t>& b, Destination to) {
  Packet p{};
  p.to = to;
  p.flags = b[0];
  p.generation = b[1];
  const std::uint32_t q0 = word(b, 2);
  EXPECT_EQ(q0 >> 22, 0x3FFU);
  p.node = static_cast<int>((q0 >> 16) & 0x3F);
  p.label = static_cast<int>((q0 >> 10) & 0x3F);
  p.tcode = static_cast<int>((q0 >> 4) & 0xF);
  EXPECT_EQ(q0 & 0x30F, 0U);  // retry, priority
  p.source = word(b, 6) >> 16;
  EXPECT_EQ(word(b, 6) & 0xFFFF, 0U);
  p.address = word(b, 10);
  std::size_t header = 14;
  if (p.tcode == 0) p.data = word(b, 14);
  if (p.tcode == 1 || p.tcode == 5) p.bytes = word(b, 14) >> 16;
  if (p.tcode != 4) header = 18;
  p.crc = word(b, header) == crc_of(b, 2, header);
  std::size_t end = header + 4;
  if (p.tcode == 1) {
    for (std::size_t k = 0; k < p.bytes; k += 4) p.block.push_back(word(b, end + k));
    p.crc = p.crc && word(b, end + p.bytes) == crc_of(b, end, end + p.bytes);
    end += p.bytes + 4;
  }
  EXPECT_EQ(b.size(), end);
  return p;
}

class Recorder final : public DatagramLink {
 public:
  explicit Recorder(DatagramLink& link) : link_(link) {}
  bool send(ByteView datagram, Destination to) noexcept override {
    packets.push_back(parsed_packet({datagram.data, datagram.data + datagram.size}, to));
    return link_.send(datagram, to);
  }
  Arrival receive(ByteSpan buffer, double timeout) noexcept override {
    return link_.receive(buffer, timeout);
  }
  double now() noexcept override { return link_.now(); }
  void wait(double seconds) noexcept override { link_.wait(seconds); }
  std::uint32_t address_word() const noexcept override { return link_.address_word(); }
  std::vector<Packet> packets;

 private:
  DatagramLink& link_;
};

class Firmware : public testing::TestWithParam<std::tuple<int, CycleProtocol>> {
 protected:
  int firmware() const { return std::get<0>(GetParam()); }
  CycleProtocol protocol() const { return std::get<1>(GetParam()); }
  // Section 7.7.
  std::uint32_t write_words() const { return firmware() == 7 ? 5 : 6; }
  std::uint32_t read_words() const { return firmware() == 7 ? 28 : 32; }

  // Content of a block write: amplifier requests, power and relay bits (sections 7.3 and 10).
  struct Meaning {
    bool amps_on = false, amps_off = false, power_on = false, power_off = false, relay = false;
    bool currents = false;
  };
  Meaning meaning(const Packet& p) const {
    Meaning m;
    EXPECT_EQ(p.block.size() % write_words(), 0U);
    for (std::size_t first = 0; first < p.block.size(); first += write_words()) {
      const std::uint32_t board = first == 0 && (p.node == 0 || p.node == 0x3F) ? 6 : 7;
      const std::size_t dac = firmware() == 7 ? first : first + 1;
      if (firmware() >= 8) {
        EXPECT_EQ(p.block[first], (board << 8) | 6);
      }
      for (std::size_t c = 0; c < 4; ++c) {
        const std::uint32_t q = p.block[dac + c];
        if (firmware() == 7) {
          EXPECT_EQ((q >> 24) & 0xF, board);
        } else {
          EXPECT_EQ((q >> 24) & 0xF, 0U);  // current control
          m.amps_on = m.amps_on || (q & 0x30000000) == 0x30000000;
          m.amps_off = m.amps_off || (q & 0x30000000) == 0x20000000;
        }
        m.currents = m.currents || ((q >> 31) != 0 && (q & 0xFFFF) != 0x8000);
      }
      const std::uint32_t control = p.block[dac + 4];
      m.amps_on = m.amps_on || ((control >> 8) & control & 0xF) != 0;
      m.amps_off = m.amps_off || ((control >> 8) & ~control & 0xF) != 0;
      m.power_on = m.power_on || (control & 0xC0000) == 0xC0000;
      m.power_off = m.power_off || (control & 0xC0000) == 0x80000;
      m.relay = m.relay || (control & 0x30000) == 0x30000;
    }
    return m;
  }
};
INSTANTIATE_TEST_SUITE_P(All, Firmware,
                         testing::Combine(testing::Values(7, 8, 9),
                                          testing::Values(CycleProtocol::kSequential,
                                                          CycleProtocol::kBroadcastWrite,
                                                          CycleProtocol::kBroadcast)),
                         [](const auto& of) {
                           return "Rev" + std::to_string(std::get<0>(of.param)) + "Protocol" +
                                  std::to_string(static_cast<int>(std::get<1>(of.param)));
                         });

TEST_P(Firmware, EveryPacketOfASessionMatchesTheSpecification) {
  BoardEmulator emulator({Rig::setup(6, firmware()), Rig::setup(7, firmware())}, 3);
  EmulatedLink link(emulator);
  Recorder recorder(link);
  const std::vector<Packet>& sent = recorder.packets;
  {
    SessionOptions how = Rig::options(protocol());
    how.bus.repeat_after = 0.0;  // no request is repeated
    BoardSession session(recorder, how);
    session.start();
    // Section 5, #1 to #6: to everyone, for the hub alone.
    struct {
      int tcode;
      std::uint32_t address, data;
    } const start[] = {{0, 11, 0x0100007F}, {4, 4, 0}, {0, 1, 0}, {4, 0, 0}, {4, 7, 0}, {4, 12, 0}};
    for (std::size_t k = 0; k < 6; ++k) {
      EXPECT_EQ(sent[k].flags, 1) << k;
      EXPECT_EQ(sent[k].node, 0x3F) << k;
      EXPECT_EQ(sent[k].tcode, start[k].tcode) << k;
      EXPECT_EQ(sent[k].address, start[k].address) << k;
      if (sent[k].tcode == 0) {
        EXPECT_EQ(sent[k].data, start[k].data) << k;
      }
      EXPECT_EQ(sent[k].generation, k < 2 ? 0 : 3) << k;
      const bool multicast = firmware() >= 9 && k == 5;  // section 2.3
      EXPECT_EQ(sent[k].to, multicast ? Destination::kMulticast : Destination::kEveryone) << k;
    }
    // #7: two nodes answer five reads each, the other fourteen are silent.
    std::size_t k = 6;
    for (int node = 0; node < 16; ++node) {
      const std::vector<std::uint32_t> asked =
          node < 2 ? std::vector<std::uint32_t>{4, 7, 12, 0, 15} : std::vector<std::uint32_t>{4};
      for (const std::uint32_t address : asked) {
        EXPECT_EQ(sent[k].node, node);
        EXPECT_EQ(sent[k].tcode, 4);
        EXPECT_EQ(sent[k].address, address);
        EXPECT_EQ(sent[k].flags, 0);
        EXPECT_EQ(sent[k].to, Destination::kBoard);
        ++k;
      }
    }
    // #8: the gap count of power-up, 63, is replaced by that for two nodes, as the
    // library writes it.
    EXPECT_EQ(sent[k].address, 1U);
    EXPECT_EQ(sent[k].data, 1U);
    EXPECT_EQ(sent[k].node, 0x3F);
    EXPECT_EQ(sent[k + 1].address, 2U);
    EXPECT_EQ(sent[k + 2].address, 2U);
    EXPECT_EQ(sent[k + 3].address, 1U);
    EXPECT_EQ(sent[k + 3].data, 0x1100U + 7U);
    const std::size_t started = sent.size();

    const auto cycles = [&](int count, double bits) {
      for (int n = 0; n < count; ++n) {
        session.update();
        for (int b = 0; b < 2; ++b) {
          for (int c = 0; c < 4; ++c) session.set_command(b, c, 32768.0 + bits);
        }
        session.commit();
        link.wait(Rig::kCycle);
      }
    };
    cycles(3, 0.0);
    for (std::size_t n = started; n < sent.size(); ++n) {
      if (sent[n].tcode == 1) {
        EXPECT_FALSE(meaning(sent[n]).power_on || meaning(sent[n]).amps_on);
      }
    }
    ASSERT_EQ(session.power_on(), nullptr);
    for (int n = 0; n < 900 && session.state() != PowerState::kOn; ++n) cycles(1, 0.0);
    ASSERT_EQ(session.state(), PowerState::kOn) << session.faults().report();
    cycles(5, 1234.0);
    session.power_off();
    cycles(6, 0.0);
    EXPECT_EQ(session.shutdown(), OffState::kConfirmed);
    EXPECT_EQ(session.faults().report(), "");
  }

  // Section 14.5: relay, power, amplifiers, currents, in this order, and never amplifiers together
  // with power. Afterwards amplifiers off, then power.
  std::map<std::string, std::size_t> first;
  std::size_t last_current = 0, off_after = 0;
  for (std::size_t n = 0; n < sent.size(); ++n) {
    const Packet& p = sent[n];
    EXPECT_TRUE(p.crc) << n;
    EXPECT_EQ(p.source, 0xFFD0U) << n;
    EXPECT_EQ(p.label, static_cast<int>((n + 1) % 64)) << n;
    if (p.tcode == 5 && p.address == 0) {
      EXPECT_EQ(p.bytes, 4 * read_words());
    }
    if (p.tcode == 5 && p.address == 0x1000) {
      EXPECT_EQ(p.bytes, 4 * (2 * (read_words() + 1) + 1));
    }
    if (p.tcode == 0 && p.address == 0x1800) {
      EXPECT_EQ(p.data & 0xFFFF, 0xC0U);
    }
    if (p.tcode != 1) continue;
    EXPECT_EQ(p.address, 0U);
    const bool together = protocol() != CycleProtocol::kSequential;
    if (n < sent.size() - 20 && !together) {
      EXPECT_EQ(p.bytes % (4 * write_words()), 0U);
    }
    if (together) {
      EXPECT_EQ(p.bytes, 8 * write_words());
    }
    const Meaning m = meaning(p);
    EXPECT_FALSE(m.power_on && m.amps_on) << n;
    EXPECT_FALSE(m.currents && m.amps_off) << n;
    if (m.relay) first.emplace("relay", n);
    if (m.power_on) first.emplace("power", n);
    if (m.amps_on) first.emplace("amps", n);
    if (m.currents) {
      first.emplace("currents", n);
      last_current = n;
    }
    if (m.power_off && last_current > 0) off_after = n;
  }
  ASSERT_EQ(first.size(), 4U);
  EXPECT_LT(first["relay"], first["power"]);
  EXPECT_LT(first["power"], first["amps"]);
  EXPECT_LT(first["amps"], first["currents"]);
  EXPECT_GT(off_after, last_current);
}

// Section 2.4, 4.2 and 4.3 for firmware 9: what is marked "do not forward" is answered by the board
// with that id under its id, with the mark; what is not, and is for everyone, by nobody.
TEST(Firmware9, UnforwardedReadsAreAnsweredByTheBoardWithThatId) {
  BoardEmulator emulator({Rig::setup(6, 9), Rig::setup(7, 9)}, 3);
  const auto asked = [&](int flags, int node, Ticks at) {
    Request r;
    r.flags = static_cast<std::uint8_t>(flags);
    r.generation = 3;
    r.node = static_cast<std::uint8_t>(node);
    r.label = 9;
    r.tcode = Tcode::kQuadletRead;
    r.address = address::kFirmware;
    std::uint8_t in[64], out[64];
    const std::size_t size = encode(r, {in, sizeof in});
    const Answer answer = emulator.handle({in, size}, at, {out, sizeof out});
    return hex_of({out, answer.size});
  };
  const std::string hub = asked(1, 0x3F, 10);
  ASSERT_EQ(hub.size(), 56U);
  EXPECT_EQ(hub.substr(8, 4), "ffc6");  // board 6, not node 0
  EXPECT_EQ(hub.substr(24, 8), "00000009");
  EXPECT_EQ(hub.substr(40, 2), "10");  // the trailer repeats the mark
  EXPECT_EQ(asked(0, 0x3F, 20), "");
  EXPECT_EQ(asked(1, 6, 30).substr(8, 4), "ffc6");
  EXPECT_EQ(asked(1, 0, 40), "");
  EXPECT_EQ(asked(0, 0, 50).substr(8, 4), "ffc0");
  EXPECT_EQ(asked(0, 1, 60).substr(8, 4), "ffc1");
  EXPECT_EQ(asked(0, 1, 70).substr(40, 2), "00");
}

}  // namespace
}  // namespace veridyn::dvrk
