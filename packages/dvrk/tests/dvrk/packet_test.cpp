#include <gtest/gtest.h>

#include <array>

#include "dvrk/vectors.hpp"
#include "dvrk/protocol/command.hpp"
#include "dvrk/protocol/crc.hpp"
#include "dvrk/protocol/feedback.hpp"
#include "dvrk/protocol/hub_block.hpp"
#include "dvrk/protocol/reply.hpp"
#include "dvrk/protocol/request.hpp"

// Bytes against section 19 of the specification, in both directions.

namespace veridyn::dvrk {
namespace {

using Bytes = std::vector<std::uint8_t>;

ByteView view(const Bytes& bytes) {
  return {bytes.data(), bytes.size()};
}

std::string encoded(const Request& request) {
  std::array<std::uint8_t, kDatagramBuffer> out{};
  return hex_of({out.data(), encode(request, {out.data(), out.size()})});
}

std::string encoded(const Reply& reply) {
  std::array<std::uint8_t, kDatagramBuffer> out{};
  return hex_of({out.data(), encode(reply, Crc::kZero, {out.data(), out.size()})});
}

const std::string& hex(const char* section, const char* name) {
  return vector_named(section, name).hex;
}

TEST(Crc, EqualsKnownCheckValues) {
  const Bytes digits = {'1', '2', '3', '4', '5', '6', '7', '8', '9'};
  EXPECT_EQ(crc32(view(digits)), 0xFC891918U);
  EXPECT_EQ(crc32(view(Bytes(16, 0))), 0xAAD2DD37U);
  EXPECT_EQ(crc32(view(bytes_of("ffc02840ffd0000000000000"))), 0xC0518B0FU);
}

TEST(Vectors, EveryRequestIsReadAndWrittenByteForByte) {
  int requests = 0;
  for (const Vector& v : vectors()) {
    if (v.direction != Direction::kToBoard) continue;
    const Bytes bytes = bytes_of(v.hex);
    Request r;
    ASSERT_EQ(decode(view(bytes), r), Malformed::kNone) << v.section << " " << v.name;
    EXPECT_TRUE(r.crc_right) << v.section << " " << v.name;
    EXPECT_EQ(r.source, kHostId);
    EXPECT_EQ(encoded(r), v.hex) << v.section << " " << v.name;
    EXPECT_EQ(encoded_size(r), bytes.size());
    ++requests;
  }
  EXPECT_EQ(requests, 37);
}

TEST(Vectors, EveryReplyIsReadAndWrittenByteForByte) {
  int replies = 0;
  for (const Vector& v : vectors()) {
    if (v.direction != Direction::kToHost) continue;
    const Bytes bytes = bytes_of(v.hex);
    Reply r;
    ASSERT_EQ(decode(view(bytes), r), Malformed::kNone) << v.section << " " << v.name;
    EXPECT_EQ(encoded(r), v.hex) << v.section << " " << v.name;
    ++replies;
  }
  EXPECT_EQ(replies, 12);
}

// Every real-time block of the vectors, through the structures and back.
TEST(Vectors, BlocksAreReadAndWrittenByteForByte) {
  int commands = 0, feedbacks = 0, hubs = 0;
  for (const Vector& v : vectors()) {
    const Bytes bytes = bytes_of(v.hex);
    std::array<std::uint8_t, kDatagramBuffer> out{};
    QuadletSpan span({out.data(), out.size()});
    if (v.direction == Direction::kToBoard) {
      Request r;
      ASSERT_EQ(decode(view(bytes), r), Malformed::kNone);
      if (r.tcode != Tcode::kBlockWrite) continue;
      const std::size_t each = write_quadlets(v.firmware);
      for (std::size_t first = 0; first < r.block.size(); first += each, ++commands) {
        BoardCommand command;
        ASSERT_TRUE(decode_command(r.block.part(first, each), v.firmware, command)) << v.name;
        encode_command(command, v.firmware, span.part(first, each));
      }
      EXPECT_EQ(hex_of({out.data(), 4 * r.block.size()}), hex_of(r.block.bytes())) << v.name;
      continue;
    }
    Reply r;
    ASSERT_EQ(decode(view(bytes), r), Malformed::kNone);
    const std::size_t size = read_quadlets(v.firmware);
    if (r.block.size() == size) {
      encode_feedback(decode_feedback(r.block, v.firmware), v.firmware, span);
      EXPECT_EQ(hex_of({out.data(), 4 * size}), hex_of(r.block.bytes())) << v.name;
      ++feedbacks;
    } else if (r.block.size() == 2 * (size + 1) + 1) {
      for (std::size_t board = 0; board < 2; ++board) {
        const std::size_t at = board * (size + 1);
        const HubHeader header = decode_hub_header(r.block[at], v.firmware);
        EXPECT_EQ(header.sequence, 3) << v.section;
        EXPECT_TRUE(answers(header, 3, v.firmware));
        EXPECT_FALSE(answers(header, 4, v.firmware));
        EXPECT_EQ(header.update_ticks, board == 0 ? 400 : 700);
        span.set(at, encode_hub_header(header, v.firmware));
        encode_feedback(decode_feedback(r.block.part(at + 1, size), v.firmware), v.firmware,
                        span.part(at + 1, size));
      }
      span.set(2 * (size + 1), encode_hub_timing({2000, 2200}, v.firmware));
      EXPECT_EQ(hex_of({out.data(), 4 * r.block.size()}), hex_of(r.block.bytes())) << v.name;
      ++hubs;
    }
  }
  EXPECT_EQ(commands, 17);
  EXPECT_EQ(feedbacks, 2);
  EXPECT_EQ(hubs, 3);
}

// Built from the text of the specification, not from decoded packets.
TEST(Requests, HostRequestsAreEncodedByteForByte) {
  Request r;
  r.flags = kNoForward;
  r.node = kBroadcastNode;
  r.label = 1;
  r.tcode = Tcode::kQuadletWrite;
  r.address = address::kIpAddress;
  r.data = 0x0100007F;
  EXPECT_EQ(encoded(r), hex("19.1", "PC to all"));

  r = Request();
  r.generation = 3;
  r.node = 1;
  r.label = 15;
  EXPECT_EQ(encoded(r), hex("19.2", "PC to board"));

  r = Request();
  r.generation = 3;
  r.label = 45;
  r.tcode = Tcode::kQuadletWrite;
  r.address = address::of_channel(0, address::kPreload);
  r.data = preload_word(1000);
  EXPECT_EQ(encoded(r), hex("19.3", "encoder 1 preload +1000, board 6"));

  r = Request();
  r.generation = 3;
  r.node = kBroadcastNode;
  r.label = 52;
  r.tcode = Tcode::kQuadletWrite;
  r.address = address::kHubQuery;
  r.data = query_word(3, (1U << 6) | (1U << 7));
  EXPECT_EQ(encoded(r), hex("19.7", "1 query"));

  r.node = 0;
  r.label = 53;
  r.tcode = Tcode::kBlockRead;
  r.address = address::kHub;
  r.bytes = static_cast<std::uint16_t>(4 * (2 * hub_quadlets(8) + 1));
  EXPECT_EQ(encoded(r), hex("19.7", "2 hub read"));
  r.bytes = static_cast<std::uint16_t>(4 * (2 * hub_quadlets(7) + 1));
  EXPECT_EQ(encoded(r), hex("19.8", "hub read"));
}

Request block_write(int node, int label, const BoardCommand* commands, std::size_t count,
                    int firmware, std::array<std::uint8_t, 128>& buffer) {
  const std::size_t each = write_quadlets(firmware);
  for (std::size_t k = 0; k < count; ++k)
    encode_command(commands[k], firmware,
                   QuadletSpan({buffer.data(), buffer.size()}).part(k * each, each));
  Request r;
  r.generation = 3;
  r.node = static_cast<std::uint8_t>(node);
  r.label = static_cast<std::uint8_t>(label);
  r.tcode = Tcode::kBlockWrite;
  r.block = QuadletView({buffer.data(), 4 * each * count});
  return r;
}

TEST(Requests, CommandRequestsAreEncodedByteForByte) {
  std::array<std::uint8_t, 128> buffer{};
  BoardCommand on;
  on.board = 6;
  on.control = control::kPowerOn;
  EXPECT_EQ(encoded(block_write(0, 56, &on, 1, 8, buffer)), hex("19.5", "power on, board 6"));
  EXPECT_EQ(encoded(block_write(0, 48, &on, 1, 7, buffer)), hex("19.8", "power on board 6"));

  BoardCommand amps;
  amps.board = 6;
  for (ChannelCommand& c : amps.channel) c = {true, false, AmpRequest::kOn, 0, kZeroCurrent};
  EXPECT_EQ(encoded(block_write(0, 60, &amps, 1, 8, buffer)),
            hex("19.5", "amps on + zero current, board 6"));
  // The same command in the format of Rev 7: through the control word.
  EXPECT_EQ(encoded(block_write(0, 52, &amps, 1, 7, buffer)), hex("19.8", "amps on, board 6"));

  BoardCommand both[2];
  for (int b = 0; b < 2; ++b) {
    both[b].board = static_cast<std::uint8_t>(6 + b);
    for (int k = 0; k < kChannels; ++k)
      both[b].channel[k] = {true, false, AmpRequest::kKeep, 0,
                                                 static_cast<std::uint16_t>(0x8010 + 0x10 * k)};
  }
  EXPECT_EQ(encoded(block_write(63, 54, both, 2, 8, buffer)), hex("19.7", "3 write all"));
  EXPECT_EQ(encoded(block_write(63, 54, both, 2, 7, buffer)), hex("19.8", "broadcast write"));
}

TEST(Feedback, IsDecodedAsInTheTableOfTheSpecification) {
  const Bytes bytes = bytes_of(hex("19.6", "board to PC"));
  Reply r;
  ASSERT_EQ(decode(view(bytes), r), Malformed::kNone);
  const BoardFeedback f = decode_feedback(r.block, 8);
  EXPECT_NEAR(f.seconds(), 9657 / 49.152e6, 1e-12);
  EXPECT_EQ(f.status.board(), 6);
  EXPECT_EQ(f.status.channels(), 4);
  EXPECT_TRUE(f.status.supply_good() && f.status.power_requested() && f.status.relay_closed());
  EXPECT_FALSE(f.status.watchdog() || f.status.supply_fault());
  EXPECT_EQ(f.temperature.celsius(0), 25.0);
  EXPECT_EQ(f.temperature.celsius(1), 26.0);
  EXPECT_EQ(f.digital.outputs(), 0xFU);
  EXPECT_TRUE(f.digital.home(0));
  EXPECT_FALSE(f.digital.home(1));
  for (int k = 0; k < kChannels; ++k) {
    const ChannelFeedback& c = f.channel[k];
    EXPECT_EQ(encoder_counts(c.encoder.position), 1000 * (k + 1));
    EXPECT_EQ(c.pot, 0x8000 + 0x100 * k);
    EXPECT_EQ(c.current, 0x8010 + 0x10 * k);
    EXPECT_EQ(c.motor.command(), 0x8010 + 0x10 * k);
    EXPECT_TRUE(c.motor.amp_on() && c.motor.amp_requested() && f.status.amp_on(k));
    EXPECT_FALSE(c.motor.amp_fault() || c.motor.current_trip() || f.status.current_trip(k));
    EXPECT_NEAR(encoder_motion(c.encoder).velocity, k == 0 ? 4000.0 : 0.0, 1e-9);
  }
}

TEST(Commands, IterationStopsAtAMalformedBlock) {
  const Bytes bytes = bytes_of(hex("19.7", "3 write all"));
  Request r;
  ASSERT_EQ(decode(view(bytes), r), Malformed::kNone);
  BoardCommand command;
  EXPECT_TRUE(find_command(r.block, 7, 8, command));
  EXPECT_EQ(command.channel[3].value, 0x8040);
  EXPECT_FALSE(find_command(r.block, 5, 8, command));
  for (const std::uint8_t length : {0, 60}) {  // section 10.2
    Bytes broken = bytes;
    broken[2 + 20 + 3] = length;
    ASSERT_EQ(decode(view(broken), r), Malformed::kNone);
    EXPECT_FALSE(r.crc_right);
    EXPECT_FALSE(find_command(r.block, 6, 8, command));
    EXPECT_FALSE(find_command(r.block, 7, 8, command));
  }
}

TEST(Commands, Rev7AppliesTheControlWordOnlyIfAllFourIdsMatch) {
  const Bytes bytes = bytes_of(hex("19.8", "amps on, board 6"));
  Request r;
  ASSERT_EQ(decode(view(bytes), r), Malformed::kNone);
  BoardCommand command;
  ASSERT_TRUE(find_command(r.block, 6, 7, command));
  EXPECT_EQ(command.control, control::kAmpsOn);
  EXPECT_FALSE(find_command(r.block, 7, 7, command));
  Bytes mixed = bytes;
  mixed[2 + 20] = 0x87;  // the first channel speaks to board 7
  ASSERT_EQ(decode(view(mixed), r), Malformed::kNone);
  ASSERT_TRUE(find_command(r.block, 6, 7, command));
  EXPECT_EQ(command.control, 0U);
  EXPECT_FALSE(command.channel[0].valid);
  EXPECT_TRUE(command.channel[1].valid);
}

TEST(Sizes, BroadcastReadsOfUpToTenBoardsFitOneEthernetFrame) {
  const auto bytes = [](int boards, int firmware) {
    return 4 * (static_cast<std::size_t>(boards) * hub_quadlets(firmware) + 1);
  };
  EXPECT_EQ(largest_read(1500), 1440U);
  EXPECT_EQ(largest_read(65536), 2024U);
  EXPECT_LE(bytes(10, 8), largest_read(1500));
  EXPECT_GT(bytes(11, 8), largest_read(1500));
  EXPECT_LE(bytes(12, 7), largest_read(1500));
  EXPECT_GT(bytes(13, 7), largest_read(1500));
}

TEST(Sequence, SkipsZeroWhenItWrapsAround) {
  EXPECT_EQ(next_sequence(1), 2);
  EXPECT_EQ(next_sequence(0xFFFF), 1);
}

// A header is the same after a word, in the bits that its firmware has for each part.
TEST(HubHeaders, SurviveARoundTrip) {
  for (const int firmware : {7, 8, 9}) {
    HubHeader header;
    header.sequence = firmware < 8 ? 0xABCD : 0xCD;
    header.quadlets = firmware < 8 ? 0 : 33;
    header.mismatch = firmware >= 8;
    header.update_ticks = firmware >= 9 ? 0x7FFF : 0x3FFF;
    const HubHeader same = decode_hub_header(encode_hub_header(header, firmware), firmware);
    EXPECT_EQ(same.sequence, header.sequence) << firmware;
    EXPECT_EQ(same.quadlets, header.quadlets) << firmware;
    EXPECT_EQ(same.mismatch, header.mismatch) << firmware;
    EXPECT_EQ(same.update_ticks, header.update_ticks) << firmware;
  }
}

TEST(HubHeaders, AnswerOnlyAQueryOfTheirOwnSequenceNumber) {
  HubHeader header;
  header.sequence = 0x34;
  EXPECT_TRUE(answers(header, 0x1234, 8));
  EXPECT_FALSE(answers(header, 0x1235, 8));
  header.mismatch = true;  // the board saw another query than the hub
  EXPECT_FALSE(answers(header, 0x1234, 8));
  header.sequence = 0x1234;
  EXPECT_TRUE(answers(header, 0x1234, 7));
  EXPECT_FALSE(answers(header, 0x0034, 7));
}

// Words beyond a firmware's block belong to the next block.
TEST(Feedback, OnlyWordsOfItsFirmwareVersionAreDecoded) {
  std::array<std::uint8_t, 4 * 32> bytes{};
  bytes.fill(0xA5);
  const QuadletView block({bytes.data(), bytes.size()});
  EXPECT_EQ(decode_feedback(block, 6).channel[0].encoder.running, ChannelFeedback().encoder.running);
  EXPECT_EQ(decode_feedback(block, 7).channel[0].encoder.running, 0xA5A5A5A5U);
  EXPECT_EQ(decode_feedback(block, 7).channel[0].motor.word, 0U);
  EXPECT_EQ(decode_feedback(block, 8).channel[0].motor.word, 0xA5A5A5A5U);
}

}  // namespace
}  // namespace veridyn::dvrk
