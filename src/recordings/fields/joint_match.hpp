#pragma once

#include <map>
#include <string>
#include <vector>

namespace veridyn::recordings {

/// For every joint of the arm the index of its recorded name, or -1.
///
/// Rules, in this order: `renamed`; the same name; the same words (`shoulder_pan` matches
/// `shoulder_pan_joint`); the last words (`yaw` matches `PSM1_outer_yaw`, unless another name matches with
/// fewer extra words); the number, if the recorded names are plain numbers, or if none of them shares a word
/// with the joints and all end in a number. The order of the columns never matters.
/// @throws InvalidInput  `renamed` contains a name that is not recorded, or two names fit a joint equally
/// well.
std::vector<int> match_joints(const std::vector<std::string>& wanted,
                              const std::vector<std::string>& recorded,
                              const std::map<std::string, std::string>& renamed);

}  // namespace veridyn::recordings
