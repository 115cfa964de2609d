#include "report/pages/calibration_page.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "report/pages/calibration_files.hpp"
#include "veridyn/report/json/json_value.hpp"
#include "report/json/calibration_json.hpp"
#include "veridyn/report/pages/page.hpp"
#include "veridyn/report/pages/page_series.hpp"

namespace veridyn {
namespace {

constexpr double kDegrees = 180.0 / M_PI;
constexpr int kBins = 40;
constexpr double kWidest = 4.0;  // range of a histogram to either side, in standard deviations
constexpr std::size_t kMostPoints = 1500;  // points of a drawing

// Data of a page, with an empty drawing.
Json page_series(const std::string& command, const std::string& title, const std::string& facts,
                 const std::string& verdict) {
  Json out = series_of(command);
  out["title"] = title;
  out["facts"] = facts;
  out["verdict"] = verdict;
  out["space"] = {
      {"points", Json::array()}, {"lines", Json::array()}, {"frames", Json::array()}};
  out["histograms"] = Json::array();
  return out;
}

// Draws at most 1500 of these points.
void add_points(Json& series, const std::string& name, const std::vector<Eigen::Vector3d>& at) {
  Json points = Json::array();
  const std::size_t step = at.size() / kMostPoints + 1;
  for (std::size_t k = 0; k < at.size(); k += step) points.push_back(json_list(at[k]));
  series["space"]["points"].push_back({{"name", name}, {"at", points}});
}

void add_frame(Json& series, const std::string& name, const Eigen::Isometry3d& T) {
  Json axes = Json::array();
  for (int c = 0; c < 3; ++c) axes.push_back(json_list(VectorXd(T.linear().col(c))));
  series["space"]["frames"].push_back(
      {{"name", name}, {"origin", json_list(T.translation())}, {"axes", axes}});
}

// Adds a histogram of values * scale, in `unit`. Signed errors are centred at zero; magnitudes start at zero.
void add_histogram(Json& series, const std::string& name, const std::string& unit,
                   const std::vector<double>& values, double scale) {
  if (values.empty()) return;
  double square = 0.0;
  bool has_sign = false;
  for (const double v : values) {
    square += v * v;
    has_sign = has_sign || v < 0.0;
  }
  const double deviation = std::sqrt(square / static_cast<double>(values.size()));
  const double high = std::max(1e-12, kWidest * deviation);
  const double low = has_sign ? -high : 0.0;
  std::vector<int> counts(kBins, 0);
  for (const double v : values) {
    const int bin = static_cast<int>(std::floor((v - low) / (high - low) * kBins));
    if (bin >= 0 && bin < kBins) ++counts[bin];
  }
  series["histograms"].push_back({{"name", name},
                                  {"unit", unit},
                                  {"low", scale * low},
                                  {"high", scale * high},
                                  {"counts", counts}});
}

std::string html_of(const Json& series, const std::string& result, const std::string& report) {
  return html_page(series["title"].get<std::string>(), result, series, report, calibration_file("script.js"));
}

}  // namespace

std::string to_page(const AxesCalibration& r, const std::string& command) {
  Json series = page_series(
      command, "Axes of rotation", r.source,
      fmt::format("{} axes of rotation and {} links between them.", r.axes.size(), r.links.size()));
  for (const auto& [name, shape] : r.shapes) {
    std::vector<Eigen::Vector3d> at;
    for (Eigen::Index k = 0; k < shape.cols(); ++k) at.emplace_back(shape.col(k));
    add_points(series, name, at);
  }
  for (std::size_t k = 0; k < r.axes.size(); ++k) {
    const CalibratedAxis& a = r.axes[k];
    const Eigen::Vector3d half = 0.1 * a.direction;
    series["space"]["lines"].push_back({{"name", fmt::format("axis {}", k + 1)},
                                        {"from", json_list(VectorXd(a.point - half))},
                                        {"to", json_list(VectorXd(a.point + half))}});
  }
  add_histogram(series, "Coordinates of markers", "mm", r.residuals, 1e3);
  return html_of(series, to_json(r), r.report());
}

std::string to_page(const RemoteCenter& r, const std::string& command) {
  Json series = page_series(command, "Remote centre", r.source,
                            fmt::format("The remote centre from {} frames.", r.frames));
  std::vector<Eigen::Vector3d> track;
  std::vector<double> errors[3];
  for (std::size_t k = 0; k < r.poses.size(); ++k) {
    track.emplace_back(r.poses[k].translation());
    if (r.is_outlier.empty() || r.is_outlier[k] != 0) continue;
    for (int c = 0; c < 3; ++c) errors[c].push_back(r.points[k][c] - r.rcm[c]);
  }
  add_points(series, "body", track);
  Eigen::Isometry3d centre = Eigen::Isometry3d::Identity();
  centre.translation() = r.rcm;
  add_frame(series, "remote centre", centre);
  for (int c = 0; c < 3; ++c)
    add_histogram(series, std::string("Along ") + "xyz"[c], "mm", errors[c], 1e3);
  return html_of(series, to_json(r), r.report());
}

std::string to_page(const LinksCalibration& r, const std::string& command,
                    const std::string& comparison) {
  std::string verdict = "Many constants differ from the file.";
  if (r.explained) {
    verdict = r.named.empty() ? "No constant differs from the file." : "Wrong in the file: ";
    for (std::size_t k = 0; k < r.named.size(); ++k) {
      const LinkConstant& c = r.constants[r.named[k]];
      verdict += (k > 0 ? ", " : "") + c.name + (c.frame.empty() ? "" : " of " + c.frame);
    }
    if (!r.named.empty()) verdict += ".";
  }
  Json series = page_series(command, r.robot + ": constants from poses", r.source, verdict);
  add_points(series, r.frame, r.positions);
  add_frame(series, "base", r.base);
  if (r.model && r.joints.rows() > 1) {
    series["arms"].push_back(arm_json(*r.model, r.base));
    Json q = Json::array();
    for (Eigen::Index i = 0; i < r.joints.cols(); ++i) q.push_back(packed_values(r.joints.col(i)));
    const VectorXd poses = VectorXd::LinSpaced(r.joints.rows(), 0.0, static_cast<double>(r.joints.rows() - 1));
    series["recordings"].push_back({{"time", times(poses)}, {"q", q}});
  }
  add_histogram(series, "Positions", "mm", r.residuals, 1e3);
  add_histogram(series, "Orientations", "deg", r.residual_angles, kDegrees);
  return html_of(series, to_json(r, "", comparison), r.report());
}

std::string to_page(const HandEye& r, const std::string& command) {
  Json series = page_series(command, "Pose between two bases", name_of(r.form),
                            fmt::format("The pose of B in A, from {} pairs.", r.pairs));
  add_frame(series, "A", Eigen::Isometry3d::Identity());
  add_frame(series, "B", r.transform);
  std::vector<double> lengths;
  for (const Eigen::Vector3d& e : r.residuals) lengths.push_back(e.norm());
  add_histogram(series, "Positions", "mm", lengths, 1e3);
  if (r.rms_angle > 0.0) add_histogram(series, "Orientations", "deg", r.residual_angles, kDegrees);
  return html_of(series, to_json(r), r.report());
}

}  // namespace veridyn
