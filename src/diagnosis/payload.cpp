#include "veridyn/diagnosis/payload.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "diagnosis/candidates.hpp"
#include "diagnosis/load_fit.hpp"
#include "diagnosis/numerics.hpp"
#include "diagnosis/load_numbers.hpp"
#include "effects/plain_friction.hpp"
#include "identification/many_recordings.hpp"
#include "identification/silent_joints.hpp"
#include "identification/velocity_choice.hpp"
#include "math/digits.hpp"
#include "math/numbers.hpp"
#include "math/student_t.hpp"
#include "model/moving_frame.hpp"
#include "model/suggestion.hpp"
#include "recordings/named_recordings.hpp"
#include "veridyn/effects/cause.hpp"
#include "veridyn/effects/effect_facts.hpp"
#include "veridyn/identification/pseudo_inertia.hpp"
#include "veridyn/identification/rest_poses.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/regressor/standard_parameters.hpp"

namespace veridyn {
namespace {

using namespace loads;

// The last frame of every link that moves; or only that of the link with the given frame, under its name.
std::vector<int> places_of(const Model& arm, const std::string& link) {
  std::vector<int> out;
  if (!link.empty()) {
    std::vector<std::string> names;
    for (const Frame& frame : arm.frames()) names.push_back(frame.name);
    const std::optional<FrameIndex> frame = arm.find_frame(link);
    require(frame.has_value(), "--link: found '", link, "', expected the name of a frame", did_you_mean(link, names), ".");
    return {frame->value};
  }
  for (const FrameIndex frame : payload_frames(arm)) out.push_back(frame.value);
  return out;
}

// Fits effects without values, such as friction of a CAD model, to these recordings; existing values of
// bodies and effects are kept.
Model with_fitted_effects(const Model& cad, const std::vector<std::string>& recordings,
                          const IdentificationOptions& options) {
  ModelDescription d = cad.description();
  for (Frame& frame : d.frames) {
    if (frame.body) frame.body->fixed = true;
  }
  for (EffectTerm& term : d.effects) {
    if (has_axis_effect(term.effect)) term.fixed = EffectFacts(cad, term).has_values();
  }
  const Identification id = identify(Model(std::move(d)), recordings, {}, options);
  require(id.model.has_value(), "payload: found effects without values in '", cad.name(),
          "', and these recordings do not give them: ", id.reason);
  return *id.model;
}

// The arm with a body of this load on the link that carries it.
Model with_load(const Model& arm, const PayloadEstimate& load) {
  ModelDescription d = arm.description();
  Frame frame;
  frame.name = std::string(AddedLoad::kName) + "@" + load.frame;
  frame.parent = arm.find_frame(load.frame);
  frame.variable.coefficients = VectorXd::Zero(arm.joints());
  frame.body = Body{};
  frame.body->phi = load.phi;
  d.frames.push_back(std::move(frame));
  return Model(std::move(d));
}

// The arm with the effect values that were fitted at the same time as a load.
Model with_effects_of(const Model& arm, const Model& fitted) {
  ModelDescription d = arm.description();
  d.effects = fitted.effects();
  return Model(std::move(d));
}

// An arm with fixed values, with a load in every place and all effects that may have changed.
struct Asked {
  Model arm;
  std::vector<std::string> columns;  // ten columns of each place, then the friction of the joints
  // Indices of a joint's columns of offset, Coulomb and viscous friction.
  std::vector<std::vector<int>> friction;
};

// @param places  indices of the frames that may carry a load.
Asked arm_with_unknown_loads(const Model& model, const std::vector<int>& places) {
  ModelDescription d = with_fixed_parameters(model).description();
  const size_t bodies = model.bodies().size(), effects = d.effects.size();
  for (const int place : places) {
    Frame load;
    load.name = std::string(AddedLoad::kName) + "@" + model.frames()[place].name;
    load.parent = FrameIndex{place};
    load.variable.coefficients = VectorXd::Zero(model.joints());
    load.body = Body{};
    load.body->phi = InertialParameters::Zero();
    d.frames.push_back(std::move(load));
  }
  for (int i = 0; i < model.joints(); ++i) {
    for (const char* effect : {kPlainOffset, kPlainCoulomb, kPlainViscous}) {
      EffectTerm term;
      term.effect = effect;
      term.axis = {VectorXd::Unit(model.joints(), i), 0.0};
      // The change of an effect has the same smoothness as the effect itself.
      for (const EffectTerm& own : model.effects())
        if (own.effect == effect && own.axis.coefficients == term.axis.coefficients) term.values = own.values;
      for (const EffectParameter& p : find_effect(effect).parameters()) term.values.erase(p.name);
      d.effects.push_back(std::move(term));
    }
  }
  Asked out{Model(std::move(d)), {}, std::vector<std::vector<int>>(static_cast<size_t>(model.joints()))};
  for (const StandardParameter& p : standard_parameters(out.arm)) {
    const bool load = p.body && *p.body >= static_cast<int>(bodies);
    if (p.effect && *p.effect >= static_cast<int>(effects))
      out.friction[static_cast<size_t>((*p.effect - static_cast<int>(effects)) / 3)].push_back(static_cast<int>(out.columns.size()));
    else if (!load)
      continue;
    out.columns.push_back(p.name);
  }
  return out;
}

// Fits one load together with changes of friction.
class LoadFit {
 public:
  // @param sample  rows for one independent sample. @param band  (n) of dry friction of unknown direction.
  // @param error  (n) of the model as it is; NaN: a joint without torque.
  LoadFit(const Model& model, const LoadRows& rows, const Asked& asked, int place, int first, double sample, const VectorXd& band, const VectorXd& error)
      : model_(model), rows_(rows), place_(place), first_(first), reach_(model.description().box.com_reach) {
    if (!(reach_ > 0.0)) reach_ = kReach;
    sets_.emplace_back();
    for (size_t kind = 0; kind < asked.friction.front().size(); ++kind) {
      std::vector<int> next = sets_.back();
      for (int i = 0; i < model.joints(); ++i)
        if (model.moves({place}, {i})) next.push_back(asked.friction[static_cast<size_t>(i)][kind]);
      sets_.push_back(std::move(next));
    }
    weights_ = weights(sample, band, error);
  }

