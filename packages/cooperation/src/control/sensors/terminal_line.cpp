#include "control/sensors/terminal_line.hpp"

#include <fcntl.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

// Speed of the terminal interface; throws InvalidInput if it has none for this rate [1/s].
speed_t speed_of(int baud, const std::string& device) {
  static constexpr struct {
    int baud;
    speed_t speed;
  } kSpeeds[] = {{1200, B1200},     {2400, B2400},     {4800, B4800},     {9600, B9600},
                 {19200, B19200},   {38400, B38400},   {57600, B57600},   {115200, B115200},
                 {230400, B230400}, {460800, B460800}, {921600, B921600}, {1000000, B1000000}};
  for (const auto& one : kSpeeds) {
    if (one.baud == baud) return one.speed;
  }
  throw InvalidInput(text("force source: serial port '", device, "': found ", baud,
                          " baud, expected a usual speed up to 1000000."));
}

class TerminalLine final : public ForceSource {
 public:
  TerminalLine(const std::string& device, int baud, LoadCellFormat format) : bytes_(format) {
    const speed_t speed = speed_of(baud, device);
    line_ = ::open(device.c_str(), O_RDONLY | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    require(line_ >= 0, "force source: serial port '", device, "': ", std::strerror(errno), ".");
    termios settings{};
    if (::tcgetattr(line_, &settings) != 0) {
      ::close(line_);
      throw InvalidInput(text("force source: serial port '", device,
                              "': found no terminal, expected a serial line."));
    }
    ::cfmakeraw(&settings);
    settings.c_cflag |= CLOCAL | CREAD;
    settings.c_cc[VMIN] = settings.c_cc[VTIME] = 0;
    ::cfsetispeed(&settings, speed);
    ::cfsetospeed(&settings, speed);
    ::tcsetattr(line_, TCSANOW, &settings);
  }
  ~TerminalLine() override { ::close(line_); }
  TerminalLine(const TerminalLine&) = delete;
  TerminalLine& operator=(const TerminalLine&) = delete;

  int poll() noexcept override {
    return bytes_.poll([this]() -> std::size_t {
      const ssize_t got = connected_ ? ::read(line_, bytes_.buffer(), bytes_.size()) : 0;
      if (got <= 0) connected_ = connected_ && !is_unplugged(got);
      return got <= 0 ? 0 : static_cast<std::size_t>(got);
    });
  }
  double raw() const noexcept override { return bytes_.decoder().raw(); }
  bool connected() const noexcept override { return connected_; }
  long rejected_readings() const noexcept override { return bytes_.decoder().rejected_readings(); }

 private:
  // True if the device is gone; false if there are only no data.
  bool is_unplugged(ssize_t got) const noexcept {
    if (got < 0 && errno != EAGAIN && errno != EINTR) return true;
    pollfd state{line_, POLLIN, 0};
    return ::poll(&state, 1, 0) > 0 && (state.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0;
  }

  WaitingBytes bytes_;
  int line_ = -1;
  bool connected_ = true;
};

}  // namespace

std::unique_ptr<ForceSource> open_terminal_line(const std::string& device, int baud,
                                                LoadCellFormat format) {
  return std::make_unique<TerminalLine>(device, baud, format);
}

}  // namespace veridyn
