#include <benchmark/benchmark.h>

#include <Eigen/QR>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <ctime>
#include <cstdlib>
#include <dlfcn.h>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/sample_arms.hpp"
#include "veridyn/dynamics/torque_regressor.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/files/c_code.hpp"
#include "veridyn/math/square_root_information.hpp"
#include "math/zero_phase_filter.hpp"

#ifdef VERIDYN_WITH_KDL
#include <kdl/chain.hpp>
#include <kdl/chaindynparam.hpp>
#include <kdl/chainidsolver_recursive_newton_euler.hpp>
#endif

#ifdef VERIDYN_WITH_MUJOCO
#include "support/mujoco_model.hpp"
#include "veridyn/files/mjcf.hpp"
#endif

// veridyn beside other libraries in one run: engines take turns, so that a machine that is busy with
// other things slows all of them down; processor time of the thread; the median over the rounds, and
// the median of each round's ratio.

#ifdef VERIDYN_WITH_LAPACK
extern "C" void dtpqrt_(const int* m, const int* n, const int* l, const int* nb, double* a,
                        const int* lda, double* b, const int* ldb, double* t, const int* ldt,
                        double* work, int* info);
#endif

namespace veridyn {
namespace {

constexpr int kJoints = 7;
constexpr int kRounds = 21;
constexpr int kStates = 256;

struct SevenJoints {
  static constexpr double kAlpha[] = {0,         -M_PI / 2, M_PI / 2, M_PI / 2,
                                      -M_PI / 2, -M_PI / 2, M_PI / 2};
  static constexpr double kD[] = {0.34, 0, 0.4, 0, 0.39, 0, 0.08};
  static double a(int i) { return 0.01 * i; }

  static Model model() {
    ArmBuilder builder("seven_joints", kJoints, 61);
    for (int i = 0; i < kJoints; ++i)
      builder.dh_link(JointType::kRevolute, i,
                      {DhConvention::kModified, a(i), kAlpha[i], kD[i], 0.0});
    return builder.build();
  }
};

double thread_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double median(std::vector<double> v) {
  std::sort(v.begin(), v.end());
  return v[v.size() / 2];
}

struct Engine {
  std::string name;
  std::function<void()> run;  // one turn
  double units = 1.0;         // of work in a turn
};

// One row of the table: the first engine is veridyn's.
nlohmann::json side_by_side(const std::string& work, const std::string& unit, double scale,
                            const std::vector<Engine>& engines) {
  std::vector<std::vector<double>> times(engines.size());
  std::vector<std::vector<double>> ratios(engines.size());
  for (const Engine& e : engines) e.run();
  for (int round = 0; round < kRounds; ++round) {
    for (size_t k = 0; k < engines.size(); ++k) {
      const double begin = thread_seconds();
      engines[k].run();
      times[k].push_back((thread_seconds() - begin) / engines[k].units * scale);
      ratios[k].push_back(times[0].back() / times[k].back());
    }
  }
  nlohmann::json row = {{"work", work}, {"unit", unit}};
  std::printf("%-36s", work.c_str());
  for (size_t k = 0; k < engines.size(); ++k) {
    const double time = median(times[k]);
    std::printf("  %s %.4g %s", engines[k].name.c_str(), time, unit.c_str());
    if (k > 0) std::printf(" (ratio %.3f)", median(ratios[k]));
    row[engines[k].name] = time;
    if (k > 0) row["ratio_to_" + engines[k].name] = median(ratios[k]);
  }
  std::printf("\n");
  std::fflush(stdout);
  return row;
}

struct States {
  std::vector<VectorXd> q, dq, ddq;
  States() {
    Random random(62);
    for (int k = 0; k < kStates; ++k) {
      q.push_back(random.vector(kJoints, -3, 3));
      dq.push_back(random.vector(kJoints, -2, 2));
      ddq.push_back(random.vector(kJoints, -5, 5));
    }
  }
};

template <typename Body>
Engine over_states(const std::string& name, const Body& body) {
  return {name,
          [body] {
            for (size_t k = 0; k < kStates; ++k) body(k);
          },
          kStates};
}

#ifdef VERIDYN_WITH_KDL

// The same arm: modified Denavit-Hartenberg rows, whose constant half belongs to the segment before.
KDL::Chain chain_of(const VectorXd& phi) {
  const auto before = [](int i) {
    return KDL::Frame(KDL::Rotation::RotX(SevenJoints::kAlpha[i])) *
           KDL::Frame(KDL::Vector(SevenJoints::a(i), 0, 0));
  };
  KDL::Chain chain;
  chain.addSegment(KDL::Segment("base", KDL::Joint(KDL::Joint::None), before(0)));
  for (int i = 0; i < kJoints; ++i) {
    const KDL::Frame next = i + 1 < kJoints ? before(i + 1) : KDL::Frame::Identity();
    const auto p = phi.segment<10>(10 * i);
    const KDL::Vector centre(p[1] / p[0], p[2] / p[0], p[3] / p[0]);
    const Eigen::Vector3d c(centre.x(), centre.y(), centre.z());
    Eigen::Matrix3d L;
    L << p[4], p[5], p[7], p[5], p[6], p[8], p[7], p[8], p[9];
    const Eigen::Matrix3d I =
        L - p[0] * (c.dot(c) * Eigen::Matrix3d::Identity() - c * c.transpose());
    const KDL::RigidBodyInertia inertia(
        p[0], centre,
        KDL::RotationalInertia(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)));
    chain.addSegment(KDL::Segment("link" + std::to_string(i), KDL::Joint(KDL::Joint::RotZ),
                                  KDL::Frame(KDL::Vector(0, 0, SevenJoints::kD[i])) * next,
                                  next.Inverse() * inertia));
  }
  return chain;
}

KDL::JntArray array_of(const VectorXd& v) {
  KDL::JntArray out(static_cast<unsigned>(v.size()));
  out.data = v;
  return out;
}

#endif

#ifdef VERIDYN_WITH_MUJOCO

// The same arm, as `export --mjcf` writes it. Only the stages that an answer needs are run.
class MujocoArm {
 public:
  explicit MujocoArm(const Model& arm) : engine_(to_mjcf(arm)) {}