  // True if the load has a torque in these rows.
  bool is_observable() const {
    double load = 0.0, all = 0.0;
    for (const RowSquares& joint : rows_.total()) {
      load += joint.AA.diagonal().segment(first_, kBodyParameters).sum();
      all += joint.AA.diagonal().sum();
    }
    return load > kFelt * all;
  }

  // The best load with intervals and held-out errors; without a mass if no load lowers the error.
  PayloadEstimate estimate() const {
    PayloadEstimate out;
    out.frame = model_.frames()[place_].name;
    const MassCost whole = cost(sets_.back(), nullptr);
    const PlacedMass best = whole.fit();
    if (best.mass == 0.0) return out;
    out.phi = best.phi();
    out.mass = best.mass;
    out.com = best.com;
    out.moment = best.mass * best.com;
    out.seen = whole.determined_axes(best);
    out.at_bound = whole.at_bound(best);
    set_intervals(whole, best, out);
    set_held_out_errors(best, out);
    const InertialParameters none = InertialParameters::Zero();
    const VectorXd drift = remaining_squares(rows_.total(), nullptr, none), with = remaining_squares(rows_.total(), nullptr, best.phi());
    VectorXd before(model_.joints());
    for (int i = 0; i < model_.joints(); ++i) before[i] = std::max(rows_.total()[static_cast<size_t>(i)].bb, numerics::kTiny);
    out.explained = weights_.dot(drift) > 0.0 ? 1.0 - weights_.dot(with) / weights_.dot(drift) : 0.0;
    out.error_with_drift = (drift.array() / before.array()).sqrt();
    out.error_with_load = (with.array() / before.array()).sqrt();
    return out;
  }

