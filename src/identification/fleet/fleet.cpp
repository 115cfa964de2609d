#include "veridyn/identification/fleet.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <sstream>
#include <system_error>
#include <utility>

#include "model/excerpt.hpp"
#include "identification/base_solution.hpp"
#include "identification/fleet/fleet_fit.hpp"
#include "identification/many_recordings.hpp"
#include "files/input_file.hpp"
#include "math/numbers.hpp"
#include "math/parallel.hpp"
#include "recordings/named_recordings.hpp"
#include "recordings/same_recording.hpp"
#include "identification/shortfall.hpp"
#include "identification/velocity_choice.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

ArmFactor arm_factor(const Model& arm, const FactorSet& set, const std::string& name) {
  ArmFactor out;
  out.name = name;
  out.still = still_joints(arm, set.recordings);
  out.recordings = static_cast<int>(set.recordings.size());
  for (const CompressedRecording& r : set.recordings) out.rows += r.rows;
  if (out.rows > 0.0) out.joints = joint_totals(set.recordings);
  return out;
}

void add_members(const FleetFit& fit, Fleet& fleet) {
  for (const FittedArm& f : fit.arms()) {
    FleetMember member{f.data.name, f.data.recordings, f.data.rows, f.values.head(f.independent.size()), {}, {}};
    for (Eigen::Index k = 0; k < member.own.size(); ++k)
      if (f.independent[k] < fleets::numbers.least_independent_share) member.own[k] = kNaN;
    member.own.tail(fleet.joints).array() += 1.0;  // gains are stored as factors
    VectorXd torque2(fleet.joints);
    for (int i = 0; i < fleet.joints; ++i) torque2[i] = std::max(1e-300, f.data.joints[i].rhs_norm2());
    member.relative_error = f.residual2.cwiseQuotient(torque2).cwiseSqrt();
    member.alone_error = f.alone2.cwiseQuotient(torque2).cwiseSqrt();
    if (f.odd) {
      Eigen::Index joint = 0;
      member.relative_error.cwiseQuotient(member.alone_error.cwiseMax(1e-300)).maxCoeff(&joint);
      fleet.other_bodies.push_back({member.name, {static_cast<int>(joint)}, member.relative_error[joint],
                                    member.alone_error[joint], f.excess, fit.median_excess(), f.deviations});
    }
    fleet.rows += f.data.rows;
    fleet.members.push_back(std::move(member));
  }
  std::stable_sort(fleet.other_bodies.begin(), fleet.other_bodies.end(),
                   [](const FleetLeftOut& a, const FleetLeftOut& b) { return a.deviations > b.deviations; });
}

void add_parameters(const Model& arm, const FleetFit& fit, Fleet& fleet) {
  fleet.parameters = VectorXd::Zero(fit.parameters().size());
  const VectorXd std = fit.deviations();
  Eigen::Index shared = 0;
  size_t own = 0;
  for (int j = 0; j < fit.base().size(); ++j) {
    const int at = fit.base().independent[j];
    const StandardParameter& p = fit.parameters()[at];
    if (p.effect) {
      const double median = fleet.spreads[own++].median;
      fleet.parameters[at] = std::isfinite(median) ? median : 0.0;
      continue;
    }
    fleet.parameters[at] = fit.beta()[shared];
    fleet.base.push_back({fit.base().names[j], fit.base().expressions[j], p.unit, fit.beta()[shared], std[shared]});
    ++shared;
  }
  for (Eigen::Index p = 0; p < fleet.parameters.size(); ++p)
    if (fit.parameters()[p].fixed) fleet.parameters[p] = fit.parameters()[p].value;
  fleet.model = with_values(arm, fleet.parameters, VectorXd::Constant(fleet.parameters.size(), kNaN));
}

// Reason for a missing result, where too few arms remain.
std::string too_few(size_t left, const std::vector<UndeterminedArm>& undetermined) {
  std::string out = text("found ", left, left == 1 ? " arm" : " arms",
                         undetermined.empty() ? "" : " whose recordings determine the bodies",
                         ", expected ", fleets::numbers.fewest, " at least");
  if (!undetermined.empty())
    out += "; " + undetermined.front().arm + ": " + undetermined.front().why;
  return out;
}

