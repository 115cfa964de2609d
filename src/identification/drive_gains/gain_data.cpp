#include "identification/drive_gains/gain_data.hpp"

#include <algorithm>
#include <numeric>
#include <unordered_map>

#include "identification/identification_numbers.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/identification/base_parameters.hpp"
#include "math/parallel.hpp"
#include "math/random_numbers.hpp"
#include "recordings/kept_recordings.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

std::string load_frame_name(int load) {
  return text("known_load_", load);
}

// True for effects that are the same every day, unlike friction and offsets.
bool is_lasting(const std::string& effect) {
  return find_effect(effect).traits().lasting;
}

// The arm with currents as torques: unit gains, its known values as unknowns, and a body for the load.
Model arm_with_load(const Model& arm, const KnownMass& load, int index) {
  ModelDescription d = arm.description();
  for (Coordinate& c : d.coordinates) c.drive_gain = 1.0;
  for (Frame& frame : d.frames) {
    if (frame.body) frame.body->fixed = false;
  }
  for (EffectTerm& term : d.effects) term.fixed = false;
  Frame frame;
  frame.name = load_frame_name(index);
  frame.parent = arm.find_frame(load.frame);
  frame.body = Body{};
  if (arm.inertial_values()) {
    frame.body->phi = InertialParameters::Zero();
    (*frame.body->phi)[0] = load.mass;
  }
  d.frames.push_back(std::move(frame));
  return Model(std::move(d));
}

// A recording of currents alone. Throws InvalidInput if it has no currents, or torques beside them.
Recording currents_of(const Model& arm, const std::string& path,
                      const PreprocessingOptions& preprocessing) {
  const Recording* there = find_in_memory(preprocessing.in_memory, path);
  Recording r = there != nullptr ? *there
                                 : read_rows(path, recording_options_for(arm, preprocessing), preprocessing.kept.get());
  require(r.current.size() > 0, path, ": found no motor currents, expected columns i1..i",
          r.joints(), " to find drive gains from.");
  require(
      r.tau.size() == 0, path,
      ": found torques beside motor currents, expected currents alone to find drive gains from.");
  r.source = path;
  return r;
}

}  // namespace

GainData::GainData(const Model& arm, const std::vector<std::string>& recordings,
                   const std::vector<KnownMass>& loads, const std::vector<int>& load_of,
                   const PreprocessingOptions& preprocessing, int threads)
    : load_of_(load_of), loads_(loads), recordings_(recordings.size()) {
  for (const int load : load_of) {
    arms_.push_back(arm_with_load(arm, loads[load], load));
    std::vector<StandardParameter> parameters = standard_parameters(arms_.back());
    // Values that the file declares as known stay known.
    const std::vector<StandardParameter> own = standard_parameters(arm);
    for (StandardParameter& p : parameters) {
      const auto same = std::find_if(own.begin(), own.end(),
                                     [&p](const StandardParameter& o) { return o.name == p.name; });
      p.fixed = same != own.end() && same->fixed;
    }
    parameters_.push_back(std::move(parameters));
  }
  parallel_for(static_cast<int>(recordings.size()), threads, [&](int k) {
    const auto r = static_cast<size_t>(k);
    recordings_[r] = compress(arms_[r], currents_of(arms_[r], recordings[r], preprocessing), preprocessing);
    require(recordings_[r].rows > 0.0, recordings[r],
            ": found no usable samples after gaps, edges and row limits, expected some.");
  });
}

int GainData::cluster_count() const {
  size_t count = 0;
  for (const CompressedRecording& r : recordings_) count += r.blocks.size();
  return static_cast<int>(count);
}

size_t GainData::recording_of_cluster(size_t cluster) const {
  size_t recording = 0;
  while (cluster >= recordings_[recording].blocks.size())
    cluster -= recordings_[recording++].blocks.size();
  return recording;
}

std::vector<std::string> GainData::load_columns(int load) {
  std::vector<std::string> out;
  for (const char* symbol : {"m", "hx", "hy", "hz", "Lxx", "Lxy", "Lyy", "Lxz", "Lyz", "Lzz"})
    out.push_back(std::string(symbol) + "_" + load_frame_name(load));
  return out;
}

// Name of the column of a parameter: parameters that change from day to day have one for each recording.
std::string GainData::column_name(const StandardParameter& p, size_t recording) const {
  if (!p.effect || p.fixed) return p.name;
  const std::string& effect = arms_[recording].effects()[*p.effect].effect;
  return is_lasting(effect) ? p.name : text(p.name, " in recording ", recording + 1);
}

