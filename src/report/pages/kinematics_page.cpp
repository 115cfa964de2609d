#include "report/json/kinematics_json.hpp"

#include <algorithm>
#include <cmath>

#include "report/json/json_value.hpp"
#include "report/pages/page.hpp"
#include "report/pages/page_series.hpp"

namespace veridyn {
namespace {

constexpr std::size_t kDrawn = 2000;  // largest number of points in a page

Json conditioning_json(const Conditioning& c) {
  return {{"condition", c.condition}, {"smallest", c.smallest}, {"manipulability", c.manipulability}};
}

Json row_json(const KinematicRow& row, bool inverse) {
  const Eigen::Quaterniond r(row.T_world_tip.linear());
  Json jacobian = Json::array();
  for (Eigen::Index k = 0; k < row.jacobian.rows(); ++k)
    jacobian.push_back(json_list(row.jacobian.row(k).transpose()));
  Json out = {{"q", json_list(row.q)},
              {"position", json_list(VectorXd(row.T_world_tip.translation()))},
              {"quaternion", {r.w(), r.x(), r.y(), r.z()}},
              {"position_conditioning", conditioning_json(row.position)},
              {"pose_conditioning", conditioning_json(row.pose)},
              {"jacobian", jacobian}};
  if (!inverse) return out;
  out["status"] = name_of(row.status);
  out["position_error"] = row.position_error;
  out["angle_error"] = row.angle_error;
  return out;
}

Json head_json(const KinematicTable& table) {
  Json out = json_head("kinematics");
  out["robot"] = table.robot;
  out["frame"] = table.frame;
  out["solver"] = name_of(table.solver);
  out["joints"] = table.joints;
  out["not_reached"] = table.unreached();
  return out;
}

}  // namespace

std::string to_json(const KinematicTable& table) {
  Json out = head_json(table);
  out["rows"] = json_each(table.rows, [&](const KinematicRow& row) -> Json { return row_json(row, table.is_inverse()); });
  return json_text(out);
}

std::string to_page(const KinematicTable& table, const Model& arm, const std::string& command) {
  Json result = head_json(table);
  result["settings"] = Json::object();
  result["postures"] = table.rows.size();
  Json points = Json::array();
  const std::size_t every = std::max<std::size_t>(1, table.rows.size() / kDrawn);
  for (std::size_t k = 0; k < table.rows.size(); k += every) {
    const Eigen::Vector3d p = table.rows[k].T_world_tip.translation();
    const double condition = table.rows[k].position.condition;
    points.push_back({p.x(), p.y(), p.z(), std::isfinite(condition) ? Json(condition) : Json()});
  }
  result["points"] = points;
  Json series = series_of(command, arm);
  series["joints"].clear();
  if (const auto tip = arm.find_frame(table.frame)) series["arms"][0]["tip"] = tip->value;
  const auto shown = static_cast<Eigen::Index>((table.rows.size() + every - 1) / every);
  MatrixXd q(shown, arm.joints());
  VectorXd time(shown);
  for (Eigen::Index k = 0; k < shown; ++k) {
    const auto row = static_cast<std::size_t>(k) * every;
    q.row(k) = table.rows[row].q.transpose();
    time[k] = table.has_time ? table.rows[row].time : static_cast<double>(row);
  }
  Json columns = Json::array();
  for (int i = 0; i < arm.joints(); ++i) columns.push_back(packed_values(q.col(i)));
  series["recordings"].push_back(
      {{"role", "postures"}, {"time", times(time)}, {"timed", table.has_time}, {"q", columns}});
  return html_page(table.robot + ": kinematics", json_text(result), series, table.report());
}

}  // namespace veridyn
