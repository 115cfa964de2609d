#include "veridyn/identification/factor_set.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>
#include <utility>

#include "files/input_file.hpp"
#include "identification/many/factor_bytes.hpp"
#include "identification/many_recordings.hpp"
#include "files/output_file.hpp"
#include "identification/velocity_choice.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {

template <typename Bytes>
void exchange(Bytes& bytes, TorqueFacts& j) {
  bytes(j.minimum, j.maximum, j.largest_speed, j.lowest, j.highest);
}

namespace {

const std::string kMagic = "veridyn factors\n";
constexpr std::uint64_t kVersion = 1;
constexpr double kSameArm = 1e-9;  // share of a fingerprint's entry

// The bodies' regressor at one fixed state, joint by joint, and the facts: arms with different
// lengths, axes or direction of gravity differ here.
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

// Joints from 1, as in messages.
std::string derived_joints(const PreprocessingOptions& how) {
  if (how.derive_velocity_of.empty()) return "";
  std::string out = kDerived;
  for (const int j : how.derive_velocity_of) out += " " + std::to_string(j + 1);
  return out;
}

std::string settings_of(const PreprocessingOptions& how) {
  return fmt::format("cut-off {:g} Hz, order {}{}, signal cut-off ratio {:g}{}{}, decimation {}, rate {:g} Hz, slowest {:g}{}", how.cutoff,
                     how.order, how.filtering == Filtering::kMatched ? ", matched" : ", signals", how.signal_cutoff_ratio,
                     how.velocity == VelocitySource::kRecorded ? ", velocities as recorded" : ", velocities derived",
                     how.stale_rows == StaleRows::kFilled ? ", stale rows filled" : ", stale rows kept", how.decimation, how.rate,
                     how.min_speed, derived_joints(how));
}

bool same_arm(const VectorXd& a, const VectorXd& b) {
  return a.size() == b.size() &&
         ((a - b).cwiseAbs().array() <=
          kSameArm * (1.0 + a.cwiseAbs().array().max(b.cwiseAbs().array())))
             .all();
}

void write_columns(const CompressedRecording& r, ByteWriter& out) {
  if (r.blocks.empty()) return;
  for (const SquareRootInformation& factor : r.blocks.front()) {
    out.number(static_cast<std::uint64_t>(factor.size()));
    for (const std::string& name : factor.columns()) out.text(name);
  }
}

void write_factor(const SquareRootInformation& factor, ByteWriter& out) {
  out.real(factor.rows());
  out.real(factor.rho2());
  const MatrixXd R = factor.R();
  const VectorXd z = factor.z();
  for (Eigen::Index j = 0; j < factor.size(); ++j)
    for (Eigen::Index i = 0; i <= j; ++i) out.real(R(i, j));
  for (Eigen::Index i = 0; i < factor.size(); ++i) out.real(z[i]);
}

SquareRootInformation read_factor(const std::vector<std::string>& columns, ByteReader& in) {
  const double rows = in.real();
  const double rho2 = in.real();
  const auto k = static_cast<Eigen::Index>(columns.size());
  MatrixXd R = MatrixXd::Zero(k, k);
  for (Eigen::Index j = 0; j < k; ++j)
    for (Eigen::Index i = 0; i <= j; ++i) R(i, j) = in.real();
  VectorXd z(k);
  for (Eigen::Index i = 0; i < k; ++i) z[i] = in.real();
  return SquareRootInformation(columns, std::move(R), std::move(z), rho2, rows);
}

// Everything but the factors.
template <typename Bytes>
void exchange_facts(Bytes& bytes, CompressedRecording& r) {
  bytes(r.source, r.facts.dt, r.facts.duration, r.facts.samples, r.facts.unused, r.facts.rows_read, r.facts.filled.count,
        r.facts.filled.age, r.period.seconds, r.period.confidence, r.period.repeats, r.rows, r.noise_floor, r.joints);
}

void write_recording(const CompressedRecording& r, ByteWriter& out) {
  exchange_facts(out, const_cast<CompressedRecording&>(r));  // only read
  out.number(r.blocks.size());
  write_columns(r, out);
  for (const auto& block : r.blocks)
    for (const SquareRootInformation& factor : block) write_factor(factor, out);
}

CompressedRecording read_recording(ByteReader& in) {
  CompressedRecording r;
  r.detached = true;
  exchange_facts(in, r);
  r.blocks.resize(in.count(16));
  std::vector<std::vector<std::string>> columns(r.blocks.empty() ? 0 : r.joints.size());
  for (std::vector<std::string>& of_joint : columns) in(of_joint);
  for (auto& block : r.blocks) {
    for (const std::vector<std::string>& of_joint : columns)
      block.push_back(read_factor(of_joint, in));
  }
  return r;
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
  require(same_arm(factors.fingerprint, fingerprint_of(arm)), "the factors are of robot '",
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
      for (const int p : columns.parameters_of(i)) {
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

std::vector<int> joints_with_derived_velocities(const FactorSet& factors) {
  std::vector<int> out;
  const size_t at = factors.settings.find(kDerived);
  if (at == std::string::npos) return out;
  std::istringstream joints(factors.settings.substr(at + std::strlen(kDerived)));
  for (int j = 0; joints >> j;) out.push_back(j - 1);
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
  require_joints(factors, with_friction(arm, JointFriction::kAuto));  // as compress() does
  require(factors.settings == settings_of(how), "the factors were prepared differently: found ",
          factors.settings, "; expected ", settings_of(how), ".");
}

FactorSet compress(const Model& file, const std::vector<std::string>& paths,
                   const PreprocessingOptions& options, int threads) {
  const Model arm = with_friction(file, JointFriction::kAuto);
  FactorSet out;
  out.robot = arm.name();
  out.fingerprint = fingerprint_of(arm);
  out.settings = settings_of(options);
  out.recordings = compress_many(arm, paths, options, threads);
  return out;
}

FactorSet merge(FactorSet a, const FactorSet& b) {
  if (a.recordings.empty()) return b;
  if (b.recordings.empty()) return a;
  require(same_arm(a.fingerprint, b.fingerprint), "factors of robot '", a.robot,
          "' and of robot '", b.robot,
          "' do not merge: their kinematics or facts differ; expected factors of one robot file.");
  require(a.settings == b.settings, "factors that were prepared differently do not merge: found ",
          b.settings, "; expected ", a.settings, ".");
  a.recordings.insert(a.recordings.end(), b.recordings.begin(), b.recordings.end());
  return a;
}

std::string to_bytes(const FactorSet& factors) {
  ByteWriter out;
  out.text(factors.robot);
  out.vector(factors.fingerprint);
  out.text(factors.settings);
  out.number(factors.recordings.size());
  for (const CompressedRecording& r : factors.recordings) write_recording(r, out);
  ByteWriter head;
  head.number(kVersion);
  head.number(checksum(out.bytes(), 0));
  return kMagic + head.bytes() + out.bytes();
}

FactorSet factors_from_bytes(const std::string& bytes, const std::string& source) {
  require(bytes.compare(0, kMagic.size(), kMagic) == 0, source,
          ": found no factors, expected a file that --factor-out wrote.");
  ByteReader in(bytes, kMagic.size(), source);
  const std::uint64_t version = in.number();
  require(version == kVersion, source, ": found factors of version ", version, ", expected ",
          kVersion, ".");
  require(in.number() == checksum(bytes, kMagic.size() + 16), source,
          ": found a wrong checksum, expected a whole and unchanged file.");
  FactorSet out;
  out.robot = in.text();
  out.fingerprint = in.vector();
  out.settings = in.text();
  out.recordings.resize(in.count(8));
  for (CompressedRecording& r : out.recordings) r = read_recording(in);
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
    const std::vector<int> joints = joints_with_derived_velocities(factors);
    derive_velocities({joints.begin(), joints.end()}, how);
  }
  require_factors_of(with_friction(arm, how.friction), factors, how.preprocessing);
  return identify_compressed(arm, factors.recordings, train, test, how);
}

}  // namespace veridyn