std::vector<std::vector<SquareRootInformation>> GainData::clusters(
    const std::vector<bool>& loaded) const {
  std::vector<std::vector<SquareRootInformation>> out;
  for (size_t r = 0; r < recordings_.size(); ++r) {
    std::unordered_map<std::string, std::string> renamed;
    for (const StandardParameter& p : parameters_[r]) renamed.emplace(p.name, column_name(p, r));
    const std::vector<std::string> of_load = load_columns(load_of_[r]);
    for (const auto& block : recordings_[r].blocks) {
      out.emplace_back();
      for (const SquareRootInformation& factor : block) {
        std::vector<std::string> kept, names;
        for (const std::string& name : factor.columns()) {
          const bool load = std::find(of_load.begin(), of_load.end(), name) != of_load.end();
          if (load && !loaded[r]) continue;
          kept.push_back(name);
          names.push_back(renamed.at(name));
        }
        const SquareRootInformation part = factor.restricted(kept);
        const auto count = static_cast<Eigen::Index>(kept.size());
        out.back().push_back(part.transformed(MatrixXd::Identity(count, count), names));
      }
    }
  }
  return out;
}

GainData::Columns GainData::columns(const std::vector<bool>& loaded) const {
  Columns out;
  SquareRootInformation structure;
  for (size_t r = 0; r < arms_.size(); ++r) {
    const SquareRootInformation states =
        random_state_factor(arms_[r], identifying::kStates, static_cast<unsigned>(r + 1));
    const std::vector<std::string> of_load = load_columns(load_of_[r]);
    std::vector<std::string> kept, names;
    for (const StandardParameter& p : parameters_[r]) {
      const bool load = std::find(of_load.begin(), of_load.end(), p.name) != of_load.end();
      if (load && !loaded[r]) continue;
      const std::string name = column_name(p, r);
      if (p.fixed) out.known[name] = p.value;
      if (p.name == of_load.front())
        out.known[name] = loads_[load_of_[r]].mass;
      if (out.known.count(name) > 0) continue;
      kept.push_back(p.name);
      names.push_back(name);
    }
    const auto count = static_cast<Eigen::Index>(kept.size());
    structure.merge(states.restricted(kept).transformed(MatrixXd::Identity(count, count), names));
  }
  // Gains do not depend on the choice of independent columns.
  std::vector<int> in_order(structure.size());
  std::iota(in_order.begin(), in_order.end(), 0);
  const BaseParameters base = base_parameters(structure, in_order);
  for (const int c : base.independent) {
    const std::string& name = structure.columns()[c];
    out.unknown.push_back(name);
    if (base.classes[c] == Identifiability::kAlone) out.alone.push_back(name);
  }
  return out;
}

VectorXd GainData::weight_torque(int load) const {
  const auto at = std::find(load_of_.begin(), load_of_.end(), load) - load_of_.begin();
  const Model& arm = arms_[at];
  const int n = arm.joints();
  const Eigen::Index mass =
      kBodyParameters * (static_cast<Eigen::Index>(arm.bodies().size()) - 1);  // the last body
  RandomNumbers random(1);
  VectorXd out = VectorXd::Zero(n);
  const VectorXd rest = VectorXd::Zero(n);
  for (int k = 0; k < identifying::kStates; ++k) {
    VectorXd q(n);
    for (double& value : q) value = random.uniform(-1.0, 1.0);
    out = out.cwiseMax(torque_regressor(arm, q, rest, rest).col(mass).cwiseAbs());
  }
  return out;
}

GainEquation gain_equation(const SquareRootInformation& factor, const GainData::Columns& columns) {
  std::unordered_map<std::string, Eigen::Index> index;
  for (int c = 0; c < factor.size(); ++c)
    index.emplace(factor.columns()[c], static_cast<Eigen::Index>(c));
  GainEquation out;
  out.U = MatrixXd::Zero(factor.size(), static_cast<Eigen::Index>(columns.unknown.size()));
  out.k = VectorXd::Zero(factor.size());
  const MatrixXd R = factor.R();
  for (size_t u = 0; u < columns.unknown.size(); ++u) {
    const auto found = index.find(columns.unknown[u]);
    if (found != index.end())
      out.U.col(u) = R.col(found->second);
  }
  for (const auto& [name, value] : columns.known) {
    const auto found = index.find(name);
    if (found != index.end()) out.k += value * R.col(found->second);
  }
  out.z = factor.z();
  out.rho2 = factor.rho2();
  out.rows = factor.rows();
  return out;
}

}  // namespace veridyn