Fleet solved_fleet(const Model& arm, std::vector<ArmFactor> arms,
                   std::vector<UnusedRecording> unusable_recordings, const FleetOptions& options) {
  require(options.significance > 0.0 && options.significance < 1.0, "fleet: found the significance ",
          options.significance, ", expected a probability between 0 and 1.");
  arms.erase(
      std::remove_if(arms.begin(), arms.end(), [](const ArmFactor& a) { return a.joints.empty(); }),
      arms.end());
  require(static_cast<int>(arms.size()) >= fleets::numbers.fewest || unusable_recordings.empty(), "fleet: found ",
          arms.size(), " arms with usable recordings, expected ", fleets::numbers.fewest,
          " at least; the first that is not: ", unusable_recordings.empty() ? "" : unusable_recordings.front().why);
  if (options.progress) options.progress("solving", fleets::kReading);
  Fleet fleet;
  fleet.robot = arm.name();
  fleet.unusable_recordings = std::move(unusable_recordings);
  FleetFit fit(arm, std::move(arms), options);
  fleet.undetermined = fit.extract_undetermined();
  if (static_cast<int>(fit.arms().size()) < fleets::numbers.fewest) {
    fleet.reason = too_few(fit.arms().size(), fleet.undetermined);
    return fleet;
  }
  fit.solve();
  fleet.joints = arm.joints();
  add_members(fit, fleet);
  add_spreads(arm, fit, fleet);
  std::stable_sort(fleet.outliers.begin(), fleet.outliers.end(), [](const FleetOutlier& a, const FleetOutlier& b) {
    return std::abs(a.deviations) > std::abs(b.deviations);
  });
  add_parameters(arm, fit, fleet);
  return fleet;
}

}  // namespace

std::vector<FleetArm> read_fleet(const std::string& path) {
  std::string content = content_of_file(path, "a list of arms and their files");
  const std::string byte_order_mark = "\xEF\xBB\xBF";  // spreadsheets write it at the beginning of a file
  if (content.compare(0, byte_order_mark.size(), byte_order_mark) == 0) content.erase(0, byte_order_mark.size());
  std::istringstream file(content);
  const auto slash = path.find_last_of('/');
  const std::string folder = slash == std::string::npos ? "" : path.substr(0, slash + 1);
  std::vector<FleetArm> out;
  struct Line {
    std::string recording;
    int number;
  };
  std::map<std::uintmax_t, std::vector<Line>> lines_of_size;  // only files of equal size can have equal contents
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    line = line.substr(0, line.find('#'));
    std::replace_if(
        line.begin(), line.end(), [](char c) { return c == ',' || c == '\r'; }, ' ');
    std::istringstream words(line);
    std::string name;
    std::string recording;
    std::string more;
    if (!(words >> name)) continue;
    words >> recording;
    require(!recording.empty() && !(words >> more), path, ":", number, ": found '", excerpt(line),
            "', expected ARM,FILE.");
    if (out.empty() && name == "arm" && recording == "file") continue;
    if (recording.front() != '/') recording = folder + recording;
    std::error_code no_size;
    std::vector<Line>& alike = lines_of_size[std::filesystem::file_size(recording, no_size)];
    const std::string plain = std::filesystem::path(recording).lexically_normal().string();
    for (const Line& earlier : alike) {
      require(!same_recording(earlier.recording, plain), path, ":", number, ": found '", excerpt(recording),
              "', the same as in line ", earlier.number, ", expected each recording once.");
    }
    alike.push_back({plain, number});
    const auto known =
        std::find_if(out.begin(), out.end(), [&](const FleetArm& arm) { return arm.name == name; });
    if (known != out.end()) {
      known->files.push_back(recording);
    } else {
      out.push_back({name, {recording}});
    }
  }
  require(!out.empty(), path, ": found no arm, expected lines ARM,FILE.");
  return out;
}