 private:
  MassCost cost(const std::vector<int>& beside, const std::vector<RowSquares>* without) const {
    return load_cost(rows_.total(), without, weights_, first_, beside, reach_);
  }

  // Squared residuals on `rows` of a load, with the friction that was fitted to all rows but `without`.
  VectorXd remaining_squares(const std::vector<RowSquares>& rows, const std::vector<RowSquares>* without, const InertialParameters& phi) const {
    const VectorXd beside = fitted_beside_load(rows_.total(), without, weights_, first_, sets_.back(), phi);
    return residual_squares(rows, first_, phi, sets_.back(), beside);
  }

  // Weight of each joint's rows: 1 / variance of an independent sample.
  VectorXd weights(double sample, const VectorXd& band, const VectorXd& error) const {
    std::vector<int> all = sets_.back();
    for (int c = 0; c < kBodyParameters; ++c) all.push_back(first_ + c);
    VectorXd out = VectorXd::Zero(model_.joints());
    for (int i = 0; i < model_.joints(); ++i) {
      const RowSquares& joint = rows_.total()[static_cast<size_t>(i)];
      if (!(joint.bb > 0.0) || !(joint.rows > 0.0) || std::isnan(error[i])) continue;
      const VectorXd b = joint.Ab(all);
      const double unexplained = std::max(joint.bb - b.dot(VectorXd(solve_scaled(joint.AA(all, all), b))), numerics::kNoise * joint.bb);
      out[i] = 1.0 / (sample * (unexplained / joint.rows + band[i] * band[i] / kUniform));
    }
    return out;
  }

  void set_intervals(const MassCost& whole, const PlacedMass& best, PayloadEstimate& out) const {
    using Numbers = Eigen::Matrix<double, 13, 1>;
    const auto numbers = [](const MassCost& f, const PlacedMass& s) {
      Numbers v;
      v << s.mass, s.com, s.mass * s.com, f.inertia_beyond_point_mass(s);
      return v;
    };
    const Numbers centre = numbers(whole, best);
    out.inertia = centre.tail<6>();
    // Scatter between phases (jackknife), and between the alternative sets of friction changes.
    const int clusters = rows_.clusters();
    Numbers sum = Numbers::Zero(), squares = Numbers::Zero();
    for (int k = 0; k < clusters; ++k) {
      const MassCost f = cost(sets_.back(), &rows_.cluster(k));
      const Numbers one = numbers(f, f.fit(best)) - centre;
      sum += one;
      squares += one.cwiseAbs2();
    }
    const double count = std::max(1, clusters);
    Numbers variance = (count - 1.0) / count * (squares - sum.cwiseAbs2() / count).cwiseMax(0.0);
    Numbers drift = Numbers::Zero();
    for (size_t k = 0; k + 1 < sets_.size(); ++k) {
      const MassCost f = cost(sets_[k], nullptr);
      drift = drift.cwiseMax((numbers(f, f.fit(best)) - centre).cwiseAbs());
    }
    // Never narrower than independent samples allow.
    const Eigen::Matrix4d least = whole.covariance(best);
    variance.head<4>() = variance.head<4>().cwiseMax(least.diagonal());
    const double t = student_t_quantile(kOutside, std::max(1, clusters - 1));
    const Numbers half = (t * t * variance + drift.cwiseAbs2()).cwiseSqrt();
    // Mass and lever can compensate each other: the interval follows the valley of the cost, up to the height
    // that corresponds to its width at the minimum.
    const double height = half[0] * half[0] / std::max(least(0, 0), numerics::kTiny);
    std::tie(out.mass_low, out.mass_high) = whole.masses_below(best.cost + height, best);
    out.mass_low = std::min(out.mass_low, out.mass - half[0] < 0.0 && out.mass > 0.0 ? 0.0 : out.mass_low);
    out.com_half_width = half.segment<3>(1);
    out.moment_half_width = half.segment<3>(4);
    out.inertia_half_width = half.tail<6>();
    for (int k = 0; k < 3; ++k) {
      if (out.seen[static_cast<size_t>(k)]) continue;
      out.com_half_width[k] = reach_;
      out.moment_half_width[k] = std::max(std::abs(out.mass_low), std::abs(out.mass_high)) * reach_;
    }
  }

