#pragma once

#include <netinet/in.h>
#include <sys/types.h>

#include <ctime>

#include "dvrk/protocol/bytes.hpp"

namespace veridyn::dvrk {

/// One datagram, and when the system got it; on a busy machine that is well before now. The socket
/// has the option SO_TIMESTAMPNS.
///
/// @param came  CLOCK_REALTIME; zero where the system put no stamp on it.
/// @returns as recvmsg(): bytes, cut at the buffer's end, or -1.
ssize_t receive_stamped(int socket, ByteSpan buffer, sockaddr_in& from, timespec& came) noexcept;

}  // namespace veridyn::dvrk
