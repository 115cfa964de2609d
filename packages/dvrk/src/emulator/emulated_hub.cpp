#include <algorithm>

#include "emulator/board_emulator.hpp"
#include "dvrk/protocol/hub_block.hpp"

// The hub of emulated boards: broadcast query and read.

namespace veridyn::dvrk {
namespace {

constexpr Ticks kFirstUpdate = 400;  // ticks from the query to the first block in the hub
constexpr Ticks kNextUpdate = 300;   // ticks from one block to the next
constexpr Ticks kHubReadTicks = 200;

}  // namespace

// Every selected board latches now, and its block reaches the hub a little later: specification 8.3.
void BoardEmulator::start_query(std::uint32_t word) noexcept {
  update_hub();
  query_ = word;
  query_at_ = now_;
  const auto sequence = static_cast<std::uint16_t>(word >> 16);
  Ticks at = now_ + kFirstUpdate;
  for (const int place : by_id_) {
    EmulatedBoard& b = board(place);
    HubSlot& slot = slots_[place];
    if (((word >> b.setup().id) & 1U) == 0) continue;
    const int firmware = b.setup().firmware;
    const BoardFeedback feedback = b.latch();
    if (b.faults.skips_query) {
      slot.now.fill(0);
      slot.pending = false;
      slot.sequence = 0;
      continue;
    }
    HubHeader header;
    header.quadlets = static_cast<std::uint8_t>(static_cast<int>(hub_quadlets(firmware)) +
                                                b.faults.wrong_block_size);
    header.sequence = static_cast<std::uint16_t>(sequence + b.faults.wrong_sequence);
    header.mismatch = b.faults.wrong_sequence != 0;
    header.update_ticks = static_cast<std::uint16_t>(at - now_);
    const QuadletSpan next({slot.next.data(), slot.next.size()});
    next.set(0, encode_hub_header(header, firmware));
    encode_feedback(feedback, firmware, next.part(1, read_quadlets(firmware)));
    slot.at = at;
    slot.pending = true;
    slot.sequence = sequence;
    at += kNextUpdate;
  }
}

void BoardEmulator::update_hub() noexcept {
  for (HubSlot& slot : slots_) {
    if (!slot.pending || now_ < slot.at) continue;
    slot.now = slot.next;
    slot.pending = false;
  }
}

void BoardEmulator::read_hub(QuadletSpan out) noexcept {
  update_hub();
  for (std::size_t k = 0; k < out.size(); ++k) out.set(k, 0);
  const int hub_firmware = board(hub()).setup().firmware;
  std::size_t at = 0;
  bool all = true;
  for (const int place : by_id_) {
    const BoardSetup& setup = board(place).setup();
    if (((query_ >> setup.id) & 1U) == 0) continue;
    const HubSlot& slot = slots_[place];
    const QuadletView block(ByteView{slot.now.data(), slot.now.size()});
    for (std::size_t k = 0; k < hub_quadlets(setup.firmware); ++k) out.set(at++, block[k]);
    all = all && !slot.pending && slot.sequence == static_cast<std::uint16_t>(query_ >> 16);
  }
  if (hub_firmware >= 8 && !all) return;
  const Ticks start = std::min<Ticks>(now_ - query_at_, hub_firmware >= 9 ? 0xFFFF : 0x3FFF);
  out.set(at, encode_hub_timing({static_cast<std::uint16_t>(start),
                                 static_cast<std::uint16_t>(start + kHubReadTicks)},
                                hub_firmware));
}

}  // namespace veridyn::dvrk
