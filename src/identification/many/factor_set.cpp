#include "veridyn/identification/factor_set.hpp"

#include <fmt/format.h>

#include <cstring>
#include <fstream>
#include <sstream>
#include <utility>

#include "files/input_file.hpp"
#include "identification/many/factor_bytes.hpp"
#include "identification/many_recordings.hpp"
#include "files/output_file.hpp"
#include "identification/velocity_choice.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {

namespace {

void exchange(ByteExchange& bytes, const std::vector<std::string>& columns, SquareRootInformation& factor) {
  const auto k = static_cast<Eigen::Index>(columns.size());
  double rows = factor.rows(), rho2 = factor.rho2();
  MatrixXd R = bytes.reads() ? MatrixXd::Zero(k, k) : factor.R();
  VectorXd z = bytes.reads() ? VectorXd::Zero(k) : factor.z();
  bytes(rows, rho2);
  for (Eigen::Index j = 0; j < k; ++j)
    for (Eigen::Index i = 0; i <= j; ++i) bytes(R(i, j));
  for (double& entry : z) bytes(entry);
  if (bytes.reads()) factor = SquareRootInformation(columns, std::move(R), std::move(z), rho2, rows);
}

}  // namespace

void exchange(ByteExchange& bytes, TorqueFacts& j) { bytes(j.minimum, j.maximum, j.largest_speed, j.lowest, j.highest); }

void exchange(ByteExchange& bytes, CompressedRecording& r) {
  bytes(r.source, r.facts.dt, r.facts.duration, r.facts.samples, r.facts.unused, r.facts.rows_read, r.facts.filled.count,
        r.facts.filled.age, r.period.seconds, r.period.confidence, r.period.repeats, r.rows, r.noise_floor, r.joints);
  r.detached = r.detached || bytes.reads();
  r.blocks.resize(bytes.count(r.blocks.size(), 16));
  std::vector<std::vector<std::string>> columns(r.blocks.empty() ? 0 : r.joints.size());
  for (size_t i = 0; i < columns.size(); ++i) {
    if (!bytes.reads()) columns[i] = r.blocks.front()[i].columns();
    bytes(columns[i]);
  }
  for (auto& block : r.blocks) {
    block.resize(columns.size());
    for (size_t i = 0; i < columns.size(); ++i) exchange(bytes, columns[i], block[i]);
  }
}

void exchange(ByteExchange& bytes, FactorSet& set) { bytes(set.robot, set.fingerprint, set.settings, set.recordings); }

namespace {

const std::string kMagic = "veridyn factors\n";
constexpr std::uint64_t kVersion = 1;
constexpr double kSameArm = 1e-9;  // largest difference between fingerprints of one arm, relative to 1 + the entry

// The bodies' regressor at one fixed state, joint by joint, and the known values: these differ between arms
// with different lengths, axes or direction of gravity.
VectorXd fingerprint_of(const Model& arm) {
  const int n = arm.joints();
  MatrixXd q(1, n);
  MatrixXd dq(1, n);
  MatrixXd ddq(1, n);
  for (int i = 0; i < n; ++i) {
    q(0, i) = 0.3 + 0.1 * i;
    dq(0, i) = 0.7 - 0.15 * i;
    ddq(0, i) = -0.4 + 0.2 * i;
  }
  std::vector<MatrixXd> Y;
  TorqueRegressor(arm).evaluate(q, dq, ddq, Y);
  VectorXd out = VectorXd::Zero(n + 1);
  for (int i = 0; i < n; ++i) {
    for (Eigen::Index c = 0; c < Y[i].cols(); ++c)
      out[i] += Y[i](0, c) * (1.0 + 0.01 * static_cast<double>(c));
  }
  double place = 1.0;
  for (const StandardParameter& p : standard_parameters(arm)) {
    if (p.fixed) out[n] += place * p.value;
    place += 0.01;
  }
  return out;
}

constexpr const char* kDerived = ", velocities from the position at joints";

// Numbers (from 1) of the joints with derived velocities, for messages.
std::string derived_joints(const PreprocessingOptions& how) {
  if (how.derive_velocity_of.empty()) return "";
  std::string out = kDerived;
  for (const auto [j] : how.derive_velocity_of) out += " " + std::to_string(j + 1);
  return out;
}

std::string settings_text(const PreprocessingOptions& how) {
  return fmt::format("cut-off {:g} Hz, order {}{}, signal cut-off ratio {:g}{}{}, decimation {}, rate {:g} Hz, slowest {:g}{}", how.cutoff,
                     how.order, how.filtering == Filtering::kMatched ? ", matched" : ", signals", how.signal_cutoff_ratio,
                     how.velocity == VelocitySource::kRecorded ? ", velocities as recorded" : ", velocities derived",
                     how.stale_rows == StaleRows::kFilled ? ", stale rows filled" : ", stale rows kept", how.decimation, how.rate,
                     how.min_speed, derived_joints(how));
}

bool are_fingerprints_of_one_arm(const VectorXd& a, const VectorXd& b) {
  return a.size() == b.size() &&
         ((a - b).cwiseAbs().array() <=
          kSameArm * (1.0 + a.cwiseAbs().array().max(b.cwiseAbs().array())))
             .all();
}

// FNV-1a checksum, sufficient to detect a damaged file.
std::uint64_t checksum(const std::string& bytes, std::size_t from) {
  std::uint64_t hash = 14695981039346656037ULL;
  for (std::size_t k = from; k < bytes.size(); ++k) {
    hash ^= static_cast<unsigned char>(bytes[k]);
    hash *= 1099511628211ULL;
  }
  return hash;
}

void require_joints(const FactorSet& factors, const Model& arm) {
  require(are_fingerprints_of_one_arm(factors.fingerprint, fingerprint_of(arm)), "the factors are of robot '",
          factors.robot, "', which differs from robot '", arm.name(),
          "' in its kinematics or in the parameters that its file declares as facts; expected "
          "factors of this robot file.");
  const std::vector<StandardParameter> parameters = standard_parameters(arm);
  const RegressorColumns columns(arm, {});
  for (const CompressedRecording& r : factors.recordings) {
    require(static_cast<int>(r.joints.size()) == arm.joints(), r.source, ": found factors of ",
            r.joints.size(), " joints, expected ", arm.joints(), ".");
    for (int i = 0; i < arm.joints() && !r.blocks.empty(); ++i) {
      std::vector<std::string> mine;
      for (const int p : columns.parameters_of({i})) {
        const StandardParameter& parameter = parameters[p];
        if (!parameter.fixed) mine.push_back(parameter.name);
      }
      require(r.blocks.front()[i].columns() == mine, r.source,
              ": the factors of joint ", i + 1, " have other parameters than robot '", arm.name(),
              "' (bodies, effects or facts differ).");
    }
  }
}

}  // namespace