  // Decrease of the error on rows to which neither the load nor the changes of friction were fitted.
  void set_held_out_errors(const PlacedMass& best, PayloadEstimate& out) const {
    const InertialParameters none = InertialParameters::Zero();
    VectorXd with = VectorXd::Zero(model_.joints()), before = with;
    for (int k = 0; k < rows_.clusters(); ++k) {
      const std::vector<RowSquares>& part = rows_.cluster(k);
      with += remaining_squares(part, &part, cost(sets_.back(), &part).fit(best).phi());
      before += remaining_squares(part, &part, none);
    }
    for (int i = 0; i < model_.joints(); ++i)
      if (weights_[i] > 0.0 && with[i] > 0.0 && before[i] > 0.0 && model_.moves({place_}, {i})) out.gain += std::log(before[i] / with[i]);
  }

  const Model& model_;
  const LoadRows& rows_;
  int place_, first_;
  double reach_;
  std::vector<std::vector<int>> sets_;  // sets of increasing size; the first is empty
  VectorXd weights_;
};

// True if the columns of two loads span the same torques.
bool same_torques(const LoadRows& rows, int a, int b) {
  MatrixXd AA = MatrixXd::Zero(kBodyParameters, kBodyParameters), AB = AA, BB = AA;
  for (const RowSquares& joint : rows.total()) {
    AA += joint.AA.block(a, a, kBodyParameters, kBodyParameters);
    AB += joint.AA.block(a, b, kBodyParameters, kBodyParameters);
    BB += joint.AA.block(b, b, kBodyParameters, kBodyParameters);
  }
  const VectorXd spanned = (AB.transpose() * solve_scaled(AA, AB)).diagonal();
  return ((BB.diagonal() - spanned).array() <= kSameSpan * BB.diagonal().array() + numerics::kTiny).all();
}

// Sorts the links by gain. Where gains tie, as in a diagnosis, the link that is nearest to the load comes first, because a
// load on a joint's axis may be carried by either of the links that the joint connects.
void sort_by_gain(double tie, std::vector<PayloadEstimate>& links) {
  std::stable_sort(links.begin(), links.end(), [](const auto& a, const auto& b) { return a.gain > b.gain; });
  if (links.empty()) return;
  const double least = tie * links.front().gain;
  const auto tied = std::find_if(links.begin(), links.end(), [&](const PayloadEstimate& l) { return !(l.gain > least); });
  const auto nearest = std::min_element(links.begin(), tied, [](const auto& a, const auto& b) { return a.com.norm() < b.com.norm(); });
  if (tied != links.begin()) std::rotate(links.begin(), nearest, std::next(nearest));
}

// True if what a load leaves of a joint's torque is above the model's error in its own training.
// @param band  dry friction of unknown direction, relative.
bool is_unexplained(const Model& model, int joint, double left, double band) {
  const auto& own = model.description().identified;
  const double usual = own && own->error.size() == model.joints() ? kOfOwnError * own->error[joint] : kErrorOfDrawing;
  return left > std::max(usual, kOfOwnError * band);
}

// Mass of the bodies of one link [kg]: of the prior if there is one, since torques alone determine no masses.
double mass_on(const Model& model, const std::string& frame) {
  const std::optional<FrameIndex> own = moving_frame(model, model.find_frame(frame));
  double drawn = 0.0, valued = 0.0;
  for (const FrameIndex k : model.bodies()) {
    if (moving_frame(model, k) != own) continue;
    const Body& body = *model.frames()[k.value].body;
    valued += body.phi ? (*body.phi)[0] : 0.0;
    drawn += body.prior ? (*body.prior)[0] : 0.0;
  }
  return drawn > 0.0 ? drawn : valued;
}

struct Question {
  const Model& model;
  const std::string& link;
  const Thresholds& limits;
  const VectorXd& band;  // (n) dry friction of unknown direction
};

// Names the joints that a load leaves unexplained: those that it acts on, and with --link the others.
void note_unexplained(const Question& q, const VectorXd& band, PayloadReport& out) {
  std::string elsewhere;
  for (PayloadEstimate& link : out.links) {
    for (int i = 0; i < q.model.joints(); ++i) {
      const double left = out.error_before[i] * link.error_with_load[i];
      if (!is_unexplained(q.model, i, left, band[i])) continue;
      const std::string& joint = q.model.coordinates()[i].name;
      if (q.model.moves(*q.model.find_frame(link.frame), {i})) link.unexplained.push_back(joint);
      else if (!q.link.empty()) elsewhere += fmt::format("{}{} ({:.2g} %)", elsewhere.empty() ? "" : ", ", joint, numerics::kPercent * left);
    }
  }
  if (!elsewhere.empty())
    out.remarks.push_back("No load on " + q.link + " acts on joints whose torque the model does not explain: " + elsewhere +
                          ". The load may be on another link, or there is another cause");
}

// One factor of all torques that explains the recordings as well as the best load does, over all joints; 0: none does.
double factor_of_torques(const Identification& start, const PayloadEstimate& load, double tie) {
  const auto joints = static_cast<size_t>(start.train_error.relative.size());
  std::vector<double> squares(joints), product(joints), predicted(joints);
  for (const RecordingError& r : start.train) {
    for (size_t i = 0; i < joints; ++i) {
      for (size_t k = 0; k < r.series.measured[i].size(); ++k) {
        const double tau = r.series.measured[i][k], model = r.series.modelled[i][k];
        if (!std::isfinite(tau) || !std::isfinite(model)) continue;
        squares[i] += tau * tau;
        product[i] += tau * model;
        predicted[i] += model * model;
      }
    }
  }
  double above = 0.0, below = 0.0;
  for (size_t i = 0; i < joints; ++i) {
    if (!(squares[i] > 0.0) || !std::isfinite(start.train_error.relative[static_cast<Eigen::Index>(i)])) continue;
    above += product[i] / squares[i];
    below += predicted[i] / squares[i];
  }
  if (!(below > 0.0)) return 0.0;
  const double factor = above / below;
  double by_factor = 0.0, by_load = 0.0;  // fall of the sum of ln(mean square residual)
  for (size_t i = 0; i < joints; ++i) {
    const double before = squares[i] - 2.0 * product[i] + predicted[i], with = squares[i] - factor * (2.0 * product[i] - factor * predicted[i]);
    const double ratio = load.error_with_load[static_cast<Eigen::Index>(i)];
    if (!(before > 0.0) || !(with > 0.0) || !(ratio > 0.0) || !std::isfinite(start.train_error.relative[static_cast<Eigen::Index>(i)])) continue;
    by_factor += std::log(before / with);
    by_load -= 2.0 * std::log(ratio);
  }
  return by_factor > 0.0 && by_factor >= tie * by_load ? factor : 0.0;
}

// Band of dry friction relative to the torque of each joint at rest. A joint without torque has no error.
VectorXd share_of_band(const VectorXd& band, const Identification& start, VectorXd& error) {
  VectorXd torque2 = VectorXd::Zero(band.size()), out = torque2;
  double poses = 0.0;
  for (const RecordingError& r : start.train) {
    poses += static_cast<double>(r.series.time.size());
    for (Eigen::Index i = 0; i < band.size(); ++i)
      for (const double tau : r.series.measured[i]) torque2[i] += tau * tau;
  }
  for (Eigen::Index i = 0; i < band.size(); ++i) {
    if (torque2[i] > kNoGravity * torque2.maxCoeff()) out[i] = band[i] / std::sqrt(torque2[i] / std::max(1.0, poses));
    else error[i] = kNaN;
  }
  return out;
}

// Fits a load on every link to rows of the arm of arm_with_unknown_loads().
// @param share  (n) band of dry friction, relative to each joint's torque.
void fit_loads(const Question& q, const Asked& asked, const std::vector<int>& places, const std::vector<CompressedRecording>& recordings,
               double sample, const VectorXd& band, const VectorXd& share, PayloadReport& out) {
  const LoadRows rows(recordings, asked.columns, q.model.joints());
  std::vector<int> firsts;
  for (size_t k = 0; k < places.size(); ++k) {
    const int first = static_cast<int>(kBodyParameters * k);
    const std::string& name = q.model.frames()[places[k]].name;
    const LoadFit fit(q.model, rows, asked, places[k], first, sample, band, out.error_before);
    if (!fit.is_observable()) continue;
    const auto twin = std::find_if(firsts.begin(), firsts.end(), [&](int other) { return same_torques(rows, other, first); });
    if (twin != firsts.end()) {
      out.links[static_cast<size_t>(twin - firsts.begin())].others.push_back(name);
      continue;
    }
    firsts.push_back(first);
    out.links.push_back(fit.estimate());
  }
  out.links.erase(std::remove_if(out.links.begin(), out.links.end(), [](const PayloadEstimate& l) { return l.mass == 0.0; }), out.links.end());
  for (PayloadEstimate& link : out.links) link.most_off = mass_on(q.model, link.frame);
  note_unexplained(q, share, out);
  sort_by_gain(q.limits.tie, out.links);
  if (out.links.empty()) {
    out.reason = "no link moves enough in these recordings to feel a load";
    return;
  }
  out.error_with_drift = out.error_before.cwiseProduct(out.links.front().error_with_drift);
  out.error_after = out.error_before.cwiseProduct(out.links.front().error_with_load);
}

// The report for an arm whose values are all known.
PayloadReport payload_report(const Question& q, const std::string& robot, const std::vector<std::string>& recordings,
                      IdentificationOptions options) {
  PayloadReport out;
  out.smallest_gain = q.limits.smallest_change;
  out.robot = robot;
  exclude_wrong_velocities(q.model, recordings, {}, options);
  options.choose_velocities = false;
  Identification start = evaluate(q.model, recordings, {}, options);
  if (!start.model) {
    out.reason = start.reason;
    return out;
  }
  const std::vector<ExcludedInterval> rows = silent_rows(start.factors);
  if (!rows.empty()) {
    std::vector<ExcludedInterval>& left_out = options.preprocessing.excluded_intervals;
    left_out.insert(left_out.end(), rows.begin(), rows.end());
    start = evaluate(q.model, recordings, {}, options);
  }
  out.error_before = start.train_error.relative;
  const std::vector<int> places = places_of(q.model, q.link);
  const Asked asked = arm_with_unknown_loads(q.model, places);
  const VectorXd none = VectorXd::Zero(q.model.joints());
  if (are_poses(options.preprocessing, recordings)) {
    fit_loads(q, asked, places, compress_all(asked.arm, recordings, options.preprocessing, options.threads), 1.0, q.band, share_of_band(q.band, start, out.error_before), out);
    return out;
  }
  std::vector<CompressedRecording> factors = compress_all(asked.arm, recordings, options.preprocessing, options.threads);
  for (CompressedRecording& one : factors) merge_blocks(one, std::max(1, kMostClusters / static_cast<int>(factors.size())));
  fit_loads(q, asked, places, factors, kRowsPerSample, none, none, out);
  if (!out.links.empty()) out.torque_factor = factor_of_torques(start, out.links.front(), q.limits.tie);
  return out;
}

// Adds a remark on what poses at rest cannot determine about a load.
void remark_on_poses(const Model& model, double poses, const VectorXd& band, bool approached, PayloadReport& out) {
  if (poses < kPosesPerUnknown * kUnknowns) {
    for (PayloadEstimate& one : out.links) one.gain = kNaN;
    out.remarks.push_back(fmt::format("Nothing is held out, for that takes {} poses, twice as many as a load has numbers (mass and centre), and {}", kPosesPerUnknown * kUnknowns, poses == 1.0 ? "this is one" : fmt::format("these are {}", poses)));
  }
  std::string bands;
  for (int i = 0; i < model.joints(); ++i) {
    if (band[i] > 0.0) bands += fmt::format("{}{} {:.2g} {}", bands.empty() ? "" : ", ", model.coordinates()[i].name, band[i], effort_unit(model.coordinates()[i]));
  }
  if (!bands.empty())
    out.remarks.push_back("Dry friction holds a resting joint anywhere within a band, and the intervals count it: " + bands +
                          " on either side. --approach, or columns dq1.. of -1, 0 and 1, tell the side");
  else if (!approached)
    out.remarks.push_back("The model has no dry friction, which holds a resting joint anywhere within a band: the intervals know of it "
                          "only by the scatter of the poses");
}

// A torque that looks like a load may also come from wrong values of the model.
void remark_on_values(const Model& model, PayloadReport& out) {
  if (model.description().values == RobotValues::kPrior && !model.description().identified)
    out.remarks.push_back("The values of '" + model.name() + "' are those of its drawing, not measured on this arm: what they lack "
                          "counts as load. `identify` on recordings without the load gives a MODEL to compare with");
}

}  // namespace

PayloadReport find_payload(const Model& given_model, const Recordings& loaded,
                           const IdentificationOptions& given, const std::string& link,
                           const Thresholds& limits) {
  const auto begin = std::chrono::steady_clock::now();
  require(given_model.inertial_values().has_value(), "payload: robot '", given_model.name(),
          "' has no values; expected a MODEL that identify or diagnose wrote, or bodies of a CAD model.");
  NamedRecordings<IdentificationOptions> named(loaded, {}, given);
  keep_recordings(named.how, KeptRecordings::kManyQuestions);
  const std::vector<std::string>& recordings = named.train;
  const bool approached = named.poses && is_approached(named.how.preprocessing, recordings);
  const Model model = named.poses ? with_effects_at_rest(given_model, approached) : given_model;
  // Dry friction of unknown direction.
  const VectorXd band = named.poses && !approached ? dry_friction(given_model) : VectorXd(VectorXd::Zero(model.joints()));
  PayloadReport out;
  if (has_all_values(model)) {
    out = payload_report({model, link, limits, band}, model.name(), recordings, named.how);
  } else {
    // Alternates between friction and load, because friction that is fitted without the load absorbs a part
    // of it.
    Model cad = with_fitted_effects(model, recordings, named.how);
    for (int turn = 0; turn < kTurns; ++turn) {
      out = payload_report({cad, link, limits, band}, model.name(), recordings, named.how);
      if (out.links.empty() || turn + 1 == kTurns) break;
      const Model loaded_arm = with_fitted_effects(with_load(model, out.links.front()), recordings, named.how);
      cad = with_effects_of(cad, loaded_arm);
    }
  }
  double poses = 0.0;
  for (const std::string& name : recordings) poses += named.poses ? find_in_memory(named.how.preprocessing.in_memory, name)->rows() : 0.0;
  if (named.poses) remark_on_poses(model, poses, band, approached, out);
  remark_on_values(given_model, out);
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return out;
}

namespace {

// True if the search ended at a bound of the centre or of the mass.
bool at_end(const PayloadEstimate& load) { return load.at_bound || std::abs(load.mass) >= kAtEnd * kHeaviestLoad; }

// Interval of the mass in words; empty if the search ended at its bound.
std::string mass_interval_text(const PayloadEstimate& load) {
  if (std::max(-load.mass_low, load.mass_high) >= kAtEnd * kHeaviestLoad) return "-";
  if (load.mass_low == 0.0 && load.mass_high > 0.0) return fmt::format("below {:.4g}", load.mass_high);
  if (load.mass_high == 0.0 && load.mass_low < 0.0) return fmt::format("above {:.4g}", load.mass_low);
  return fmt::format("{:.4g} to {:.4g}", load.mass_low, load.mass_high);
}

}  // namespace

bool PayloadEstimate::has_mass() const {
  const bool excludes_zero = mass_low > 0.0 || mass_high < 0.0;
  return excludes_zero && !at_end(*this) && mass_high - mass_low <= kWidestMass * std::abs(mass);
}

bool PayloadReport::found() const {
  if (links.empty() || links.front().gain < smallest_gain || torque_factor != 0.0) return false;
  const PayloadEstimate& best = links.front();
  if (at_end(best) || !best.unexplained.empty() || best.mass_high < -best.most_off) return false;
  const bool has_moment = (best.moment.cwiseAbs() - best.moment_half_width).maxCoeff() > 0.0;
  return best.has_mass() || has_moment;
}

std::string PayloadReport::headline() const {
  if (links.empty()) return robot + ": no payload: " + reason;
  const PayloadEstimate& best = links.front();
  if (found() && best.has_mass())
    return fmt::format("{}: a load of {:.3g} kg on {} (95 %: {:.3g} to {:.3g} kg)", robot, best.mass, best.frame, best.mass_low, best.mass_high);
  if (found())
    return fmt::format("{}: a load with a moment of {:.3g} kg m on {}, whose mass these recordings do not tell", robot, best.moment.norm(), best.frame);
  std::string why;
  const bool gains = !(best.gain < smallest_gain);
  if (gains && torque_factor != 0.0) {
    why = fmt::format(": torques that are {:.3g} times the model's on every joint explain as much; `check` and `diagnose` ask for other causes", torque_factor);
  } else if (gains && !best.unexplained.empty()) {
    why = fmt::format(": with the best one, on {}, {} explained; `diagnose` asks for other causes", best.frame,
                      listed(best.unexplained) + (best.unexplained.size() == 1 ? " is not" : " are not"));
  } else if (gains && best.mass_high < -best.most_off) {
    why = fmt::format(": the best one would take {:.3g} kg off {}, which has {:.3g} kg; `diagnose` asks for other causes", -best.mass, best.frame, best.most_off);
  } else if (gains && at_end(best)) {
    why = ": the best one, on " + best.frame + ", lies at the end of what was searched";
  }
  return robot + ": no load that these recordings could be sure of" + why;
}

std::string PayloadReport::report() const {
  std::string out = headline() + "\n";
  if (links.empty()) return out;
  for (const std::string& remark : remarks) out += "  " + remark + ".\n";
  out += fmt::format("  {:<22}{:>14}  {:<21}{:>8}{:>8}{:>8}  {:>9}{:>10}\n", "if it is on", "mass kg", "  95 %", "x m", "y m", "z m", "explains", "held out");
  for (const PayloadEstimate& link : links) {
    const bool is_determined = link.has_mass();
    std::string centre;
    for (size_t c = 0; c < link.seen.size(); ++c)
      centre += is_determined && link.seen[c] ? fmt::format("{:>8.3f}", link.com[static_cast<Eigen::Index>(c)]) : fmt::format("{:>8}", "-");
    out += fmt::format("  {:<22}{:>14}  {:<21}{}  {:>7.1f} %{:>10}\n", link.frame, is_determined ? fmt::format("{:.4g}", link.mass) : "not determined",
                       mass_interval_text(link), centre, numerics::kPercent * std::max(0.0, link.explained),
                       std::isnan(link.gain) ? "-" : fmt::format("{:.3f}", link.gain == 0.0 ? 0.0 : link.gain));
    for (const std::string& other : link.others)
      out += fmt::format("    or on {}: it moves so alike that the torques cannot tell\n", other);
  }
  if (!std::isnan(links.front().gain))
    out += "in the order of held out: how much smaller the logarithm of the squared errors is, over all "
         "joints, on rows that the load was not fitted to; of a tie the link nearest to the load comes first\n";
  const auto line = [&out](const char* name, const VectorXd& v) {
    out += fmt::format("  {:<22}", name);
    for (Eigen::Index i = 0; i < v.size(); ++i) out += in_percent(v[i], kNumberWidth);
    out += "\n";
  };
  out += "errors, % of the torque, per joint\n";
  line("the model as it is", error_before);
  line("friction, offset anew", error_with_drift);
  line("and the load", error_after);
  return out;
}

}  // namespace veridyn
