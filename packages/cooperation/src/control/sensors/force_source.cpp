#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "veridyn/files/words.hpp"
#include "control/sensors/terminal_line.hpp"
#include "veridyn/dvrk/protocol/udp_port.hpp"
#include "veridyn/control/load_cell.hpp"
#include "veridyn/math/require.hpp"
#ifdef VERIDYN_WITH_SERIALPORT
#include <libserialport.h>
#endif

namespace veridyn {
namespace {

constexpr int kMostReads = 64;         // largest number of reads per poll, to bound its time
constexpr double kOwnersSilence = 1.0;  // [s] silence of a sender after which the port accepts another one

[[noreturn]] void throw_unknown_source(const std::string& name) {
  throw InvalidInput(text("found the force source '", name,
                          "', expected serial:DEVICE[:BAUD][:text|binary] or "
                          "udp:[ADDRESS:]PORT[:text|binary]."));
}

LoadCellFormat format_of(const std::string& word, const std::string& name) {
  if (word == "text") return LoadCellFormat::kText;
  if (word == "binary") return LoadCellFormat::kBinary;
  throw_unknown_source(name);
}

// Whole number from `least` to `most`; throws InvalidInput for other words.
int parse_integer(const std::string& word, int least, int most, const std::string& name) {
  char* end = nullptr;
  const long value = std::strtol(word.c_str(), &end, 10);
  if (word.empty() || *end != '\0' || value < least || value > most) throw_unknown_source(name);
  return static_cast<int>(value);
}

class UdpForceSource final : public ForceSource {
 public:
  UdpForceSource(const std::string& place, LoadCellFormat format)
      : port_(place, kOwnersSilence, "force source"), bytes_(format), text_(format == LoadCellFormat::kText) {
    if (text_) bytes_.decoder().add_byte('\n');  // datagrams begin with whole lines
  }

  int poll() noexcept override {
    if (bytes_.decode_reading()) return 1;
    UdpPort::Datagram got;
    for (int k = 0; k < kMostReads && port_.receive(bytes_.buffer(), bytes_.size(), got); ++k) {
      lay_ = got.lay;
      bytes_.set_filled(got.size, text_);
      if (bytes_.decode_reading()) return 1;
    }
    return 0;
  }
  double raw() const noexcept override { return bytes_.decoder().raw(); }
  double queue_delay() const noexcept override { return lay_; }
  long rejected_readings() const noexcept override { return bytes_.decoder().rejected_readings(); }

 private:
  UdpPort port_;
  WaitingBytes bytes_;
  bool text_;
  double lay_ = 0.0;
};

#ifdef VERIDYN_WITH_SERIALPORT
// True if libserialport lists the device.
bool is_listed_port(const std::string& device) {
  sp_port* port = nullptr;
  if (sp_get_port_by_name(device.c_str(), &port) != SP_OK) return false;
  sp_free_port(port);
  return true;
}

class SerialForceSource final : public ForceSource {
 public:
  SerialForceSource(const std::string& device, int baud, LoadCellFormat format) : bytes_(format) {
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
    return bytes_.poll([this]() -> std::size_t {
      const int got = connected_ ? sp_nonblocking_read(port_, bytes_.buffer(), bytes_.size()) : 0;
      if (got < 0) connected_ = false;  // unplugged
      return got <= 0 ? 0 : static_cast<std::size_t>(got);
    });
  }
  double raw() const noexcept override { return bytes_.decoder().raw(); }
  bool connected() const noexcept override { return connected_; }
  long rejected_readings() const noexcept override { return bytes_.decoder().rejected_readings(); }

 private:
  WaitingBytes bytes_;
  sp_port* port_ = nullptr;
  bool connected_ = true;
};
#endif

std::unique_ptr<ForceSource> open_serial(const std::string& device, int baud,
                                         LoadCellFormat format) {
#ifdef VERIDYN_WITH_SERIALPORT
  if (is_listed_port(device)) return std::make_unique<SerialForceSource>(device, baud, format);
#endif
  return open_terminal_line(device, baud, format);
}

}  // namespace

std::unique_ptr<ForceSource> open_force_source(const std::string& name) {
  const std::vector<std::string> parts = split(name, ':');
  if (parts.size() < 2 || parts[1].empty()) throw_unknown_source(name);
  LoadCellFormat format = LoadCellFormat::kText;
  if (parts[0] == "udp") {
    const bool has_address = parts[1].find('.') != std::string::npos;
    const std::size_t port = has_address ? 2 : 1;
    if (parts.size() <= port || parts.size() > port + 2) throw_unknown_source(name);
    if (parts.size() == port + 2) format = format_of(parts[port + 1], name);
    parse_integer(parts[port], 1, 65535, name);
    return std::make_unique<UdpForceSource>((has_address ? parts[1] + ":" : "") + parts[port], format);
  }
  if (parts[0] != "serial" || parts.size() > 4) throw_unknown_source(name);
  int baud = 115200;
  for (std::size_t k = 2; k < parts.size(); ++k) {
    const bool digits = !parts[k].empty() && parts[k][0] >= '0' && parts[k][0] <= '9';
    if (digits) {
      baud = parse_integer(parts[k], 300, 4000000, name);
    } else {
      format = format_of(parts[k], name);
    }
  }
  return open_serial(parts[1], baud, format);
}

}  // namespace veridyn
