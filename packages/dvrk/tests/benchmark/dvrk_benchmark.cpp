#include <benchmark/benchmark.h>

#include <array>

#include "dvrk/vectors.hpp"
#include "dvrk/protocol/command.hpp"
#include "dvrk/protocol/feedback.hpp"
#include "dvrk/protocol/hub_block.hpp"
#include "dvrk/protocol/reply.hpp"
#include "dvrk/protocol/request.hpp"

// Time of one cycle of two boards in packets alone: query and write encoded, the broadcast read
// decoded. Required: below 5 us.

namespace veridyn::dvrk {
namespace {

struct Cycle {
  std::vector<std::uint8_t> reply = bytes_of(vector_named("19.7", "hub reply").hex);
  std::array<std::uint8_t, kDatagramBuffer> out{};
  std::array<std::uint8_t, 128> block{};
  BoardFeedback feedback[2];
  BoardCommand command[2];

  void query(std::uint16_t sequence) {
    Request r;
    r.node = kBroadcastNode;
    r.tcode = Tcode::kQuadletWrite;
    r.address = address::kHubQuery;
    r.data = query_word(sequence, 0xC0);
    benchmark::DoNotOptimize(encode(r, {out.data(), out.size()}));
    r = Request();
    r.tcode = Tcode::kBlockRead;
    r.address = address::kHub;
    r.bytes = 268;
    benchmark::DoNotOptimize(encode(r, {out.data(), out.size()}));
  }

  void read() {
    Reply r;
    benchmark::DoNotOptimize(decode({reply.data(), reply.size()}, r));
    for (std::size_t b = 0; b < 2; ++b) {
      benchmark::DoNotOptimize(decode_hub_header(r.block[33 * b], 8));
      feedback[b] = decode_feedback(r.block.part(33 * b + 1, 32), 8);
      for (const ChannelFeedback& c : feedback[b].channel)
        benchmark::DoNotOptimize(encoder_motion(c.encoder));
    }
  }

  void write() {
    const QuadletSpan span({block.data(), block.size()});
    for (std::size_t b = 0; b < 2; ++b) encode_command(command[b], 8, span.part(6 * b, 6));
    Request r;
    r.node = kBroadcastNode;
    r.tcode = Tcode::kBlockWrite;
    r.block = QuadletView({block.data(), 48});
    benchmark::DoNotOptimize(encode(r, {out.data(), out.size()}));
  }
};

void packets_of_a_cycle(benchmark::State& state) {
  Cycle cycle;
  std::uint16_t sequence = 0;
  for (auto _ : state) {
    cycle.query(sequence = next_sequence(sequence));
    cycle.read();
    cycle.write();
  }
}
BENCHMARK(packets_of_a_cycle);

}  // namespace
}  // namespace veridyn::dvrk
