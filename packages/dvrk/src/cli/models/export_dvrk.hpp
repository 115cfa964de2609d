#pragma once

#include "veridyn/tool/open_commands.hpp"

namespace veridyn::cli {

/// Files that laboratories with a da Vinci Research Kit use: --dvrk-gravity, --dvrk-scales, --dvrk-arm, --dvrk-config,
/// --static-torques. The files print their accuracy.
ExportExtension export_dvrk();

}  // namespace veridyn::cli