  const double* inverse_dynamics(const VectorXd& q, const VectorXd& dq, const VectorXd& ddq) {
    place(q);
    VectorXd::Map(data_->qvel, kJoints) = dq;
    VectorXd::Map(data_->qacc, kJoints) = ddq;
    mj_comVel(model_.get(), data_.get());
    mj_rne(model_.get(), data_.get(), 1, data_->qfrc_inverse);
    return data_->qfrc_inverse;
  }

  void mass_matrix(const VectorXd& q, MatrixXd& M) {
    place(q);
    mj_crb(model_.get(), data_.get());
    mj_fullM(model_.get(), M.data(), data_->qM);
  }

  void forward_dynamics(const VectorXd& q, const VectorXd& dq, const VectorXd& tau) {
    place(q);
    VectorXd::Map(data_->qvel, kJoints) = dq;
    mj_crb(model_.get(), data_.get());
    mj_factorM(model_.get(), data_.get());
    mj_comVel(model_.get(), data_.get());
    mj_rne(model_.get(), data_.get(), 0, data_->qfrc_bias);
    VectorXd::Map(data_->qfrc_smooth, kJoints) = tau - VectorXd::Map(data_->qfrc_bias, kJoints);
    mj_solveM(model_.get(), data_.get(), data_->qacc, data_->qfrc_smooth, 1);
  }

 private:
  void place(const VectorXd& q) {
    VectorXd::Map(data_->qpos, kJoints) = q;
    mj_kinematics(model_.get(), data_.get());
    mj_comPos(model_.get(), data_.get());
  }

  MujocoModel engine_;
  const std::unique_ptr<mjModel, MujocoModel::Free>& model_ = engine_.model;
  const std::unique_ptr<mjData, MujocoModel::Free>& data_ = engine_.data;
};

#endif

// The same arm as exported C, compiled here by cc -O2. Without a compiler nothing is found.
class ExportedC {
 public:
  explicit ExportedC(const Model& arm)
      : folder_(std::filesystem::temp_directory_path() / ("veridyn-exported-" + std::to_string(std::rand()))) {
    std::filesystem::create_directories(folder_);
    const std::string source = (folder_ / "arm.c").string();
    const std::string library = (folder_ / "arm.so").string();
    save_c_code(arm, source);
    const std::string command = "cc -std=c99 -O2 -shared -fPIC -o '" + library + "' '" + source + "' -lm";
    if (std::system(command.c_str()) == 0) handle_ = ::dlopen(library.c_str(), RTLD_NOW);
    std::filesystem::remove_all(folder_);
  }