namespace {

// The factors of one file. A velocity that is not the derivative of its position is derived from the
// position, as in identify(), with a remark; a file of factors may have been computed in this form.
FactorSet factors_of_file(const Model& arm, const std::string& path,
                          const PreprocessingOptions& preprocessing,
                          std::vector<std::string>& remarks) {
  FactorSet set = compress(arm, std::vector<std::string>(), preprocessing, 1);
  IdentificationOptions how;
  how.preprocessing = preprocessing;
  how.threads = 1;
  if (is_factor_file(path)) {
    FactorSet read = read_factors(path);
    if (preprocessing.derive_velocity_of.empty()) how.preprocessing.derive_velocity_of = joints_with_derived_velocities(read);
    require_factors_of(arm, read, how.preprocessing);
    set.recordings = std::move(read.recordings);
    return set;
  }
  for (const std::string& remark : remarks_on(exclude_wrong_velocities(arm, {path}, {}, how), arm))
    remarks.push_back(path + ": " + remark);
  set.recordings = compress(arm, std::vector<std::string>{path}, how.preprocessing, 1).recordings;
  return set;
}

}  // namespace

Fleet identify_fleet(const Model& file, const std::vector<FleetArm>& arms,
                     const FleetOptions& options) {
  const Model arm = with_friction(file, JointFriction::kAuto);
  IdentificationOptions reading;
  reading.preprocessing = options.preprocessing;
  keep_recordings(reading, KeptRecordings::kFewPasses);
  std::vector<ArmFactor> factors(arms.size());
  std::vector<std::vector<UnusedRecording>> unused(arms.size());
  std::vector<std::vector<std::string>> remarks(arms.size());
  std::mutex guard;
  size_t done = 0;
  parallel_for(static_cast<int>(arms.size()), options.threads, [&](int k) {
    const auto at = static_cast<size_t>(k);
    FactorSet set;
    for (const std::string& path : arms[at].files) {
      try {
        FactorSet one = factors_of_file(arm, path, reading.preprocessing, remarks[at]);
        for (CompressedRecording& r : one.recordings) {
          require(r.rows > 0.0, r.source, ": found no usable samples.");
          merge_blocks(r, 1);
        }
        set = merge(std::move(set), one);
      } catch (const InvalidInput& error) {
        unused[at].push_back({path, error.what()});
      }
    }
    factors[at] = arm_factor(arm, set, arms[at].name);
    const std::lock_guard<std::mutex> lock(guard);
    ++done;
    if (options.progress)
      options.progress("compressing",
                       fleets::kReading * static_cast<double>(done) / static_cast<double>(arms.size()));
  });
  std::vector<UnusedRecording> unusable_recordings;
  for (const auto& of_arm : unused) unusable_recordings.insert(unusable_recordings.end(), of_arm.begin(), of_arm.end());
  Fleet fleet = solved_fleet(arm, std::move(factors), std::move(unusable_recordings), options);
  for (const auto& of_arm : remarks)
    fleet.remarks.insert(fleet.remarks.end(), of_arm.begin(), of_arm.end());
  return fleet;
}

Fleet identify_fleet(const Model& file, const std::vector<std::string>& names, const std::vector<FactorSet>& factors,
                     const FleetOptions& options) {
  const Model arm = with_friction(file, JointFriction::kAuto);
  require(names.size() == factors.size(), "fleet: found ", names.size(), " names and ",
          factors.size(), " factor sets, expected one of each per arm.");
  std::vector<ArmFactor> arms;
  std::vector<UnusedRecording> empty;
  for (size_t k = 0; k < names.size(); ++k) {
    require_factors_of(arm, factors[k], options.preprocessing);
    arms.push_back(arm_factor(arm, factors[k], names[k]));
    if (arms.back().joints.empty())
      empty.push_back({names[k], names[k] + ": found no usable samples."});
  }
  return solved_fleet(arm, std::move(arms), std::move(empty), options);
}

}  // namespace veridyn
