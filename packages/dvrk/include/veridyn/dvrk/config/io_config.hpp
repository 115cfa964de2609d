#pragma once

#include <optional>
#include <string>
#include <vector>

#include "veridyn/dvrk/protocol/analog.hpp"
#include "veridyn/math/types.hpp"

namespace veridyn::dvrk {

enum class VelocitySource { kFirmware, kSoftware };

/// A brake on an analog channel (ECM): a pulse of current releases it, and a smaller one keeps it open.
struct BrakeConfig {
  int board = 0;
  int axis = 0;
  LinearScale amps_to_bits;
  LinearScale bits_to_amps;
  double max_current = 0.0;       ///< [A]
  double release_current = 0.0;   ///< [A] current that opens it
  double release_time = 0.0;      ///< [s] duration of that current
  double released_current = 0.0;  ///< [A] current that keeps it open
  double engaged_current = 0.0;   ///< [A] current while the brake holds
};

/// One motor with its encoder and pot, converted to SI units.
struct ActuatorConfig {
  int board = 0;  ///< 0 .. 15, the rotary switch
  int axis = 0;   ///< 0 .. 9 (QLA: 0 .. 3)
  bool prismatic = false;
  LinearScale amps_to_bits;
  LinearScale bits_to_amps;
  double effort_to_amps = 0.0;  ///< [A/N m], [A/N] where prismatic
  double max_current = 0.0;     ///< [A]
  VelocitySource velocity_source = VelocitySource::kFirmware;
  double bits_to_position = 0.0;  ///< [rad] or [m] per count; negative where mounted reversed
  double lower = 0.0;             ///< soft limits [rad] or [m]
  double upper = 0.0;
  LinearScale bits_to_volts;
  LinearScale volts_to_position;  ///< [rad] or [m]
  std::optional<BrakeConfig> brake;
};

/// Largest difference of pot and encoder, and its allowed duration.
struct PotTolerance {
  int axis = 0;
  double distance = 0.0;  ///< [rad] or [m] largest difference; 0: not checked
  double latency = 0.0;   ///< [s] time for which it may be exceeded
};

/// Serial number of the QLA board with an id: "1234-56", as in its memory and on its label.
struct BoardSerial {
  int board = 0;
  std::string serial;
};

/// One arm with its boards.
struct RobotConfig {
  std::string name;
  std::string hardware;  ///< "QLA1", "DQLA" or "dRA1"
  std::string serial;
  /// Boards of this robot, since two arms may have the same ids. Empty: unknown.
  std::vector<BoardSerial> board_serials;
  bool io_only = false;  ///< its actuators may have no drive and encoder, which are then zero
  bool has_encoder_preload = true;
  std::vector<ActuatorConfig> actuators;
  std::string pot_lookup_table;  ///< file of digital pots; stored, not read
  MatrixXd pots_to_actuators;    ///< (n x n), where pots sit on joints; empty: on the actuators
  std::vector<PotTolerance> pot_tolerances;

  int size() const { return static_cast<int>(actuators.size()); }  ///< number of actuators
};

struct DigitalInputConfig {
  std::string name;
  int board = 0;
  int bit = 0;                   ///< Bit of the digital word, 0 .. 31
  bool pressed_when_low = true;  ///< "Pressed" = 1: the line is low while pressed
  std::string trigger = "all";   ///< "all", "press", "release" or "none"
  double debounce = 0.0;         ///< [s] time for which an input must keep its level
  double debounce_click = 0.0;   ///< [s]; 20 % of debounce if the file has no value
  bool skip_first_run = false;

  /// value = bit ? not Pressed : Pressed.
  bool value(unsigned digital_word) const {
    return (((digital_word >> bit) & 1U) == 0) == pressed_when_low;
  }
};

struct DigitalOutputConfig {
  std::string name;
  int board = 0;
  int bit = 0;
  double high_duration = 0.0;  ///< [s] duration of the high level of a pulse
  double low_duration = 0.0;   ///< [s] duration of the low level of a pulse
  double frequency = 0.0;      ///< [Hz]; 0: no PWM
};

struct DallasChipConfig {
  std::string name;
  int board = 0;
};

/// Contents of a configuration file of sawRobotIO1394.
struct IoConfig {
  std::vector<RobotConfig> robots;
  std::vector<DigitalInputConfig> digital_inputs;
  std::vector<DigitalOutputConfig> digital_outputs;
  std::vector<DallasChipConfig> dallas_chips;
  std::vector<std::string> remarks;  ///< unknown or unused elements, and implausible values

  /// The robot of that name; the only one if the name is empty. @throws InvalidInput  there is
  /// none, or several.
  const RobotConfig& robot(const std::string& name = "") const;
};

/// Reads XML (Config Version 5) or JSON ("$version" 6), which are distinguished by the first character.
///
/// @throws InvalidInput  "file:line: Robot PSM1/Actuator 3/Drive: found ..., expected ...".
IoConfig read_io_config(const std::string& path);

/// The two formats from memory; `file` is the name in messages.
IoConfig read_io_xml(const std::string& content, const std::string& file);

/// The JSON form is known by its names only (no sample file was available). Assumptions: members as
/// to_io_json() writes them, SI units if no unit is given, "number_of_actuators" may be missing, rows of
/// matrices are lists. Also read: "trigger_when_pressed", "trigger_when_released", "pressed_value",
/// "debounce_threshold", "debounce_threshold_click", "brake". Unknown members are listed in
/// IoConfig::remarks.
IoConfig read_io_json(const std::string& content, const std::string& file);

/// The file's text; reading it gives the same values up to 1e-15 (XML: degrees and millimetres).
std::string to_io_xml(const IoConfig& config);
std::string to_io_json(const IoConfig& config);

/// Rules that concern several elements: no board and axis twice, names unique, tolerances in order, axes that
/// the hardware has. Both readers call it.
/// @throws InvalidInput  "file: ...".
void check_io_config(const IoConfig& config, const std::string& file);

}  // namespace veridyn::dvrk
