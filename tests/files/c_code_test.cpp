#include "veridyn/files/c_code.hpp"

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <type_traits>
#include <unistd.h>

#include "support/near.hpp"
#include "support/random.hpp"
#include "support/sample_arms.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/joint_torques.hpp"
#include "veridyn/simulation/plausible_model.hpp"

// The exported file, compiled here as strictly as compilers can be asked, computes what the library
// computes: every function, on every robot, in doubles and in floats.

namespace veridyn {
namespace {

namespace fs = std::filesystem;

struct Compiler {
  const char* name;
  const char* standard;
  const char* suffix;
};
constexpr Compiler kCompilers[] = {{"gcc", "c99", ".c"},
                                   {"clang++", "c++11", ".cpp"},
                                   {"clang", "c99", ".c"},
                                   {"g++", "c++11", ".cpp"}};
constexpr const char* kWarnings = " -Wall -Wextra -Wpedantic -Wshadow -Werror";

bool is_there(const Compiler& compiler) {
  return std::system((std::string(compiler.name) + " --version > /dev/null 2>&1").c_str()) == 0;
}

std::string in_letters(std::string name) {
  std::replace_if(name.begin(), name.end(),
                  [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
  return name;
}

// The file as a shared library, with functions of Real.
template <typename Real>
class Compiled {
 public:
  Compiled(const Model& arm, const Compiler& compiler)
      : name_(in_letters(arm.name())),
        folder_(fs::temp_directory_path() /
                ("veridyn-c-" + std::to_string(::getpid()) + "-" + name_ + "-" + compiler.name)) {
    fs::create_directories(folder_);
    const std::string source = (folder_ / (std::string("arm") + compiler.suffix)).string();
    const std::string library = (folder_ / "arm.so").string();
    save_c_code(arm, source);
    const std::string command = std::string(compiler.name) + " -std=" + compiler.standard + kWarnings +
                                (std::is_same<Real, float>::value ? " -D" + name_ + "_real=float" : "") +
                                " -shared -fPIC -o '" + library + "' '" + source + "' -lm";
    EXPECT_EQ(std::system(command.c_str()), 0) << command;
    handle_ = ::dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
    EXPECT_NE(handle_, nullptr);
  }
  ~Compiled() {
    if (handle_ != nullptr) ::dlclose(handle_);
    fs::remove_all(folder_);
  }
  Compiled(const Compiled&) = delete;
  Compiled& operator=(const Compiled&) = delete;

  bool ready() const { return handle_ != nullptr; }

  template <typename... Arrays>
  void call(const std::string& function, Arrays*... arrays) const {
    using Function = void (*)(Arrays*...);
    const auto f = reinterpret_cast<Function>(::dlsym(handle_, (name_ + "_" + function).c_str()));
    ASSERT_NE(f, nullptr) << function;
    f(arrays...);
  }

 private:
  std::string name_;
  fs::path folder_;
  void* handle_ = nullptr;
};

template <typename Real>
using Numbers = std::vector<Real>;

template <typename Real>
Numbers<Real> numbers(const VectorXd& x) {
  return Numbers<Real>(x.data(), x.data() + x.size());
}

template <typename Real>
MatrixXd matrix(const Numbers<Real>& by_rows, Eigen::Index rows) {
  const auto cols = static_cast<Eigen::Index>(by_rows.size()) / rows;
  MatrixXd out(rows, cols);
  for (Eigen::Index k = 0; k < out.size(); ++k) out(k / cols, k % cols) = by_rows[k];
  return out;
}

// `relative`: of the largest entry that the library computes.
template <typename Real>
void expect_the_same(const Model& arm, const Compiled<Real>& code, double relative) {
  const int n = arm.joints();
  const auto size = static_cast<size_t>(n);
  const auto columns = static_cast<size_t>(kBodyParameters) * arm.bodies().size();
  RigidBodyDynamics dynamics(arm, *arm.inertial_values());
  Random random(29);
  for (int k = 0; k < 4; ++k) {
    // Numbers that a float has exactly.
    const auto state = [&] { return VectorXd(random.vector(n, -1.0, 1.0).cast<float>().cast<double>()); };
    const VectorXd q = state();
    const VectorXd dq = k == 0 ? VectorXd(VectorXd::Zero(n)) : state();
    const VectorXd ddq = state();
    VectorXd tau(n), g(n), back(n);
    RigidBodyDynamics::TorqueDerivatives by;
    dynamics.inverse_dynamics_derivatives(q, dq, ddq, tau, by);
    dynamics.gravity_torques(q, g);
    const Numbers<Real> at = numbers<Real>(q), rate = numbers<Real>(dq), accel = numbers<Real>(ddq);
    const auto bound = [relative](const MatrixXd& x) {
      return relative * (1.0 + x.cwiseAbs().maxCoeff());
    };

    Numbers<Real> out(size), M(size * size), by_q(size * size), by_dq(size * size), Y(size * columns);
    code.call("inverse_dynamics", at.data(), rate.data(), accel.data(), out.data());
    EXPECT_TRUE(near(matrix(out, n), tau, bound(tau)));
    code.call("gravity", at.data(), out.data());
    EXPECT_TRUE(near(matrix(out, n), g, bound(g)));
    code.call("mass_matrix", at.data(), M.data());
    EXPECT_TRUE(near(matrix(M, n), by.by_ddq, bound(by.by_ddq)));
    code.call("derivatives", at.data(), rate.data(), accel.data(), by_q.data(), by_dq.data());
    EXPECT_TRUE(near(matrix(by_q, n), by.by_q, bound(by.by_q)));
    EXPECT_TRUE(near(matrix(by_dq, n), by.by_dq, bound(by.by_dq)));
    code.call("regressor", at.data(), rate.data(), accel.data(), Y.data());
    const MatrixXd expected = torque_regressor(arm, q, dq, ddq);
    EXPECT_TRUE(near(matrix(Y, n), expected, bound(expected)));

    Numbers<double> memory(3 * (arm.effects().size() + 1), 0.0);
    const VectorXd whole = joint_torques(arm, q, dq, ddq);
    code.call("torque", at.data(), rate.data(), accel.data(), memory.data(), out.data());
    EXPECT_TRUE(near(matrix(out, n), whole, bound(whole)));
    std::fill(memory.begin(), memory.end(), 0.0);
    code.call("friction", at.data(), rate.data(), accel.data(), memory.data(), out.data());
    EXPECT_TRUE(near(matrix(out, n), whole - tau, bound(whole) + bound(tau)));

    // Accelerations are as exact as M is regular; a wrist without rotors has none.
    if (!dynamics.forward_dynamics(q, dq, tau, back)) continue;
    const double condition = by.by_ddq.norm() * by.by_ddq.inverse().norm();
    if (condition * relative > 0.01) continue;
    const Numbers<Real> torque = numbers<Real>(tau);
    code.call("forward_dynamics", at.data(), rate.data(), torque.data(), out.data());
    EXPECT_TRUE(near(matrix(out, n), back, condition * bound(back)));
  }
}

class CCode : public testing::TestWithParam<std::string> {
 protected:
  // Each robot has its turn of the compilers.
  Compiler compiler(int turn) const {
    const std::vector<std::string> all = robot_names();
    const auto at = std::find(all.begin(), all.end(), GetParam()) - all.begin();
    return kCompilers[(at + turn) % 4];
  }
};

TEST_P(CCode, ComputesWhatTheLibraryComputesInDoubles) {
  const Compiler with = compiler(0);
  if (!is_there(with)) GTEST_SKIP() << with.name << " is not installed";
  const Model arm = plausible_model(read_model(GetParam()), 3).arm;
  const Compiled<double> code(arm, with);
  if (code.ready()) expect_the_same(arm, code, 1e-12);
}

// In C; in C++ the functions are templates (examples in python/tests/test_exports.py).
TEST_P(CCode, ComputesWhatTheLibraryComputesInFloats) {
  Compiler with = compiler(0);
  if (with.standard[1] != '9') with = compiler(1);
  if (!is_there(with)) GTEST_SKIP() << with.name << " is not installed";
  const Model arm = plausible_model(read_model(GetParam()), 3).arm;
  const Compiled<float> code(arm, with);
  if (code.ready()) expect_the_same(arm, code, 1e-5);
}

INSTANTIATE_TEST_SUITE_P(Robots, CCode, testing::ValuesIn(robot_names()),
                         [](const auto& robot) { return in_letters(robot.param); });

// Robots have right angles nearly everywhere; these arms have general poses, offsets in every link,
// sliding joints, branches and joints that follow several coordinates.
class CCodeOfSampleArms : public OnSampleArm {};
INSTANTIATE_TEST_SUITE_P(Sample, CCodeOfSampleArms, testing::ValuesIn(sample_arm_names()),
                         sample_arm_name);

TEST_P(CCodeOfSampleArms, ComputesWhatTheLibraryComputes) {
  const Compiler with = kCompilers[0];
  if (!is_there(with)) GTEST_SKIP() << with.name << " is not installed";
  const Compiled<double> code(arm(), with);
  if (code.ready()) expect_the_same(arm(), code, 1e-12);
}

int products(const std::string& code, const std::string& function) {
  const size_t begin = code.find("_" + function + "(");
  const std::string body = code.substr(begin, code.find("\n}", begin) - begin);
  int count = 0;
  for (size_t at = body.find(" * "); at != std::string::npos; at = body.find(" * ", at + 1)) ++count;
  return count;
}

// From closed forms in one frame: tangents take nine times the products of inverse dynamics.
TEST(CCodeIsShort, DerivativesCostLessThanEightTimesTheTorques) {
  ArmBuilder builder("offsets", 7, 61);
  for (int i = 0; i < 7; ++i)
    builder.dh_link(JointType::kRevolute, i,
                    {DhConvention::kModified, 0.01 * i, i % 2 == 0 ? M_PI / 2 : -M_PI / 2, 0.3, 0.0});
  const std::string code = to_c_code(builder.build());
  EXPECT_LT(products(code, "derivatives"), 8 * products(code, "inverse_dynamics"));
  EXPECT_EQ(code.find("e-17"), std::string::npos);  // 0.3 cos(pi/2)
}

// As often as C needs the name.
TEST(CCodeOfNames, ItsLengthGrowsLinearlyWithTheArmsName) {
  ModelDescription d = read_model("planar-2r").description();
  const std::string short_code = to_c_code(Model(d));
  const auto uses = [](const std::string& code, const std::string& name) {
    long count = 0;
    for (size_t at = code.find(name + "_"); at != std::string::npos; at = code.find(name + "_", at + name.size())) ++count;
    return count;
  };
  const long count = uses(short_code, "planar_2r");
  EXPECT_GT(count, 50);
  EXPECT_NE(short_code.find("planar_2r_direction(double"), std::string::npos);
  EXPECT_EQ(short_code.find("planar_2r_clamp("), std::string::npos);
  const size_t length = 100000;
  d.name = std::string(length, 'a');
  const std::string code = to_c_code(Model(d));
  const auto more = static_cast<double>(code.size() - short_code.size());
  EXPECT_NEAR(more / static_cast<double>(length), static_cast<double>(count), 0.1 * static_cast<double>(count));
}

// Two question marks and a slash are a backslash in C99, which takes the end of a string or of a line away.
TEST(CCodeOfNames, HasNoTrigraphsAndNoControlCharacters) {
  ModelDescription d = plausible_model(read_model("planar-2r"), 3).arm.description();
  d.coordinates[0].name = "lift?" "?/";
  d.frames[0].name = "up\rper?" "?/";
  const std::string code = to_c_code(Model(std::move(d)));
  EXPECT_EQ(code.find("?" "?"), std::string::npos);
  EXPECT_EQ(code.find('\r'), std::string::npos);
  EXPECT_NE(code.find("\"lift  /\""), std::string::npos);
}

// Joints at quarter turns of one angle share its sine and cosine; right angles leave no product.
TEST(CCodeIsShort, RepeatedAnglesShareTheirSinesAndCosines) {
  const std::string code = to_c_code(plausible_model(read_model("psm-wrist"), 3).arm);
  const size_t begin = code.find("_inverse_dynamics(");
  const std::string body = code.substr(begin, code.find("\n}", begin) - begin);
  int sines = 0;
  for (size_t at = body.find("_sin("); at != std::string::npos; at = body.find("_sin(", at + 1)) ++sines;
  EXPECT_EQ(sines, 2);  // of its five turning links four follow the second coordinate
  EXPECT_EQ(code.find("e-17"), std::string::npos);
}

}  // namespace
}  // namespace veridyn
