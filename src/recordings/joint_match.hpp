#pragma once

#include <map>
#include <string>
#include <vector>

namespace veridyn::recordings {

/// For every joint that is wanted the index of the name under which it is recorded, or -1.
///
/// In this order: as `renamed` says; the same name; the same words (`shoulder_pan` is
/// `shoulder_pan_joint`); the last words (`yaw` is `PSM1_outer_yaw`, unless another name says it in
/// fewer words); where the recorded names are mere numbers, or none of them says anything of the
/// wanted ones and all end in a number, the number. The order of the columns is never a reason.
/// @throws InvalidInput  `renamed` names what is not recorded, or two names fit a joint equally
/// well.
std::vector<int> match_joints(const std::vector<std::string>& wanted,
                              const std::vector<std::string>& recorded,
                              const std::map<std::string, std::string>& renamed);

}  // namespace veridyn::recordings
