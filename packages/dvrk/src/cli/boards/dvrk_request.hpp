#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/tool/program.hpp"
#include "veridyn/tool/common_options.hpp"
#include "veridyn/tool/stop_signals.hpp"
#include "dvrk/run/arm_run.hpp"
#include "dvrk/run/arm_session.hpp"
#include "dvrk/config/io_config.hpp"

namespace veridyn::cli {

/// Options of the commands under `veridyn dvrk`; each uses a part of them.
struct DvrkRequest {
  const CLI::App* command = nullptr;  ///< command with these options
  std::string config;                 ///< XML or JSON
  std::string robot;                  ///< name in the configuration
  std::string arm;                    ///< PSM1, ...: nominal configuration, gains
  std::string instrument;             ///< instrument whose coupling is used
  std::string model;
  std::string host = "127.0.0.1";
  std::uint16_t port = 1394;
  std::string protocol = "automatic";
  std::size_t mtu = 1500;
  double rate = 1500.0;     ///< [Hz] rate of the loop
  double watchdog = 0.030;  ///< [s] watchdog of the boards
  double seconds = 0.0;     ///< 0: until a signal
  std::string output;
  std::string trajectory;
  std::string gains;
  std::string controller = "pid";  ///< or computed-torque, impedance, gravity
  std::string tip;                 ///< frame of the impedance
  double stiffness = 800.0;        ///< [N/m] stiffness of the impedance
  double approach_speed = 0.25;
  std::vector<double> largest_error;  ///< one per joint, or one for the revolute joints
  bool home = false;                  ///< a reading command may initialise encoders
  bool announce = false;              ///< may send the first packets of a session
  int firmware = 8;
  bool ethernet_only = false; ///< emulated boards have no FireWire between them
  bool firewire = false;      ///< FPGA V3 boards are connected by FireWire
  bool io_expander = false;   ///< emulated boards are QLA 1.5
  bool emulate = false;       ///< `run` emulates boards in this process
  bool everywhere = false;    ///< the emulator listens on all addresses
  std::vector<double> start;  ///< joint positions of the emulated arm
  std::string config_out;
  std::vector<std::string> events;
  std::vector<std::string> arms, models;          ///< arms of the emulator and their models
  std::vector<std::string> chips;                 ///< BOARD=FILE; FILE holds the bytes of the Dallas chip of the instrument on that board
  std::optional<double> pot_noise, current_noise;  ///< [bits] standard deviations of emulated readings
  CommonOptions common;
};

/// The arm's configuration: a file, or the nominal one of a known arm.
struct DvrkArm {
  dvrk::IoConfig config;
  dvrk::RobotConfig robot;
  MatrixXd coupling;
};
/// Reads it. Throws a usage error without --config or --arm, InvalidInput for an unknown robot or instrument.
DvrkArm read_dvrk_arm(const DvrkRequest& request);

/// Options that the request gives for a session with control.
dvrk::ArmSessionOptions session_options(const DvrkRequest& request, const DvrkArm& arm);

/// Prints the faults of the session on standard error; warnings are printed with --quiet as well.
void report_faults(const dvrk::FaultLog& faults);

/// Link to the boards at --host, or with DvrkRequest::emulate to emulated ones in this process, whose clock
/// stops while the program computes. @throws InvalidInput, CLI::ValidationError  as `dvrk emulate`.
std::unique_ptr<dvrk::DatagramLink> link_to_boards(const DvrkRequest& request);

/// Prepares a real-time loop: priority and locked memory. Returns the settings that the system refused, in
/// words.
std::vector<std::string> prepare_loop();

/// "power off is NOT CONFIRMED (an amplifier is still on): press the emergency stop".
std::string unconfirmed_power_text(dvrk::OffState power);

/// Reports the number of rows, and the reason if the file does not have all of them.
void report_rows(const DvrkRequest& request, const dvrk::RunResult& done);

/// Prints timing and faults and writes the JSON file of a client's command.
void finish_dvrk(const DvrkRequest& request, const char* command, const dvrk::RunResult& done,
                 const dvrk::ArmSession& session);

/// `veridyn dvrk`.
void add_dvrk_command(CLI::App& tool, Outcome& outcome);

/// `veridyn dvrk config`.
void add_dvrk_config(CLI::App& dvrk);

ExitStatus run_dvrk_emulate(const DvrkRequest& request);
ExitStatus run_dvrk_monitor(const DvrkRequest& request);
ExitStatus run_dvrk_read(const DvrkRequest& request);
ExitStatus run_dvrk_run(const DvrkRequest& request);

}  // namespace veridyn::cli
