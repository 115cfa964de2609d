#include "report/json/load_cell_json.hpp"

#include "veridyn/report/json/json_value.hpp"

namespace veridyn {

std::string to_json(const LoadCellCalibration& c) {
  Json out = json_head("loadcell");
  out["offset"] = {{"value", c.offset},
                   {"interval", {c.offset - c.offset_interval, c.offset + c.offset_interval}}};
  out["scale"] = {{"value", c.scale},
                  {"interval", {c.scale - c.scale_interval, c.scale + c.scale_interval}},
                  {"unit", "N per count"}};
  out["weights"] = c.weights;
  out["residual"] = c.residual;
  out["nonlinearity"] = c.nonlinearity;
  out["noise"] = c.noise;
  return json_text(out);
}

}  // namespace veridyn
