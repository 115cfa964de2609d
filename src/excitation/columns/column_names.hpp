#pragma once

#include <string>
#include <vector>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// A standard parameter as people write it.
struct ColumnName {
  std::string name;  ///< "hx_tool" or "viscous_friction(yaw).coefficient"
  std::string unit;
};

/// Of the columns of arm_columns(), in their order.
std::vector<ColumnName> column_names(const Model& arm);

}  // namespace veridyn
