#include <algorithm>
#include <cmath>

#include "report/pages/page_series.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/regressor/standard_parameters.hpp"

namespace veridyn {
namespace {

constexpr int kSpeeds = 30;         // of a friction curve, to either side of rest
constexpr int kRun = 60;  // steps of sliding that bring friction with memory to its steady state
constexpr double kRunSeconds = 2.0;
constexpr double kNormal95 = 1.96;  // standard deviations of a normal interval
constexpr double kOpenTurn = 2.0;   // [rad] range shown for joints without limits
constexpr double kOpenWay = 0.2;    // [m] likewise

Json pose_rows(const Eigen::Matrix3d& R, const Eigen::Vector3d& p) {
  Json out = Json::array();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) out.push_back(std::round(1e9 * R(r, c)) / 1e9);
    out.push_back(std::round(1e9 * p[r]) / 1e9);
  }
  return out;
}

Json pose_rows(const Posed& T) {
  Eigen::Matrix3d R;
  R << T.R.row0.x, T.R.row0.y, T.R.row0.z, T.R.row1.x, T.R.row1.y, T.R.row1.z, T.R.row2.x,
      T.R.row2.y, T.R.row2.z;
  return pose_rows(R, Eigen::Vector3d(T.p.x, T.p.y, T.p.z));
}

const char* kind_of(JointType type) {
  return type == JointType::kFixed ? "fixed" : type == JointType::kRevolute ? "revolute" : "prismatic";
}

// The friction of one joint that slides steadily, and on request the parameters' columns.
double friction_at(std::vector<BoundEffect>& effects, int joint, double speed, double q, double load,
                   VectorXd* columns) {
  double torque = 0.0;
  Eigen::Index at = 0;
  for (BoundEffect& effect : effects) {
    const double c = effect.term().axis.coefficients[joint];
    EffectColumns row{};
    effect.reset();
    for (int k = c != 0.0 ? 0 : kRun; k < kRun; ++k) {
      AxisSample sample;
      sample.time = kRunSeconds * k / kRun;
      sample.ds = c * speed;
      sample.s = c * q + effect.term().axis.offset + sample.ds * (sample.time - kRunSeconds);
      sample.load = load;
      effect.columns(sample, row);
    }
    for (int p = 0; p < effect.parameter_count(); ++p, ++at) {
      const auto place = static_cast<std::size_t>(p);
      const double column = c != 0.0 ? c * row[place] : 0.0;
      torque += column * effect.values()[place];
      if (columns != nullptr) (*columns)[at] = column;
    }
  }
  return torque;
}

// Rows of F by parameter, where F F' is their covariance: from the jackknife where a parameter is
// identifiable alone, else its own standard deviation in a separate column.
MatrixXd scatter_of(const Identification& id, const std::vector<std::string>& names) {
  const auto& identified = id.model->description().identified;
  const auto count = static_cast<Eigen::Index>(names.size());
  Eigen::Index clusters = 0;
  if (identified && identified->has_scatter()) clusters = identified->parameters.front().scatter.size();
  MatrixXd F = MatrixXd::Zero(count, clusters + count);
  const std::vector<StandardParameter> all = standard_parameters(*id.model);
  for (Eigen::Index j = 0; j < count; ++j) {
    const std::string& name = names[static_cast<std::size_t>(j)];
    bool alone = false;
    for (std::size_t b = 0; clusters > 0 && b < identified->parameters.size() && !alone; ++b) {
      const IdentifiedParameter& p = identified->parameters[b];
      alone = p.name == name && p.combination.size() == 1 && p.scatter.size() == clusters;
      if (alone) F.row(j).head(clusters) = p.scatter.transpose();
    }
    for (std::size_t k = 0; k < all.size() && !alone; ++k) {
      const auto at = static_cast<Eigen::Index>(k);
      if (all[k].name == name && at < id.parameter_deviations.size() &&
          std::isfinite(id.parameter_deviations[at]))
        F(j, clusters + j) = id.parameter_deviations[at];
    }
  }
  return F;
}

struct JointUse {
  double speed = 0.0, q = 0.0, load = 0.0;
};

JointUse use_of(const Identification& id, std::size_t joint) {
  JointUse out;
  double rows = 0.0;
  for (const RecordingError& r : id.train) {
    const PredictionSeries& s = r.series;
    for (std::size_t k = 0; joint < s.dq.size() && k < s.time.size(); ++k) {
      out.speed = std::max(out.speed, std::abs(s.dq[joint][k]));
      out.q += s.q[joint][k];
      out.load += s.modelled[joint][k] * s.modelled[joint][k];
      rows += 1.0;
    }
  }
  if (rows > 0.0) {
    out.q /= rows;
    out.load = std::sqrt(out.load / rows);
  }
  return out;
}

// The frame that the most coordinates move; the last one of several.
int tip_of(const Model& arm) {
  int best = 0, most = -1;
  for (int k = 0; k < static_cast<int>(arm.frames().size()); ++k) {
    int count = 0;
    for (int i = 0; i < arm.joints(); ++i) count += arm.moves(k, i) ? 1 : 0;
    if (count < most) continue;
    most = count;
    best = k;
  }
  return best;
}

}  // namespace

Json arm_json(const Model& arm, const Eigen::Isometry3d& T_world_base) {
  Json out = {{"name", arm.name()},
              {"base", pose_rows(T_world_base.linear(), T_world_base.translation())},
              {"tip", tip_of(arm)},
              {"middle", Json::array()},
              {"range", Json::array()},
              {"frames", Json::array()}};
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
                             {"parent", frame.parent},
                             {"kind", kind_of(frame.type)},
                             {"c", form},
                             {"s0", frame.type == JointType::kFixed ? 0.0 : frame.variable.offset},
                             {"A", pose_rows(frame.A)},
                             {"B", pose_rows(frame.B)}});
  }
  return out;
}

void add_friction(Json& series, const Identification& id) {
  const Model& arm = *id.model;
  std::vector<BoundEffect> effects;
  std::vector<std::string> names;
  for (const EffectTerm& term : arm.effects()) {
    if (!term.frame.empty() || !has_axis_effect(term.effect)) continue;
    BoundEffect effect(arm, term);
    if (effect.traits().role != EffectRole::kFriction) continue;
    for (int p = 0; p < effect.parameter_count(); ++p) names.push_back(effect.parameter_name(p));
    effects.push_back(std::move(effect));
  }
  series["friction"] = Json::array();
  if (effects.empty()) return;
  const MatrixXd F = scatter_of(id, names);
  for (int joint = 0; joint < arm.joints(); ++joint) {
    const JointUse use = use_of(id, static_cast<std::size_t>(joint));
    if (use.speed < kRestSpeed) continue;
    VectorXd velocity(2 * kSpeeds), torque(2 * kSpeeds), half(2 * kSpeeds), columns(F.rows());
    for (int k = 0; k < 2 * kSpeeds; ++k) {
      const int rank = k < kSpeeds ? k - kSpeeds : k - kSpeeds + 1;  // no speed is zero
      const double share = static_cast<double>(rank) / kSpeeds;
      velocity[k] = use.speed * share * std::abs(share);  // closer together at low speed
      torque[k] = friction_at(effects, joint, velocity[k], use.q, use.load, &columns);
      half[k] = kNormal95 * (F.transpose() * columns).norm();
    }
    series["friction"].push_back({{"joint", joint + 1},
                                  {"velocity", packed(velocity)},
                                  {"torque", packed(torque)},
                                  {"half", packed(half)}});
  }
}

}  // namespace veridyn
