#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "terminal_line.hpp"
#include "veridyn/control/load_cell.hpp"
#include "veridyn/math/require.hpp"
#ifdef VERIDYN_WITH_SERIALPORT
#include <libserialport.h>
#endif

namespace veridyn {
namespace {

constexpr int kMostReads = 64;  // reads of one poll: bounded in time

std::vector<std::string> parts_of(const std::string& name) {
  std::vector<std::string> parts(1);
  for (const char c : name) {
    if (c == ':') {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

[[noreturn]] void refuse(const std::string& name) {
  throw InvalidInput(text("found the force source '", name,
                          "', expected serial:DEVICE[:BAUD][:text|binary] or "
                          "udp:PORT[:text|binary]."));
}

LoadCellFormat format_of(const std::string& word, const std::string& name) {
  if (word == "text") return LoadCellFormat::kText;
  if (word == "binary") return LoadCellFormat::kBinary;
  refuse(name);
}

int whole(const std::string& word, int least, int most, const std::string& name) {
  char* end = nullptr;
  const long value = std::strtol(word.c_str(), &end, 10);
  if (word.empty() || *end != '\0' || value < least || value > most) refuse(name);
  return static_cast<int>(value);
}

class UdpForceSource final : public ForceSource {
 public:
  UdpForceSource(int port, LoadCellFormat format) : decoder_(format), text_(format == LoadCellFormat::kText) {
    socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK, 0);
    require(socket_ >= 0, "force source: found no socket: ", std::strerror(errno), ".");
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_addr.s_addr = htonl(INADDR_ANY);
    at.sin_port = htons(static_cast<std::uint16_t>(port));
    if (::bind(socket_, reinterpret_cast<const sockaddr*>(&at), sizeof(at)) != 0) {
      const std::string why = std::strerror(errno);
      ::close(socket_);
      throw InvalidInput(text("force source: UDP port ", port, ": ", why, "."));
    }
    if (text_) decoder_.take('\n');  // datagrams begin with whole lines
  }
  ~UdpForceSource() override { ::close(socket_); }
  UdpForceSource(const UdpForceSource&) = delete;
  UdpForceSource& operator=(const UdpForceSource&) = delete;

  int poll() noexcept override {
    int readings = 0;
    std::uint8_t bytes[512];
    for (int k = 0; k < kMostReads; ++k) {
      const ssize_t got = ::recv(socket_, bytes, sizeof(bytes), 0);
      if (got <= 0) break;
      for (ssize_t i = 0; i < got; ++i) readings += decoder_.take(bytes[i]) ? 1 : 0;
      if (text_ && decoder_.take('\n')) ++readings;
    }
    return readings;
  }
  double raw() const noexcept override { return decoder_.raw(); }
  long refused() const noexcept override { return decoder_.refused(); }

 private:
  LoadCellDecoder decoder_;
  bool text_;
  int socket_ = -1;
};

#ifdef VERIDYN_WITH_SERIALPORT
bool is_known(const std::string& device) {
  sp_port* port = nullptr;
  if (sp_get_port_by_name(device.c_str(), &port) != SP_OK) return false;
  sp_free_port(port);
  return true;
}

class SerialForceSource final : public ForceSource {
 public:
  SerialForceSource(const std::string& device, int baud, LoadCellFormat format) : decoder_(format) {
    require(sp_get_port_by_name(device.c_str(), &port_) == SP_OK,
            "force source: found no serial port '", device, "'.");
    if (sp_open(port_, SP_MODE_READ) != SP_OK) {
      const std::string why = std::strerror(errno);
      sp_free_port(port_);
      throw InvalidInput(text("force source: serial port '", device, "': ", why, "."));
    }
    sp_set_baudrate(port_, baud);
    sp_set_bits(port_, 8);
    sp_set_parity(port_, SP_PARITY_NONE);
    sp_set_stopbits(port_, 1);
    sp_set_flowcontrol(port_, SP_FLOWCONTROL_NONE);
  }
  ~SerialForceSource() override {
    sp_close(port_);
    sp_free_port(port_);
  }
  SerialForceSource(const SerialForceSource&) = delete;
  SerialForceSource& operator=(const SerialForceSource&) = delete;

  int poll() noexcept override {
    int readings = 0;
    std::uint8_t bytes[256];
    for (int k = 0; k < kMostReads && connected_; ++k) {
      const int got = sp_nonblocking_read(port_, bytes, sizeof(bytes));
      if (got < 0) connected_ = false;  // the plug was pulled
      if (got <= 0) break;
      for (int i = 0; i < got; ++i) readings += decoder_.take(bytes[i]) ? 1 : 0;
    }
    return readings;
  }
  double raw() const noexcept override { return decoder_.raw(); }
  bool connected() const noexcept override { return connected_; }
  long refused() const noexcept override { return decoder_.refused(); }

 private:
  LoadCellDecoder decoder_;
  sp_port* port_ = nullptr;
  bool connected_ = true;
};
#endif

std::unique_ptr<ForceSource> open_serial(const std::string& device, int baud,
                                         LoadCellFormat format) {
#ifdef VERIDYN_WITH_SERIALPORT
  if (is_known(device)) return std::make_unique<SerialForceSource>(device, baud, format);
#endif
  return open_terminal_line(device, baud, format);
}

}  // namespace

std::unique_ptr<ForceSource> open_force_source(const std::string& name) {
  const std::vector<std::string> parts = parts_of(name);
  if (parts.size() < 2 || parts[1].empty()) refuse(name);
  LoadCellFormat format = LoadCellFormat::kText;
  if (parts[0] == "udp") {
    if (parts.size() > 3) refuse(name);
    if (parts.size() == 3) format = format_of(parts[2], name);
    return std::make_unique<UdpForceSource>(whole(parts[1], 1, 65535, name), format);
  }
  if (parts[0] != "serial" || parts.size() > 4) refuse(name);
  int baud = 115200;
  for (std::size_t k = 2; k < parts.size(); ++k) {
    const bool digits = !parts[k].empty() && parts[k][0] >= '0' && parts[k][0] <= '9';
    if (digits) {
      baud = whole(parts[k], 300, 4000000, name);
    } else {
      format = format_of(parts[k], name);
    }
  }
  return open_serial(parts[1], baud, format);
}

}  // namespace veridyn
