#pragma once

#include "dvrk/protocol/bytes.hpp"

namespace veridyn::dvrk {

/// Decodes a datagram by every decoder, encodes the result and compares. Shared by
/// the fuzzer and by the test that runs everywhere.
/// @returns the contradiction; null: none.
const char* probe_packet(ByteView datagram);

}  // namespace veridyn::dvrk
