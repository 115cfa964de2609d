#include <cmath>

#include "report/pages/page_series.hpp"
#include "math/eigen_pose.hpp"
#include "veridyn/identification/friction_curve.hpp"

namespace veridyn {
namespace {

constexpr double kOpenTurn = 2.0;   // [rad] range that is shown for a joint without limits
constexpr double kOpenWay = 0.2;    // [m] range that is shown for a joint without limits

// The first three rows of T, one after the other, rounded to 1e-9.
Json pose_rows(const Eigen::Isometry3d& T) {
  Json out = Json::array();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) out.push_back(std::round(1e9 * T(r, c)) / 1e9);
    out.push_back(std::round(1e9 * T(r, 3)) / 1e9);
  }
  return out;
}

const char* kind_of(JointType type) {
  return type == JointType::kFixed ? "fixed" : type == JointType::kRevolute ? "revolute" : "prismatic";
}

// The frame that the most coordinates move; if there are several, the last one.
int tip_of(const Model& arm) {
  int best = 0, most = -1;
  for (int k = 0; k < static_cast<int>(arm.frames().size()); ++k) {
    int count = 0;
    for (int i = 0; i < arm.joints(); ++i) count += arm.moves({k}, {i}) ? 1 : 0;
    if (count < most) continue;
    most = count;
    best = k;
  }
  return best;
}

}  // namespace

Json arm_json(const Model& arm, const Eigen::Isometry3d& T_world_base) {
  Json out = {{"name", arm.name()},
              {"base", pose_rows(T_world_base)},
              {"tip", tip_of(arm)},
              {"middle", Json::array()},
              {"range", Json::array()},
              {"frames", Json::array()},
              {"meshes", meshes_json(arm)}};
  for (const Coordinate& c : arm.coordinates()) {
    const double open = c.prismatic ? kOpenWay : kOpenTurn;
    const double low = std::isfinite(c.limits.lower) ? c.limits.lower : -open;
    const double high = std::isfinite(c.limits.upper) ? c.limits.upper : open;
    out["middle"].push_back(0.5 * (low + high));
    out["range"].push_back({low, high});
  }
  for (const Frame& frame : arm.frames()) {
    Json form = Json::array();
    for (int i = 0; i < arm.joints() && frame.type != JointType::kFixed; ++i) {
      if (frame.variable.coefficients[i] != 0.0)
        form.push_back({i, frame.variable.coefficients[i]});
    }
    out["frames"].push_back({{"name", frame.name},
                             {"parent", frame.parent ? frame.parent->value : -1},
                             {"kind", kind_of(frame.type)},
                             {"c", form},
                             {"s0", frame.type == JointType::kFixed ? 0.0 : frame.variable.offset},
                             {"A", pose_rows(eigen(frame.A))},
                             {"B", pose_rows(eigen(frame.B))}});
  }
  return out;
}

void add_friction(Json& series, const Identification& id) {
  series["friction"] = Json::array();
  for (const FrictionCurve& curve : friction_curves(id)) {
    series["friction"].push_back({{"joint", curve.joint.value + 1},
                                  {"velocity", packed_values(curve.velocity)},
                                  {"torque", packed_values(curve.torque)},
                                  {"half", packed_values(curve.half_width)}});
  }
}

}  // namespace veridyn
