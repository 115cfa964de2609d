#include "dvrk/arms/gravity_chain.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "veridyn/math/random_numbers.hpp"
#include "veridyn/model/suggestion.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

constexpr int kFitted = 300;   // number of random configurations for the fit
constexpr int kJudged = 2000;  // number of other random configurations, which give the largest error
constexpr double kTolerance = 0.05;    // share of a joint's largest torque
constexpr double kIndependent = 1e-9;  // largest remainder of a dependent column, as a share of its length
constexpr double kNothing = 1e-12;     // [kg], [kg m] bound below which a value is rounding
constexpr double kNoTorque = 1e-9;     // [N m], [N] bound below which a value is rounding
constexpr double kCentreOffset = 0.1;  // [m] offset of a centre whose mass may be chosen
constexpr int kMoments = 4;            // moments of a link: hx, hy, hz, m
constexpr int kInBody[kMoments] = {1, 2, 3, 0};  // their indices in InertialParameters

// Correspondence of the model's coordinates and the rows of the chain.
struct JointMatch {
  std::vector<int> coordinates;
  std::vector<int> rows;
};

JointMatch match_joints(const Model& model, const Model& chain, const ArmFacts& arm) {
  JointMatch match;
  for (int k = 0; k < chain.joints(); ++k) {
    const std::optional<JointIndex> i = model.find_coordinate(chain.coordinates()[k].name);
    if (!i) continue;
    match.coordinates.push_back(i->value);
    match.rows.push_back(k);
  }
  std::vector<std::string> names;
  for (const Coordinate& c : chain.coordinates()) names.push_back(c.name);
  require(!match.rows.empty(), "model '", model.name(), "': found no coordinate of the ", arm.name,
          ", expected some of: ", listed(names), ".");
  return match;
}

// The arm's chain with a body in every link and gravity [m/s^2] along -z.
Model chain_with_bodies(const ArmFacts& arm, double gravity) {
  ModelDescription description = arm_model(arm).description();
  description.gravity = {0.0, 0.0, -gravity};
  for (Frame& frame : description.frames) frame.body = Body{};
  description.frames.back().body.reset();  // the tip
  return Model(description);
}

// Gravity torques of model and chain at random configurations within the limits of both.
struct Samples {
  MatrixXd Y;    // (samples * matched joints x 4 * joints of the chain)
  VectorXd tau;  // (samples * matched joints), sample by sample
};

class Sampler {
 public:
  Sampler(const Model& model, const Model& chain, const JointMatch& match)
      : model_(model), chain_(chain), match_(match) {}

  Samples draw(unsigned seed, int count) const {
    const auto n = static_cast<Eigen::Index>(match_.rows.size());
    Samples samples{MatrixXd(count * n, kMoments * chain_.joints()), VectorXd(count * n)};
    RandomNumbers random(seed);
    for (int s = 0; s < count; ++s) append_sample(random, s * n, samples);
    return samples;
  }

 private:
  // Fills the rows from `first` on with one random configuration.
  void append_sample(RandomNumbers& random, Eigen::Index first, Samples& samples) const {
    VectorXd q = VectorXd::Zero(model_.joints());
    VectorXd q_chain = VectorXd::Zero(chain_.joints());
    for (int i = 0; i < model_.joints(); ++i) {
      const Limits& limits = model_.coordinates()[i].limits;
      if (std::isfinite(limits.lower + limits.upper)) q[i] = 0.5 * (limits.lower + limits.upper);
    }
    for (std::size_t k = 0; k < match_.rows.size(); ++k) {
      const Limits& own = model_.coordinates()[match_.coordinates[k]].limits;
      const Limits& facts = chain_.coordinates()[match_.rows[k]].limits;
      const double lower = std::max(own.lower, facts.lower);
      const double upper = std::min(own.upper, facts.upper);
      const bool overlap = lower < upper;
      q_chain[match_.rows[k]] =
          random.uniform(overlap ? lower : facts.lower, overlap ? upper : facts.upper);
      q[match_.coordinates[k]] = q_chain[match_.rows[k]];
    }
    const VectorXd tau =
        inverse_dynamics(model_, q, VectorXd::Zero(q.size()), VectorXd::Zero(q.size()));
    const VectorXd rest = VectorXd::Zero(q_chain.size());
    const MatrixXd Y = torque_regressor(chain_, q_chain, rest, rest);
    for (std::size_t k = 0; k < match_.rows.size(); ++k) {
      const Eigen::Index row = first + static_cast<Eigen::Index>(k);
      samples.tau[row] = tau[match_.coordinates[k]];
      for (int b = 0; b < chain_.joints(); ++b)
        for (int c = 0; c < kMoments; ++c)
          samples.Y(row, kMoments * b + c) = Y(match_.rows[k], kBodyParameters * b + kInBody[c]);
    }
  }

