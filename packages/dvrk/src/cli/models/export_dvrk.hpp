#pragma once

#include "veridyn/tool/open_commands.hpp"

namespace veridyn::cli {

/// Files for the software of the da Vinci Research Kit: --dvrk-gravity, --dvrk-scales, --dvrk-arm, --dvrk-config,
/// --static-torques. The files print their accuracy.
ExportExtension export_dvrk();

}  // namespace veridyn::cli
