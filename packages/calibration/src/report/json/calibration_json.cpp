#include "report/json/calibration_json.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "veridyn/report/json/json_value.hpp"

namespace veridyn {
namespace {

constexpr double kDegrees = 180.0 / M_PI;

Json interval_json(double value, double half) {
  return Json::array({value - half, value + half});
}

// Interval of a magnitude, which is not negative.
Json size_interval_json(double value, double half) {
  return Json::array({std::max(0.0, value - half), value + half});
}

Json interval_json(const Eigen::Vector3d& value, const Eigen::Vector3d& half) {
  Json out = Json::array();
  for (int c = 0; c < 3; ++c) out.push_back(interval_json(value[c], half[c]));
  return out;
}

// JSON with the keys that all parts share: part, status, reason.
Json calibration_json_head(const std::string& part, CalibrationStatus status, const std::string& reason) {
  Json out = json_head("calibrate");
  out["part"] = part;
  out["status"] = status == CalibrationStatus::kDone ? "done" : "cannot_answer";
  out["reason"] = reason;
  return out;
}

// Pose with qw >= 0, and its 95 % radii.
Json pose_json(const Eigen::Isometry3d& T, double metres, double radians) {
  Eigen::Quaterniond q(T.linear());
  if (q.w() < 0.0) q.coeffs() *= -1.0;
  return {{"translation", json_list(T.translation())},
          {"quaternion", {q.w(), q.x(), q.y(), q.z()}},
          {"interval_m", metres},
          {"interval_deg", kDegrees * radians}};
}

Json axis_json(const CalibratedAxis& a) {
  return {{"between", {a.a, a.b}},
          {"direction", json_list(a.direction)},
          {"point", json_list(a.point)},
          {"interval_deg", kDegrees * a.radius_angle},
          {"interval_m", a.radius},
          {"range_deg", kDegrees * a.range},
          {"at_rest_frames", a.frames},
          {"wobble_deg", kDegrees * a.wobble},
          {"play_m", a.play},
          {"closes_loop", a.closes_loop},
          {"loop_play_m", a.loop_play}};
}

Json link_json(const CalibratedLink& l) {
  return {{"axes", {l.first, l.second}},
          {"body", l.body},
          {"distance", l.distance},
          {"plane_parallel_distance", l.plane_parallel_distance},
          {"twist_deg", kDegrees * l.twist},
          {"interval", size_interval_json(l.distance, l.distance_half_width)},
          {"plane_parallel_interval",
           size_interval_json(l.plane_parallel_distance, l.plane_half_width)},
          {"twist_interval_deg",
           size_interval_json(kDegrees * l.twist, kDegrees * l.twist_half_width)}};
}

}  // namespace

std::string to_json(const AxesCalibration& r) {
  Json out = calibration_json_head("axis", r.status, r.reason);
  out["source"] = r.source;
  out["frames"] = r.frames;
  out["used_frames"] = r.used_frames;
  out["outliers"] = r.outliers;
  out["rms"] = r.rms;
  out["frames_per_independent_frame"] = r.correlation;
  out["axes"] = json_each(r.axes, axis_json);
  out["links"] = json_each(r.links, link_json);
  out["bodies"] = json_each(r.bodies, [&](const CapturedBody& b) -> Json {
    return {{"body", b.name}, {"markers", b.markers}, {"seen", b.seen}, {"noise", b.noise}, {"outliers", b.outliers},
            {"relabelled", b.relabelled}, {"fault", b.fault}};
  });
  out["cannot_tell"] = r.cannot_tell;
  return json_text(out);
}

std::string to_json(const RemoteCenter& r) {
  Json out = calibration_json_head("rcm", r.status, r.reason);
  out["source"] = r.source;
  out["body"] = r.body;
  out["frames"] = r.frames;
  out["outliers"] = r.outliers;
  out["swing_deg"] = json_list(r.swing);
  out["condition_number"] = r.condition;
  if (r.status != CalibrationStatus::kDone) return json_text(out);
  out["rcm"] = json_list(r.rcm);
  out["tip"] = json_list(r.tip);
  out["rms"] = json_list(r.rms);
  out["interval"] = {{"rcm", interval_json(r.rcm, r.rcm_half_width)},
                     {"tip", interval_json(r.tip, r.tip_half_width)},
                     {"rms", interval_json(r.rms, r.rms_half_width)}};
  out["rcm_interval"] = json_list(r.rcm_half_width);
  out["tip_interval"] = json_list(r.tip_half_width);
  out["rms_interval"] = json_list(r.rms_half_width);
  out["interval_m"] = r.rcm_radius;
  out["rms_all"] = json_list(r.rms_all);
  out["noise"] = {{"position", r.position_noise}, {"orientation_deg", kDegrees * r.orientation_noise}};
  out["frames_per_independent_frame"] = r.correlation;
  return json_text(out);
}

std::string to_json(const LinksCalibration& r, const std::string& model_file,
                    const std::string& comparison) {
  Json out = calibration_json_head("links", r.status, r.reason);
  out["robot"] = r.robot;
  out["source"] = r.source;
  out["frame"] = r.frame;
  out["frames"] = r.frames;
  out["outliers"] = r.outliers;
  if (r.status != CalibrationStatus::kDone) return json_text(out);
  out["base_free"] = r.base_free;
  out["tool_free"] = r.tool_free;
  out["base"] = pose_json(r.base, 0.0, 0.0);
  out["tool"] = pose_json(r.tool, 0.0, 0.0);
  for (const char* pose : {"base", "tool"}) {
    out[pose].erase("interval_m");
    out[pose].erase("interval_deg");
  }
  out["constants"] = json_each(r.constants, [&](const LinkConstant& c) -> Json {
    return {{"name", c.name}, {"frame", c.frame}, {"unit", c.unit}, {"file", c.file}, {"found", c.found},
            {"interval", {c.low, c.high}}, {"identifiable", c.identifiable}, {"changed", c.changed}, {"why", c.why}};
  });
  out["named"] = Json::array();
  for (const int k : r.named) {
    const LinkConstant& c = r.constants[k];
    out["named"].push_back({{"name", c.name},
                            {"frame", c.frame},
                            {"file", c.file},
                            {"found", c.found},
                            {"interval", {c.low, c.high}}});
  }
  out["explained"] = r.explained;
  out["rms"] = r.rms;
  out["rms_deg"] = kDegrees * r.rms_angle;
  out["rms_file"] = r.rms_file;
  out["held_out_rms"] = r.held_out_rms;
  out["held_out_rms_all_rows"] = r.held_out_rms_all;
  out["held_out_rms_file"] = r.held_out_rms_file;
  out["held_out_deg"] = kDegrees * r.held_out_angle;
  out["rank_gap"] = r.rank_gap;
  out["frames_per_independent_frame"] = r.correlation;
  if (!comparison.empty()) out["comparison"] = comparison;
  out["model"] = model_file.empty() ? Json() : Json(model_file);
  out["seconds"] = r.seconds;
  return json_text(out);
}

std::string to_json(const HandEye& r) {
  Json out = calibration_json_head("handeye", r.status, r.reason);
  out["pairs"] = r.pairs;
  out["outliers"] = r.outliers;
  out["swing_deg"] = json_list(r.swing);
  out["forms"] = json_each(r.forms, [&](const HandEye::Alternative& f) -> Json {
    return {{"form", name_of(f.form)}, {"noise", f.reason.empty() ? Json(f.rms) : Json()},
            {"noise_deg", f.reason.empty() ? Json(kDegrees * f.rms_angle) : Json()}, {"reason", f.reason}};
  });
  if (r.status != CalibrationStatus::kDone) return json_text(out);
  out["form"] = name_of(r.form);
  out["transform"] = pose_json(r.transform, r.radius, r.radius_angle);
  if (r.other) {
    const char* const name = r.form == HandEyeForm::kEyeInHand ? "target" : "tool";
    out[name] = pose_json(*r.other, r.other_radius, r.other_radius_angle);
  }
  out["rms"] = r.rms;
  out["rms_deg"] = kDegrees * r.rms_angle;
  return json_text(out);
}

std::string to_json(const PoseDesign& design) {
  Json out = json_head("excite");
  out["for"] = "calibration";
  out["robot"] = design.robot;
  out["frame"] = design.frame;
  out["constants"] = design.constants;
  out["gain"] = design.gain;
  out["poses"] = Json::array();
  for (Eigen::Index k = 0; k < design.q.rows(); ++k)
    out["poses"].push_back({{"t", design.time[k]}, {"q", json_list(VectorXd(design.q.row(k)))}});
  out["predictions"] = Json::array();
  for (const PoseDesign::Prediction& p : design.predictions)
    out["predictions"].push_back({{"name", p.name}, {"unit", p.unit}, {"std", p.deviation}});
  return json_text(out);
}

}  // namespace veridyn