  // Adds the function of this name to an engine's rivals; the arrays are those of one call.
  template <typename Call>
  void join(std::vector<Engine>& engines, const char* function, const Call& call) const {
    void* const f = handle_ == nullptr ? nullptr : ::dlsym(handle_, function);
    if (f != nullptr) engines.push_back(over_states("exported C", [f, call](size_t k) { call(f, k); }));
  }

 private:
  std::filesystem::path folder_;
  void* handle_ = nullptr;  // open until the program ends
};

using OneIn = void (*)(const double*, double*);
using ThreeIn = void (*)(const double*, const double*, const double*, double*);
using ThreeInTwoOut = void (*)(const double*, const double*, const double*, double*, double*);

void add_dynamics(nlohmann::json& rows) {
  const Model arm = SevenJoints::model();
  const VectorXd phi = *arm.inertial_values();
  const States s;
  RigidBodyDynamics dynamics(arm, phi);
  TorqueRegressor regressor(arm);
  VectorXd tau(kJoints);
  MatrixXd M(kJoints, kJoints);
  MatrixXd Y(kJoints, phi.size());
  RigidBodyDynamics::TorqueDerivatives torque;
  RigidBodyDynamics::AccelerationDerivatives acceleration;
  std::vector<Engine> id = {over_states("veridyn", [&](size_t k) {
    dynamics.inverse_dynamics(s.q[k], s.dq[k], s.ddq[k], tau);
  })};
  std::vector<Engine> mass = {
      over_states("veridyn", [&](size_t k) { dynamics.mass_matrix(s.q[k], M); })};
  std::vector<Engine> gravity = {
      over_states("veridyn", [&](size_t k) { dynamics.gravity_torques(s.q[k], tau); })};
#ifdef VERIDYN_WITH_KDL
  const KDL::Chain chain = chain_of(phi);
  const KDL::Vector down(arm.gravity().x(), arm.gravity().y(), arm.gravity().z());
  KDL::ChainIdSolver_RNE newton_euler(chain, down);
  KDL::ChainDynParam parameters(chain, down);
  const KDL::Wrenches none(chain.getNrOfSegments(), KDL::Wrench::Zero());
  std::vector<KDL::JntArray> q, dq, ddq;
  for (size_t k = 0; k < kStates; ++k) {
    q.push_back(array_of(s.q[k]));
    dq.push_back(array_of(s.dq[k]));
    ddq.push_back(array_of(s.ddq[k]));
  }
  KDL::JntArray torques(kJoints);
  KDL::JntSpaceInertiaMatrix inertia(kJoints);
  id.push_back(over_states(
      "kdl", [&](size_t k) { newton_euler.CartToJnt(q[k], dq[k], ddq[k], none, torques); }));
  mass.push_back(over_states("kdl", [&](size_t k) { parameters.JntToMass(q[k], inertia); }));
  gravity.push_back(over_states("kdl", [&](size_t k) { parameters.JntToGravity(q[k], torques); }));
  newton_euler.CartToJnt(q[0], dq[0], ddq[0], none, torques);
  dynamics.inverse_dynamics(s.q[0], s.dq[0], s.ddq[0], tau);
  if ((torques.data - tau).norm() > 1e-9 * tau.norm())
    std::printf("kdl differs: %g of %g\n", (torques.data - tau).norm(), tau.norm());
#endif
  std::vector<Engine> forward = {over_states("veridyn", [&](size_t k) {
    dynamics.forward_dynamics(s.q[k], s.dq[k], s.ddq[k], tau);
  })};
#ifdef VERIDYN_WITH_MUJOCO
  MujocoArm mujoco(arm);
  id.push_back(over_states(
      "mujoco", [&](size_t k) { mujoco.inverse_dynamics(s.q[k], s.dq[k], s.ddq[k]); }));
  mass.push_back(over_states("mujoco", [&](size_t k) { mujoco.mass_matrix(s.q[k], M); }));
  forward.push_back(over_states(
      "mujoco", [&](size_t k) { mujoco.forward_dynamics(s.q[k], s.dq[k], s.ddq[k]); }));
  const VectorXd same = VectorXd::Map(mujoco.inverse_dynamics(s.q[0], s.dq[0], s.ddq[0]), kJoints);
  dynamics.inverse_dynamics(s.q[0], s.dq[0], s.ddq[0], tau);
  if ((same - tau).norm() > 1e-9 * tau.norm())
    std::printf("mujoco differs: %g of %g\n", (same - tau).norm(), tau.norm());
#endif
  std::vector<Engine> columns = {over_states(
      "veridyn", [&](size_t k) { regressor.evaluate(s.q[k], s.dq[k], s.ddq[k], Y); })};
  std::vector<Engine> derivatives = {over_states("veridyn", [&](size_t k) {
    dynamics.inverse_dynamics_derivatives(s.q[k], s.dq[k], s.ddq[k], tau, torque);
  })};
  const ExportedC code(arm);
  std::vector<double> out(Y.size());
  std::vector<double> other(out.size());
  const auto three = [&](void* f, size_t k) {
    reinterpret_cast<ThreeIn>(f)(s.q[k].data(), s.dq[k].data(), s.ddq[k].data(), out.data());
  };
  const auto one = [&](void* f, size_t k) { reinterpret_cast<OneIn>(f)(s.q[k].data(), out.data()); };
  code.join(id, "seven_joints_inverse_dynamics", three);
  code.join(gravity, "seven_joints_gravity", one);
  code.join(mass, "seven_joints_mass_matrix", one);
  code.join(forward, "seven_joints_forward_dynamics", three);
  code.join(columns, "seven_joints_regressor", three);
  code.join(derivatives, "seven_joints_derivatives", [&](void* f, size_t k) {
    reinterpret_cast<ThreeInTwoOut>(f)(s.q[k].data(), s.dq[k].data(), s.ddq[k].data(), out.data(), other.data());
  });
  rows.push_back(side_by_side("inverse dynamics, one state", "ns", 1e9, id));
  rows.push_back(side_by_side("gravity torques", "ns", 1e9, gravity));
  rows.push_back(side_by_side("mass matrix", "ns", 1e9, mass));
  rows.push_back(side_by_side("forward dynamics", "ns", 1e9, forward));
  rows.push_back(side_by_side("torque regressor, one state", "ns", 1e9, columns));
  rows.push_back(side_by_side("derivatives of inverse dynamics", "ns", 1e9, derivatives));
  rows.push_back(side_by_side("derivatives of forward dynamics", "ns", 1e9,
                              {over_states("veridyn", [&](size_t k) {
                                dynamics.forward_dynamics_derivatives(s.q[k], s.dq[k], s.ddq[k], tau,
                                                                 acceleration);
                              })}));
}

void add_batches(nlohmann::json& rows) {
  const Model arm = SevenJoints::model();
  const VectorXd phi = *arm.inertial_values();
  const TorqueRegressor batch(arm);
  for (const int count : {64, 256, 4096}) {
    Random random(63);
    MatrixXd q(count, kJoints);
    MatrixXd dq(count, kJoints);
    MatrixXd ddq(count, kJoints);
    for (int i = 0; i < kJoints; ++i) {
      q.col(i) = random.vector(count, -3, 3);
      dq.col(i) = random.vector(count, -2, 2);
      ddq.col(i) = random.vector(count, -5, 5);
    }
    MatrixXd tau;
    std::vector<MatrixXd> Y;
    const int turns = std::max(1, 4096 / count);
    const auto batches = [&](const std::function<void()>& body) {
      return Engine{"veridyn",
                    [body, turns] {
                      for (int t = 0; t < turns; ++t) body();
                    },
                    static_cast<double>(turns * count)};
    };
    const std::string of = " of " + std::to_string(count);
    rows.push_back(side_by_side("inverse dynamics, batch" + of, "ns", 1e9,
                                {batches([&] { batch.torques(q, dq, ddq, phi, tau); })}));
    rows.push_back(side_by_side("torque regressor, batch" + of, "ns", 1e9,
                                {batches([&] { batch.evaluate(q, dq, ddq, Y); })}));
  }
}

#ifdef VERIDYN_WITH_LAPACK
// The file that dtpqrt_ comes from, links followed: liblapack.so.3 may be the reference's, ATLAS' or
// OpenBLAS', and they differ by a factor of five.
std::string linked_lapack() {
  Dl_info found{};
  if (dladdr(reinterpret_cast<const void*>(&dtpqrt_), &found) == 0) return "lapack";
  return "lapack (" + std::filesystem::weakly_canonical(found.dli_fname).string() + ")";
}
#endif

// A x ~ b, streamed in blocks of 1024 rows into a triangle.
template <int kColumns>
void add_factors(nlohmann::json& rows) {
  constexpr int kRows = 1024;
  constexpr int kBlocks = 64;
  std::srand(5);
  const MatrixXd A = MatrixXd::Random(kRows, kColumns);
  const VectorXd b = VectorXd::Random(kRows);
  std::vector<std::string> names;
  for (int j = 0; j < kColumns; ++j) names.push_back("x" + std::to_string(j));
  std::vector<Engine> engines = {{"veridyn",
                                  [&] {
                                    SquareRootInformation f(names);
                                    for (int k = 0; k < kBlocks; ++k) f.absorb(A, b);
                                    benchmark::DoNotOptimize(f.R().data());
                                  },
                                  kRows * kBlocks}};
#ifdef VERIDYN_WITH_LAPACK
  engines.push_back({linked_lapack(),
                     [&] {
                       const int n = kColumns + 1;
                       const int m = kRows;
                       const int l = 0;
                       const int nb = 8;  // faster than 16 with OpenBLAS at this width
                       MatrixXd R = MatrixXd::Zero(n, n);
                       MatrixXd B(m, n);
                       MatrixXd T(nb, n);
                       std::vector<double> work(nb * n);
                       int info = 0;
                       for (int k = 0; k < kBlocks; ++k) {
                         B.leftCols(kColumns) = A;
                         B.col(kColumns) = b;
                         dtpqrt_(&m, &n, &l, &nb, R.data(), &n, B.data(), &m, T.data(), &nb,
                                 work.data(), &info);
                       }
                       benchmark::DoNotOptimize(R.data());
                     },
                     kRows * kBlocks});
#endif
  engines.push_back({"eigen",
                     [&] {
                       MatrixXd stacked = MatrixXd::Zero(kColumns + 1 + kRows, kColumns + 1);
                       for (int k = 0; k < kBlocks; ++k) {
                         stacked.bottomLeftCorner(kRows, kColumns) = A;
                         stacked.bottomRightCorner(kRows, 1) = b;
                         Eigen::HouseholderQR<Eigen::Ref<MatrixXd>> qr(stacked);
                         stacked.topRows(kColumns + 1).triangularView<Eigen::StrictlyLower>().setZero();
                       }
                       benchmark::DoNotOptimize(stacked.data());
                     },
                     kRows * kBlocks});
  rows.push_back(side_by_side("streamed QR, " + std::to_string(kColumns) + " columns, per row", "ns",
                              1e9, engines));
}

void add_filter(nlohmann::json& rows) {
  MatrixXd columns = MatrixXd::Random(4096, 64);
  const ZeroPhaseFilter filter(5.0, 6, 200.0);
  rows.push_back(side_by_side("zero-phase filter, order 6, per sample", "ns", 1e9,
                              {{"veridyn", [&] { filter.apply(columns); }, 4096.0 * 64.0}}));
}

}  // namespace

/// The table on standard output, and as JSON in a file unless `json` is empty.
int compare_with_peers(const std::string& json) {
  nlohmann::json rows = nlohmann::json::array();
  add_dynamics(rows);
  add_batches(rows);
  add_factors<60>(rows);
  add_factors<115>(rows);
  add_filter(rows);
  if (json.empty()) return 0;
  std::ofstream file(json);
  file << nlohmann::json{{"peers", rows}}.dump(2) << '\n';
  return file.good() ? 0 : 3;
}

}  // namespace veridyn

// veridyn-benchmark --peers [--json F]: the table beside other libraries. Anything else is Google
// Benchmark's.
int main(int argc, char** argv) {
  std::string json;
  bool peers = false;
  for (int k = 1; k < argc; ++k) {
    peers = peers || std::strcmp(argv[k], "--peers") == 0;
    if (std::strcmp(argv[k], "--json") == 0 && k + 1 < argc) json = argv[k + 1];
  }
  if (peers) return veridyn::compare_with_peers(json);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
