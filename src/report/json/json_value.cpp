#include "report/json/json_value.hpp"

namespace veridyn {

Json json_head(const std::string& command) {
  return {{"veridyn", VERIDYN_VERSION}, {"command", command}};
}

Json json_list(const VectorRef& values) {
  Json list = Json::array();
  for (Eigen::Index i = 0; i < values.size(); ++i) list.push_back(values[i]);
  return list;
}

std::string json_text(const Json& value) {
  return value.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace veridyn
