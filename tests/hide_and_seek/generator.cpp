#include "hide_and_seek/generator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hide_and_seek/places.hpp"

namespace veridyn::seek {
namespace {

constexpr double kHighestPeak = 0.4;  // of the rms torque at share 0.1: no narrow giants

double rms(const VectorXd& x) {
  return std::sqrt(x.squaredNorm() / static_cast<double>(x.size()));
}

// Draws one cause after the other and measures what it does to the training recordings.
class Hider {
 public:
  explicit Hider(const CaseRequest& request)
      : request_(request),
        draw_(request.seed, "case " + text_of(request)),
        hidden_{request, make_bench(request.arm, seed_of(request)), {}, {}, {}, {}, true} {
    hidden_.bench.trouble = request.trouble;
    for (JointSensors& s : hidden_.bench.sensors) {
      if (request.noise > 0.0) s.torque_noise = request.noise;
    }
    const int first = request.mode == Mode::kChanged ? kFirstChanged : 1;
    const int count = request.mode == Mode::kChanged ? kChangedTrain : kBareTrain;
    for (int k = first; k < first + count; ++k) {
      numbers_.push_back(k);
      motions_.emplace_back(hidden_.bench.robot, hidden_.bench.seed, k);
    }
    base_ = recordings(hidden_.bench, {});
  }

  HiddenCase run() {
    if (request_.effects == std::vector<std::string>{"no_friction"}) return without_friction();
    for (const std::string& effect : request_.effects) {
      if (!hide_one(effect)) hidden_.observable = false;
    }
    if (hidden_.causes.empty())
      hidden_.visible = visibility(hidden_.bench, base_, request_.mode == Mode::kBare);
    return std::move(hidden_);
  }

  static unsigned seed_of(const CaseRequest& request) {
    return static_cast<unsigned>(Draw(request.seed, text_of(request)).below(1 << 30));
  }

 private:
  static std::string text_of(const CaseRequest& request) {
    std::string out = request.arm;
    for (const std::string& e : request.effects) out += " " + e;
    if (request.trouble != Trouble::kNone) out += std::string(" ") + name_of(request.trouble);
    return out;
  }

  // The file declares no effect; a good half of the joints have plain friction.
  HiddenCase without_friction() {
    ModelDescription d = hidden_.bench.robot.description();
    d.effects.clear();
    hidden_.bench.robot = Model(std::move(d));
    std::vector<int> joints;
    for (int i = 0; i < hidden_.bench.arm.joints; ++i) joints.push_back(i);
    draw_.shuffle(joints);
    joints.resize((joints.size() + 1) / 2);
    std::sort(joints.begin(), joints.end());
    const std::vector<JointFriction> friction = hidden_.bench.friction;
    for (JointFriction& f : hidden_.bench.friction) f = {};
    for (const int i : joints) {
      const JointFriction& f = friction[i];
      hidden_.causes.push_back({"viscous_friction", i, -1, "", "", {{"coefficient", f.viscous}}});
      hidden_.causes.push_back({"coulomb_friction", i, -1, "", "", {{"level", f.coulomb}}});
    }
    base_.clear();
    base_ = recordings(hidden_.bench, {});
    for (const Cause& c : hidden_.causes)
      hidden_.shares.push_back(share_of(hidden_.bench, c));
    hidden_.visible = visibility(hidden_.bench, recordings(hidden_.bench, hidden_.causes), true);
    return std::move(hidden_);
  }

  std::vector<IdealRecording> recordings(const Bench& bench, const std::vector<Cause>& causes) {
    std::vector<IdealRecording> out;
    for (size_t k = 0; k < motions_.size(); ++k) {
      const MatrixXd* rigid = k < base_.size() ? &base_[k].rigid : nullptr;
      out.push_back(ideal_recording(bench, causes, motions_[k], numbers_[k], rigid));
    }
    return out;
  }

