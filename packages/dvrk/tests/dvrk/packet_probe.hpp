#pragma once

#include "dvrk/protocol/bytes.hpp"

namespace veridyn::dvrk {

/// Decodes a datagram in every way there is, encodes what was understood and compares. Shared by
/// the fuzzer and by the test that runs everywhere.
/// @returns what contradicts itself; null: nothing.
const char* probe_packet(ByteView datagram);

}  // namespace veridyn::dvrk