  const Model& model_;
  const Model& chain_;
  const JointMatch& match_;
};

// Indices of the columns that do not depend on earlier ones: h of a link comes before its mass, earlier links
// before later ones.
std::vector<int> independent_columns(const MatrixXd& Y) {
  std::vector<int> independent;
  MatrixXd Q(Y.rows(), 0);
  const double longest = Y.colwise().norm().maxCoeff();
  for (int c = 0; c < Y.cols(); ++c) {
    VectorXd rest = Y.col(c);
    for (int pass = 0; pass < 2; ++pass) rest -= Q * (Q.transpose() * rest);
    if (rest.norm() <= kIndependent * std::max(Y.col(c).norm(), 1e-3 * longest)) continue;
    independent.push_back(c);
    Q.conservativeResize(Eigen::NoChange, Q.cols() + 1);
    Q.col(Q.cols() - 1) = rest.normalized();
  }
  return independent;
}

// Moments of all links: independent ones by least squares, the others from `chosen`.
VectorXd solve_moments(const Samples& samples, const std::vector<int>& independent, VectorXd chosen) {
  for (const int c : independent) chosen[c] = 0.0;
  MatrixXd Y(samples.Y.rows(), static_cast<Eigen::Index>(independent.size()));
  for (std::size_t k = 0; k < independent.size(); ++k)
    Y.col(k) = samples.Y.col(independent[k]);
  const VectorXd x = Y.colPivHouseholderQr().solve(samples.tau - samples.Y * chosen);
  for (std::size_t k = 0; k < independent.size(); ++k)
    chosen[independent[k]] = x[static_cast<Eigen::Index>(k)];
  return chosen;
}

// [kg m] Norm of a link's moment; 0 if it is rounding.
double moment_norm(const VectorXd& x, Eigen::Index row) {
  const double h = x.segment<3>(kMoments * row).norm();
  return h > kNothing ? h : 0.0;
}

// A link with a moment needs a mass. If torques do not determine it, it is chosen; if the chosen mass has an
// effect, the previous links compensate it, so that moments are solved for again.
VectorXd with_masses(const Samples& samples, const std::vector<int>& independent) {
  VectorXd x = solve_moments(samples, independent, VectorXd::Zero(samples.Y.cols()));
  for (int round = 0; round < 2; ++round) {
    for (Eigen::Index row = 0; row < x.size() / kMoments; ++row) {
      const int c = static_cast<int>(kMoments * row) + 3;
      if (std::find(independent.begin(), independent.end(), c) == independent.end())
        x[c] = moment_norm(x, row) / kCentreOffset;
    }
    x = solve_moments(samples, independent, x);
  }
  return x;
}

// Rows with masses and centres from the moments x of all links.
std::vector<GravityRow> gravity_rows(const ArmFacts& arm, const VectorXd& x) {
  std::vector<GravityRow> rows;
  for (const ArmJoint& joint : arm.joints) {
    if (!joint.dh) continue;
    GravityRow row;
    row.joint = joint.name;
    row.prismatic = joint.prismatic;
    row.dh = *joint.dh;
    const auto k = static_cast<Eigen::Index>(rows.size());
    row.mass = std::abs(x[kMoments * k + 3]) > kNothing ? x[kMoments * k + 3] : 0.0;
    if (moment_norm(x, k) > 0.0 && row.mass != 0.0) row.com = x.segment<3>(kMoments * k) / row.mass;
    rows.push_back(row);
  }
  return rows;
}