  bool hide_one(const std::string& effect) {
    const bool beside = request_.one_joint && !hidden_.causes.empty();
    std::vector<Cause> places =
        places_for(effect, hidden_.bench, beside ? std::vector<Cause>() : hidden_.causes);
    if (beside) {
      const int joint = hidden_.causes.front().joint;
      places.erase(std::remove_if(places.begin(), places.end(),
                                  [joint](const Cause& c) { return c.joint != joint; }),
                   places.end());
    }
    draw_.shuffle(places);
    if (places.size() > 12) places.resize(12);
    for (Cause& cause : places) {
      Bench bench = hidden_.bench;
      if (is_declared(effect) && request_.mode == Mode::kBare) forget_friction(bench, cause);
      draw_values(cause, bench);
      std::vector<Cause> all = hidden_.causes;
      const Visibility alone =
          visibility(bench, recordings(bench, {cause}), request_.mode == Mode::kBare);
      if (!alone.observable()) continue;
      all.push_back(cause);
      hidden_.bench = bench;
      hidden_.causes = all;
      hidden_.visible =
          all.size() == 1 ? alone
                          : visibility(bench, recordings(bench, all), request_.mode == Mode::kBare);
      hidden_.shares.push_back(share_of(bench, cause));
      return true;
    }
    return false;
  }

  double joint_rms(int joint) const {
    double sum = 0.0;
    for (const IdealRecording& r : base_) sum += std::pow(rms(r.tau.col(joint)), 2);
    return std::sqrt(sum / static_cast<double>(base_.size()));
  }

  Reach reach_of(int joint) const {
    double low = INFINITY;
    double high = -INFINITY;
    Reach out;
    for (size_t k = 0; k < base_.size(); ++k) {
      low = std::min(low, base_[k].rows.q.col(joint).minCoeff());
      high = std::max(high, base_[k].rows.q.col(joint).maxCoeff());
      out.speed = std::max(out.speed, base_[k].rows.dq.col(joint).cwiseAbs().maxCoeff());
      out.duration = std::max(out.duration, motions_[k].duration());
    }
    out.middle = 0.5 * (low + high);
    out.travel = high - low;
    out.slides = hidden_.bench.robot.coordinates()[joint].prismatic;
    return out;
  }

  void draw_values(Cause& cause, const Bench& bench) {
    const double scale = request_.share / 0.1;
    std::map<std::string, double>& v = cause.values;
    const std::string& e = cause.effect;
    const bool slides =
        cause.joint >= 0 &&
        hidden_.bench.robot.coordinates()[cause.joint].prismatic;
    if (e == "torque_gain") {
      v["gain"] = 1.0 + draw_.signed_in(0.05, 0.10) * scale;
      v["error"] = v["gain"] - 1.0;
    }
    if (e == "time_delay") {
      const bool large = cause.constant == "large";
      v["seconds"] = scale * (large              ? draw_.in(20e-3, 50e-3)
                              : cause.joint >= 0 ? draw_.in(3e-3, 8e-3)
                                                 : draw_.in(10e-3, 45e-3));
    }
    if (e == "encoder_offset") {
      const double size =
          cause.constant == "large" ? draw_.in(0.2, 0.4) : draw_.in(0.010, 0.030);
      v["offset"] = draw_.sign() * size * scale * (slides ? 0.2 : 1.0);
    }
    if (e == "gravity_tilt") {
      const double size = draw_.in(0.020, 0.040) * scale;
      const double to = draw_.in(-M_PI, M_PI);
      v["roll"] = size * std::cos(to);
      v["pitch"] = size * std::sin(to);
    }
    if (e == "external_contact")
      v["effort"] = draw_.signed_in(0.3, 0.6) * scale * joint_rms(cause.joint);
    if (e == "torque_crosstalk")
      v["share"] = draw_.signed_in(0.6, 1.4) * request_.share * joint_rms(cause.joint) / joint_rms(cause.from);
    if (e == "payload") draw_payload(cause, scale);
    if (e == "coupling_error") draw_constant(cause, scale);
    if (!linear_parameters(e).empty()) draw_additive(cause, bench);
  }

