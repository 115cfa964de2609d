#include <fmt/format.h>

#include <cmath>
#include <map>

#include "veridyn/files/input_file.hpp"
#include "veridyn/math/student_t.hpp"
#include "veridyn/files/yaml/yaml_node.hpp"
#include "veridyn/control/load_cell.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

struct Weight {
  double sum = 0.0, squares = 0.0;
  int count = 0;
  double mean() const { return sum / count; }
};

}  // namespace

LoadCellCalibration calibrate_load_cell(const std::vector<double>& force,
                                        const std::vector<double>& raw) {
  require(force.size() == raw.size(), "load cell: found ", force.size(), " forces and ", raw.size(),
          " readings, expected as many.");
  std::map<double, Weight> weights;
  for (std::size_t k = 0; k < force.size(); ++k) {
    require(std::isfinite(force[k]) && std::isfinite(raw[k]),
            "load cell: found a force or a reading that is not finite.");
    Weight& w = weights[force[k]];
    w.sum += raw[k];
    ++w.count;
  }
  require(weights.size() >= 2, "load cell: found ", weights.size(),
          " different forces, expected two or more.");
  for (std::size_t k = 0; k < force.size(); ++k) {
    Weight& w = weights[force[k]];
    w.squares += (raw[k] - w.mean()) * (raw[k] - w.mean());
  }
  // raw = offset + slope force; each weight counts as often as it has readings.
  double n = 0.0, f = 0.0, r = 0.0;
  for (const auto& [newtons, w] : weights) {
    n += w.count;
    f += w.count * newtons;
    r += w.count * w.mean();
  }
  const double f_mean = f / n;
  const double r_mean = r / n;
  double ff = 0.0, fr = 0.0, within = 0.0;
  for (const auto& [newtons, w] : weights) {
    ff += w.count * (newtons - f_mean) * (newtons - f_mean);
    fr += w.count * (newtons - f_mean) * (w.mean() - r_mean);
    within += w.squares;
  }
  const double slope = fr / ff;
  require(slope != 0.0, "load cell: found the same reading under all forces.");
  LoadCellCalibration out;
  out.weights = static_cast<int>(weights.size());
  out.scale = 1.0 / slope;
  out.offset = r_mean - slope * f_mean;
  double between = 0.0, plain = 0.0;
  for (const auto& [newtons, w] : weights) {
    const double off = w.mean() - out.offset - slope * newtons;
    between += w.count * off * off;
    plain += off * off;
    out.nonlinearity = std::max(out.nonlinearity, std::abs(off * out.scale));
  }
  const double inside = n - static_cast<double>(weights.size());
  out.noise = inside > 0.0 ? std::sqrt(within / inside) * std::abs(out.scale) : 0.0;
  out.residual = std::sqrt(plain / static_cast<double>(weights.size())) * std::abs(out.scale);
  const bool by_means = weights.size() > 2;
  if (!by_means) out.nonlinearity = std::numeric_limits<double>::quiet_NaN();
  const double freedom = by_means ? static_cast<double>(weights.size()) - 2.0 : inside;
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  if (freedom <= 0.0) {
    out.scale_interval = out.offset_interval = unknown;
    return out;
  }
  const double variance = (by_means ? between : within) / freedom;  // variance of one reading [counts^2]
  const double t = student_t_quantile(0.05, freedom);
  const double slope_interval = t * std::sqrt(variance / ff);
  out.scale_interval = slope_interval / (slope * slope);
  out.offset_interval = t * std::sqrt(variance * (1.0 / n + f_mean * f_mean / ff));
  return out;
}

std::string load_cell_text(const LoadCellCalibration& c) {
  return fmt::format(
      "veridyn: 1\nload_cell:\n  offset: {:.12g}  # counts\n  scale: {:.12g}  # N per count\n",
      c.offset, c.scale);
}

LoadCellCalibration read_load_cell(const std::string& path) {
  const std::string content = content_of_file(path, "a load cell's calibration (YAML)");
  YamlSource source;
  source.file = path;
  source.expected = "a load cell's calibration";
  const YamlNode root = YamlNode::parse(content, source);
  const YamlNode cell = root.at("load_cell");
  LoadCellCalibration out;
  out.offset = cell.at("offset").number();
  const YamlNode scale = cell.at("scale");
  out.scale = scale.number();
  if (out.scale == 0.0) scale.fail(scale.found(), "a number that is not zero");
  return out;
}

}  // namespace veridyn
