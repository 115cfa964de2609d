#include "dvrk/protocol/stamped_datagram.hpp"

#include <sys/socket.h>
#include <sys/uio.h>

#include <cstring>

namespace veridyn::dvrk {

ssize_t receive_stamped(int socket, ByteSpan buffer, sockaddr_in& from, timespec& came) noexcept {
  iovec where{buffer.data, buffer.size};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(timespec))];
  msghdr message{};
  message.msg_name = &from;
  message.msg_namelen = sizeof from;
  message.msg_iov = &where;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  came = {};
  const ssize_t got = ::recvmsg(socket, &message, 0);
  if (got < 0) return got;
  for (cmsghdr* one = CMSG_FIRSTHDR(&message); one != nullptr; one = CMSG_NXTHDR(&message, one)) {
    if (one->cmsg_level == SOL_SOCKET && one->cmsg_type == SCM_TIMESTAMPNS)
      std::memcpy(&came, CMSG_DATA(one), sizeof came);
  }
  return got;
}

}  // namespace veridyn::dvrk