  void draw_payload(Cause& cause, double scale) {
    for (const Link& link : hidden_.bench.arm.links) {
      if (link.name != cause.frame) continue;
      cause.values["mass"] = draw_.in(0.1, 0.3) * scale * link.moments(3, 3);
      for (const char* axis : {"x", "y", "z"}) cause.values[axis] = 0.03 * draw_.normal();
    }
  }

  void draw_constant(Cause& cause, double scale) {
    for (const Link& link : hidden_.bench.arm.links) {
      if (link.name != cause.frame) continue;
      double stated = 0.0;
      double change = draw_.sign() * scale;
      if (cause.constant == "a" || cause.constant == "d") {
        stated = cause.constant == "a" ? link.a : link.d;
        change *= draw_.in(0.010, 0.030);
      } else if (cause.constant == "ratio") {
        stated = link.ratios[cause.joint];
        change *= draw_.in(0.06, 0.15) * std::abs(stated);
      } else {
        stated = cause.constant == "alpha" ? link.alpha : link.theta;
        change *= draw_.in(0.04, 0.10);
      }
      cause.values = {{"value", stated + change}, {"correction", change}};
    }
  }

  // Linear parameters of equal weight whose sum has the requested rms.
  void draw_additive(Cause& cause, const Bench& bench) {
    Reach reach = reach_of(cause.joint);
    if (cause.effect == "cable_coupling") reach.middle = reach_of(cause.from).middle;
    draw_shapes(cause, reach, draw_);
    const std::vector<std::string> names = linear_parameters(cause.effect);
    for (const std::string& name : names) cause.values[name] = 0.0;
    const std::vector<MatrixXd> columns = columns_of(cause);
    VectorXd weights(names.size());
    const bool any_sign =
        cause.effect == "torque_ripple" || cause.effect == "cable_coupling" ||
        cause.effect == "asymmetric_friction" || cause.effect == "position_dependent_friction" ||
        cause.effect == "position_dependent_viscosity" || cause.effect == "torque_drift" ||
        cause.effect == "torque_offset" || cause.effect == "position_force";
    for (Eigen::Index p = 0; p < weights.size(); ++p) {
      double square = 0.0;
      for (const MatrixXd& c : columns) square += std::pow(rms(c.col(p)), 2);
      weights[p] = draw_.in(0.6, 1.4) / std::sqrt(square / static_cast<double>(columns.size()));
      if (any_sign) weights[p] *= draw_.sign();
    }
    double square = 0.0;
    double peak = 0.0;
    for (const MatrixXd& c : columns) {
      const VectorXd sum = c * weights;
      square += sum.squaredNorm() / static_cast<double>(sum.size());
      peak = std::max(peak, sum.cwiseAbs().maxCoeff());
    }
    const double wanted = request_.share * joint_rms(cause.joint);
    const double size = std::min(
        wanted / std::sqrt(square / static_cast<double>(columns.size())),
        (cause.effect == "stribeck_friction" ? kHighestPeak / 0.1 : INFINITY) * wanted / peak);
    for (Eigen::Index p = 0; p < weights.size(); ++p)
      cause.values[names[p]] = size * weights[p];
    if (is_declared(cause.effect) && request_.mode == Mode::kChanged) keep_positive(cause, bench);
  }

  // Changed friction may fall as well, but not below zero.
  void keep_positive(Cause& cause, const Bench& bench) {
    const JointFriction& f = bench.friction[cause.joint];
    if (cause.effect == "torque_offset") return;
    const bool viscous = cause.effect == "viscous_friction";
    double& change = cause.values[viscous ? "coefficient" : "level"];
    const double now = viscous ? f.viscous : f.coulomb;
    if (draw_.sign() < 0.0 && change < 0.7 * now) change = -change;
    cause.values["now"] = now + change;
  }

  std::vector<MatrixXd> columns_of(const Cause& cause) const {
    std::vector<MatrixXd> out;
    for (size_t k = 0; k < motions_.size(); ++k)
      out.push_back(
          cause_columns(cause, motions_[k], base_[k].rows, base_[k].rigid.col(cause.joint)));
    return out;
  }