std::vector<JointIndex> joints_with_derived_velocities(const FactorSet& factors) {
  std::vector<JointIndex> out;
  const size_t at = factors.settings.find(kDerived);
  if (at == std::string::npos) return out;
  std::istringstream joints(factors.settings.substr(at + std::strlen(kDerived)));
  for (int j = 0; joints >> j;) out.push_back({j - 1});
  return out;
}

bool is_factor_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string start(kMagic.size(), '\0');
  file.read(start.data(), static_cast<std::streamsize>(start.size()));
  return file && start == kMagic;
}

void require_factors_of(const Model& arm, const FactorSet& factors,
                        const PreprocessingOptions& how) {
  require_joints(factors, with_friction(arm, JointFriction::kAuto));  // the friction that compress() chooses
  require(factors.settings == settings_text(how), "the factors were prepared differently: found ",
          factors.settings, "; expected ", settings_text(how), ".");
}

FactorSet compress(const Model& file, const std::vector<std::string>& paths,
                   const PreprocessingOptions& options, int threads) {
  const Model arm = with_friction(file, JointFriction::kAuto);
  FactorSet out;
  out.robot = arm.name();
  out.fingerprint = fingerprint_of(arm);
  out.settings = settings_text(options);
  out.recordings = compress_many(arm, paths, options, threads);
  return out;
}

FactorSet merge(FactorSet a, const FactorSet& b) {
  if (a.recordings.empty()) return b;
  if (b.recordings.empty()) return a;
  require(are_fingerprints_of_one_arm(a.fingerprint, b.fingerprint), "factors of robot '", a.robot,
          "' and of robot '", b.robot,
          "' do not merge: their kinematics or facts differ; expected factors of one robot file.");
  require(a.settings == b.settings, "factors that were prepared differently do not merge: found ",
          b.settings, "; expected ", a.settings, ".");
  a.recordings.insert(a.recordings.end(), b.recordings.begin(), b.recordings.end());
  return a;
}

std::string to_bytes(const FactorSet& factors) {
  const std::string content = bytes_of(factors);
  ByteExchange head;
  std::uint64_t version = kVersion, sum = checksum(content, 0);
  head(version, sum);
  return kMagic + head.bytes() + content;
}

FactorSet factors_from_bytes(const std::string& bytes, const std::string& source) {
  require(bytes.compare(0, kMagic.size(), kMagic) == 0, source,
          ": found no factors, expected a file that --factor-out wrote.");
  ByteExchange in(bytes, kMagic.size(), source);
  std::uint64_t version = 0, sum = 0;
  in(version);
  require(version == kVersion, source, ": found factors of version ", version, ", expected ",
          kVersion, ".");
  in(sum);
  require(sum == checksum(bytes, kMagic.size() + 16), source,
          ": found a wrong checksum, expected a whole and unchanged file.");
  FactorSet out;
  in(out);
  require(in.at_end(), source, ": found bytes after the last factor, expected none.");
  return out;
}

void save_factors(const FactorSet& factors, const std::string& path) {
  write_file(path, to_bytes(factors));
}

FactorSet read_factors(const std::string& path) {
  return factors_from_bytes(content_of_file(path, "a factor file"), path);
}

Identification identify(const Model& arm, const FactorSet& factors,
                        const std::vector<std::string>& train,
                        const std::vector<std::string>& test,
                        const IdentificationOptions& options) {
  require(options.known_masses.empty(),
          "identify: drive gains need the samples of the recordings, factors do not hold them.");
  require(!factors.recordings.empty() || !train.empty(),
          "identify: there is no factor and no recording to train on.");
  if (factors.recordings.empty()) return identify_compressed(arm, {}, train, test, options);
  IdentificationOptions how = options;
  if (how.choose_velocities && how.preprocessing.derive_velocity_of.empty()) {
    const std::vector<JointIndex> joints = joints_with_derived_velocities(factors);
    derive_velocities({joints.begin(), joints.end()}, how);
  }
  require_factors_of(with_friction(arm, how.friction), factors, how.preprocessing);
  return identify_compressed(arm, factors.recordings, train, test, how);
}

}  // namespace veridyn
