#pragma once

#include <memory>
#include <string>

#include "veridyn/control/load_cell.hpp"

namespace veridyn {

/// A serial line by the system's own terminal interface: for devices that libserialport has no
/// record of, as pseudo-terminals and lines over Bluetooth, and for builds without it.
/// @throws InvalidInput  it cannot be opened, is no terminal, or has no such speed.
std::unique_ptr<ForceSource> open_terminal_line(const std::string& device, int baud,
                                                LoadCellFormat format);

}  // namespace veridyn