  // Rms of what a cause adds to the torque of its joint (of the joint that it changes most).
  double share_of(const Bench& bench, const Cause& cause) {
    const std::vector<IdealRecording> with = recordings(bench, {cause});
    const std::vector<IdealRecording> without = recordings(bench, {});
    double largest = 0.0;
    for (int i = 0; i < bench.arm.joints; ++i) {
      double square = 0.0;
      for (size_t k = 0; k < with.size(); ++k)
        square += std::pow(rms(with[k].tau.col(i) - without[k].tau.col(i)), 2);
      largest =
          std::max(largest, std::sqrt(square / static_cast<double>(with.size())) / joint_rms(i));
    }
    return largest;
  }

  CaseRequest request_;
  Draw draw_;
  HiddenCase hidden_;
  std::vector<int> numbers_;
  std::vector<Motion> motions_;
  std::vector<IdealRecording> base_;
};

}  // namespace

namespace {

// Later recordings are warmer than those that the model was made from; an elastic base is one.
std::vector<Cause> facts_of_trouble(const HiddenCase& hidden) {
  std::vector<Cause> out;
  const Bench& bench = hidden.bench;
  if (bench.trouble == Trouble::kElasticBase) out.push_back({"base_compliance", -1, -1, "", "", {}});
  if (hidden.request.mode != Mode::kChanged || bench.trouble != Trouble::kTemperatureDrift) return out;
  const double first = viscosity_factor(bench.trouble, bench.seed, place_in_time(kFirstChanged));
  for (size_t i = 0; i < bench.friction.size(); ++i) {
    if (bench.friction[i].viscous <= 0.0) continue;
    Cause warmer;
    warmer.effect = "viscous_friction";
    warmer.joint = static_cast<int>(i);
    warmer.values = {{"now", first * bench.friction[i].viscous}};
    out.push_back(std::move(warmer));
  }
  return out;
}

}  // namespace

const std::vector<std::string>& special_cases() {
  static const std::vector<std::string> kNames = {"common_delay", "large_zero", "large_delay",
                                                  "common_gain", "no_friction"};
  return kNames;
}

HiddenCase hide(const CaseRequest& request) {
  HiddenCase out = Hider(request).run();
  out.also_true = facts_of_trouble(out);
  return out;
}

CaseFiles write_case(const HiddenCase& hidden, const std::string& folder, double reach) {
  const unsigned seed = hidden.bench.seed;
  const auto write = [&](const std::vector<Cause>& causes, int number, const std::string& name) {
    const Motion motion(hidden.bench.robot, seed, number, causes.empty() ? 1.0 : reach);
    std::string path = folder + "/" + name + ".csv";
    write_recording(hidden.bench, ideal_recording(hidden.bench, causes, motion, number), seed,
                    number, path);
    return path;
  };
  CaseFiles out;
  const bool changed = hidden.request.mode == Mode::kChanged;
  for (int k = 1; changed && k <= kCleanRecordings; ++k)
    out.clean.push_back(write({}, k, fmt::format("clean-{}", k)));
  const int train = changed ? kChangedTrain : kBareTrain;
  for (int k = 0; k <= train; ++k) {
    const int number = (changed ? kFirstChanged : 1) + k;
    (k < train ? out.train : out.test)
        .push_back(write(hidden.causes, number, fmt::format("recording-{}", k + 1)));
  }
  return out;
}

std::string describe(const Cause& cause, const Model& robot) {
  const auto name = [&](int i) { return robot.coordinates()[i].name; };
  std::string out = cause.effect;
  if (!cause.frame.empty()) out += " on " + cause.frame;
  if (!cause.constant.empty()) out += " (" + cause.constant + ")";
  if (cause.joint >= 0) out += fmt::format(" on {} ({})", cause.joint + 1, name(cause.joint));
  if (cause.from >= 0) out += fmt::format(" from {} ({})", cause.from + 1, name(cause.from));
  for (const auto& [key, value] : cause.values) out += fmt::format(" {}={:.4g}", key, value);
  return out;
}

}  // namespace veridyn::seek
