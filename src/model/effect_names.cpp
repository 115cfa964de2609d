#include "veridyn/model/effect_names.hpp"

namespace veridyn {

const std::vector<std::string>& effect_keys() {
  static const std::vector<std::string> keys{"effect",      "axis",  "offset", "from",
                                             "from_offset", "frame", "values", "std"};
  return keys;
}

}  // namespace veridyn
