#include "veridyn/identification/drive_gains.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "identification/identification_numbers.hpp"
#include "identification/drive_gains/gain_fit.hpp"
#include "math/numbers.hpp"
#include "veridyn/math/require.hpp"
#include "math/student_t.hpp"
#include "model/suggestion.hpp"

namespace veridyn {
namespace {

// For every recording the index of its load, or -1. Loads that name no recording are skipped.
std::vector<int> named_loads(const std::vector<std::string>& recordings,
                             const std::vector<KnownMass>& loads) {
  std::vector<int> out(recordings.size(), -1);
  for (size_t l = 0; l < loads.size(); ++l) {
    for (const std::string& name : loads[l].recordings) {
      bool found = false;
      for (size_t r = 0; r < recordings.size(); ++r) {
        if (recordings[r] != name && std::filesystem::path(recordings[r]).filename().string() != name) continue;
        require(out[r] < 0 || out[r] == static_cast<int>(l), name,
                ": found two known masses for this recording, expected one.");
        out[r] = static_cast<int>(l);
        found = true;
      }
      require(found, "known mass on ", loads[l].frame, ": found the recording '", name, "'",
              did_you_mean(name, recordings), ", expected one of: ", listed(recordings), ".");
    }
  }
  return out;
}

void check(const Model& arm, const std::vector<std::string>& recordings,
           const std::vector<KnownMass>& loads) {
  require(!loads.empty(), "known mass: found none, expected one at least.");
  std::vector<std::string> frames;
  for (const Frame& frame : arm.frames()) frames.push_back(frame.name);
  for (const KnownMass& load : loads) {
    require(load.mass > 0.0 && std::isfinite(load.mass), "known mass: found ", load.mass,
            " kg, expected a mass above 0.");
    require(arm.find_frame(load.frame).has_value(), "known mass: found the frame '", load.frame, "'",
            did_you_mean(load.frame, frames), ", expected one of robot '", arm.name(),
            "': ", listed(frames), ".");
    require(!load.recordings.empty() || loads.size() == 1,
            "known mass: found several without recordings, expected KG@FRAME=REC,REC for each.");
  }
  require(recordings.size() > 1, "known mass: found ", recordings.empty() ? "no" : "one",
          " recording, expected one at least with the load and one without.");
}

std::string reason_against_gain(const DriveGain& gain, bool feels_weight) {
  if (!std::isfinite(gain.deviation))
    return "nothing ties its currents to the known mass, for it shares no parameters with joints "
           "that feel it";
  if (gain.share < identifying::numbers.unloaded)
    return "the known mass does not act on it, and what it shares with other joints tells too "
           "little";
  const std::string share = fmt::format("{:.2g} % of its torque", 100.0 * gain.share);
  if (!feels_weight) {
    return "its axis feels no weight: the known mass tells of it by inertia alone, which makes " +
           share;
  }
  return "too little tells it apart from other parameters; the known mass makes " + share;
}

DriveGain gain_of(const Coordinate& coordinate, double p, double deviation, double t) {
  DriveGain out;
  out.coordinate = coordinate.name;
  out.in_file = coordinate.drive_gain;
  out.unit = coordinate.prismatic ? "N/A" : "N m/A";
  out.value = 1.0 / p;
  out.deviation = deviation / (p * p);
  const double low = p - t * deviation;
  const double high = p + t * deviation;
  const bool one_sign = std::isfinite(deviation) && low * high > 0.0;
  out.low = one_sign ? 1.0 / high : -kInfinity;
  out.high = one_sign ? 1.0 / low : kInfinity;
  out.identifiable = one_sign && t * deviation < identifying::numbers.identifiable * std::abs(p);
  return out;
}

// Computes the centre of a load from its first moments, if these are identifiable on their own.
void find_centre(const GainFit& fit, int load, MountedLoad& mounted) {
  const std::vector<std::string> names = GainData::load_columns(load);
  const std::vector<std::string>& unknown = fit.columns.unknown;
  Eigen::Vector3d centre;
  for (int i = 0; i < 3; ++i) {
    const std::string& name = names[i + 1];
    const std::vector<std::string>& alone = fit.columns.alone;
    if (std::find(alone.begin(), alone.end(), name) == alone.end()) return;
    const auto at = std::find(unknown.begin(), unknown.end(), name) - unknown.begin();
    centre[i] = fit.solution.y[at] / (fit.solution.scale * mounted.known.mass);
    mounted.centre_deviation[i] = fit.deviation[at] / mounted.known.mass;
  }
  mounted.centre = centre;
}

// Reason why no gain is determined, or empty.
std::string problem_of(const GainFit& fit) {
  const VectorXd p = fit.solution.p();
  double best = 0.0;
  for (Eigen::Index j = 0; j < fit.joints(); ++j)
    best = std::max(best, std::abs(p[j]) / std::max(fit.p_deviation(j), 1e-300));
  if (fit.clusters < identifying::numbers.fewest_clusters || best < identifying::numbers.heavier)
    return "the recordings do not show the known mass: no joint's current differs enough";
  if (direction(fit) >= 0.0) return "";
  return "currents grow where the load is taken off: it is in the other recordings, or they count "
         "the other way round";
}

DriveGains gains_with_data(const Model& arm, const std::vector<std::string>& recordings,
                     const std::vector<KnownMass>& loads, const GainData& data,
                     const GainFit& fit) {
  DriveGains out;
  out.clusters = fit.clusters;
  out.problem = problem_of(fit);
  const double t = student_t_quantile(identifying::kOutside, std::max(1, out.clusters - 1));
  VectorXd weight = VectorXd::Zero(fit.joints());
  for (size_t l = 0; l < loads.size(); ++l) weight = weight.cwiseMax(data.weight_torque(static_cast<int>(l)));
  for (Eigen::Index j = 0; j < fit.joints(); ++j) {
    DriveGain gain = gain_of(arm.coordinates()[j], fit.solution.p()[j],
                             fit.p_deviation(j), t);
    gain.share = fit.mass_share[j];
    if (!gain.identifiable) gain.reason = reason_against_gain(gain, weight[j] > identifying::kNoWeight);
    out.joints.push_back(std::move(gain));
  }
  for (size_t l = 0; l < loads.size(); ++l) {
    MountedLoad mounted;
    mounted.known = loads[l];
    mounted.identified = loads[l].recordings.empty();
    mounted.known.recordings.clear();
    for (size_t r = 0; r < recordings.size(); ++r) {
      if (fit.loaded[r] && data.load_of(r) == static_cast<int>(l))
        mounted.known.recordings.push_back(recordings[r]);
    }
    find_centre(fit, static_cast<int>(l), mounted);
    out.loads.push_back(std::move(mounted));
  }
  for (size_t r = 0; r < recordings.size(); ++r) {
    if (!fit.loaded[r]) out.unloaded.push_back(recordings[r]);
  }
  return out;
}

}  // namespace

DriveGains find_drive_gains(const Model& arm, const std::vector<std::string>& recordings,
                            const std::vector<KnownMass>& loads,
                            const PreprocessingOptions& preprocessing, int threads) {
  check(arm, recordings, loads);
  const std::vector<int> load_of = named_loads(recordings, loads);
  const bool identified = loads.front().recordings.empty();
  require(!identified || static_cast<int>(recordings.size()) <= identifying::numbers.most_divisions, "known mass: found ",
          recordings.size(), " recordings, expected KG@FRAME=REC,REC that says which carry it.");
  std::vector<bool> loaded(recordings.size());
  std::vector<int> candidates = load_of;
  for (size_t r = 0; r < recordings.size(); ++r) {
    loaded[r] = load_of[r] >= 0;
    candidates[r] = std::max(load_of[r], 0);
  }
  require(identified || std::find(loaded.begin(), loaded.end(), false) != loaded.end(),
          "known mass: found a load in every recording, expected one at least without.");
  const GainData data(arm, recordings, loads, candidates, preprocessing, threads);
  const GainFit fit = identified ? best_division(data, loads) : fit_gains(data, loads, loaded);
  return gains_with_data(arm, recordings, loads, data, fit);
}

Model with_drive_gains(const Model& arm, const DriveGains& gains) {
  ModelDescription d = arm.description();
  d.identified.reset();
  for (size_t j = 0; j < gains.joints.size(); ++j) {
    if (!gains.joints[j].identifiable) continue;
    d.coordinates[j].drive_gain = gains.joints[j].value;
    d.coordinates[j].drive_gain_deviation = gains.joints[j].deviation;
  }
  return Model(std::move(d));
}

}  // namespace veridyn