// Moments of all links of the given rows.
VectorXd moments_of(const std::vector<GravityRow>& rows) {
  VectorXd x(kMoments * static_cast<Eigen::Index>(rows.size()));
  for (std::size_t k = 0; k < rows.size(); ++k) {
    x.segment<3>(kMoments * static_cast<Eigen::Index>(k)) = rows[k].mass * rows[k].com;
    x[kMoments * static_cast<Eigen::Index>(k) + 3] = rows[k].mass;
  }
  return x;
}

// Largest magnitude of every joint, from values sample by sample.
VectorXd largest_per_joint(const VectorXd& values, std::size_t joints) {
  VectorXd largest = VectorXd::Zero(joints);
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    double& entry = largest[k % largest.size()];
    entry = std::max(entry, std::abs(values[k]));
  }
  return largest;
}

// Throws InvalidInput unless gravity is along -z.
void require_upright(const Model& model) {
  const Eigen::Vector3d& g = model.gravity();
  require(g.z() < 0.0 && std::hypot(g.x(), g.y()) <= 1e-3 * g.norm(), "model '", model.name(),
          "': found gravity [", g.x(), ", ", g.y(), ", ", g.z(),
          "], expected it along -z, as the dVRK's gravity compensation has it.");
}

// Names of effects other than gravity with a torque at rest.
std::vector<std::string> holding_effects(const Model& model) {
  std::vector<std::string> names;
  for (const EffectTerm& term : model.effects()) {
    if (term.values.empty() || !find_effect(term.effect).traits().holds_at_rest) continue;
    names.push_back(term.effect + "(" +
                    model.coordinates()[main_coordinate(term.axis).value].name +
                    ")");
  }
  return names;
}

}  // namespace

GravityChain fit_gravity_chain(const Model& model, const ArmFacts& arm) {
  require(arm.kind == "PSM" || arm.kind == "ECM", arm.name, ": found a ", arm.kind,
          ", expected a PSM or ECM: others have no gravity rows.");
  require(model.inertial_values().has_value(), "model '", model.name(),
          "': found bodies without values, expected an identified model.");
  require_upright(model);
  GravityChain result;
  result.arm = arm.name;
  result.gravity = model.gravity().norm();
  const Model chain = chain_with_bodies(arm, result.gravity);
  const JointMatch match = match_joints(model, chain, arm);
  const Sampler sampler(model, chain, match);
  const Samples samples = sampler.draw(1, kFitted);
  result.rows = gravity_rows(arm, with_masses(samples, independent_columns(samples.Y)));
  const Samples others = sampler.draw(2, kJudged);
  const VectorXd error = others.Y * moments_of(result.rows) - others.tau;
  result.largest_torque = largest_per_joint(others.tau, match.rows.size());
  result.largest_error = largest_per_joint(error, match.rows.size());
  result.left_out = holding_effects(model);
  for (std::size_t k = 0; k < match.rows.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    result.joints.push_back(model.coordinates()[match.coordinates[k]].name);
    require(result.largest_error[i] <= kTolerance * result.largest_torque[i] + kNoTorque, "model '",
            model.name(), "': gravity of ", result.joints.back(), " differs by ",
            result.largest_error[i], " of ", result.largest_torque[i], " from any chain of the ",
            arm.name, "'s links, expected at most 5 %.");
  }
  return result;
}

VectorXd gravity_torques(const GravityChain& chain, const VectorRef& q) {
  const auto n = static_cast<Eigen::Index>(chain.rows.size());
  require(q.size() == n, "gravity_torques: q has ", q.size(), " entries, expected ", n, ".");
  ArmFacts arm;
  arm.name = chain.arm;
  for (const GravityRow& row : chain.rows)
    arm.joints.push_back({row.joint, row.prismatic, row.dh, -1.0, 1.0, 0.0});
  const Model links = chain_with_bodies(arm, chain.gravity);
  VectorXd phi = VectorXd::Zero(kBodyParameters * n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const GravityRow& row = chain.rows[k];
    phi[kBodyParameters * k] = row.mass;
    phi.segment<3>(kBodyParameters * k + 1) = row.mass * row.com;
  }
  const VectorXd rest = VectorXd::Zero(n);
  return torque_regressor(links, q, rest, rest) * phi;
}

}  // namespace veridyn::dvrk
