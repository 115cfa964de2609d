#include <gtest/gtest.h>

#include <filesystem>

#include "support/near.hpp"
#include "support/simulated.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/simulation/plausible_model.hpp"
#include "veridyn/veridyn.hpp"

// Questions of recordings in memory have the answers of the same recordings in files.

namespace veridyn {
namespace {

namespace fs = std::filesystem;

// The PSM with values, and its recordings along two Fourier motions.
struct Laboratory {
  Model bare = read_model("psm-3dof");
  Model arm = plausible_model(bare, 3).arm;

  Recording recording(unsigned seed, const std::vector<HiddenEffect>& hidden = {}) const {
    constexpr int kRows = 3000;
    MotionSamples m{VectorXd::LinSpaced(kRows, 0.0, 0.005 * (kRows - 1)), MatrixXd(kRows, 3), {}, {}};
    const double centre[] = {0.0, 0.0, 0.12}, size[] = {0.5, 0.35, 0.04};
    for (int i = 0; i < 3; ++i) {
      m.q.col(i).setConstant(centre[i]);
      for (int k = 1; k <= 4; ++k) {
        const double w = 2.0 * M_PI * 0.2 * k;
        m.q.col(i).array() += size[i] / (k + 1.0) *
                              (w * m.time.array() + 1.7 * k * (i + 1) + 0.3 * seed).sin();
      }
    }
    SimulationOptions options;
    options.seed = seed;
    options.noise = sensor_noise("low");
    options.hidden = hidden;
    const SimulatedRecording s = simulate_recording(arm, with_derivatives(m), options);
    Recording out = recording_of(s);
    out.source = "run " + std::to_string(seed);
    return out;
  }
};

// The same recording after it went through a file.
struct InFile {
  explicit InFile(const Recording& recording)
      : path((fs::temp_directory_path() / ("veridyn_face_" + recording.source + ".csv")).string()) {
    write_recording(recording, path);
    memory = read_recording(path);
  }
  ~InFile() { fs::remove(path); }
  std::string path;
  Recording memory;
};

TEST(InMemoryRecordings, GiveTheSameIdentificationAsFiles) {
  const Laboratory lab;
  const InFile train(lab.recording(1)), test(lab.recording(2));
  const Identification files = identify(lab.bare, {train.path}, {test.path});
  const Identification memory = identify(lab.bare, {train.memory}, {test.memory});
  const Identification mixed = identify(lab.bare, {train.memory}, {test.path});
  ASSERT_EQ(files.status, IdentificationStatus::kDone);
  for (const Identification* other : {&memory, &mixed}) {
    EXPECT_EQ(other->parameters, files.parameters);
    EXPECT_EQ(other->train_error.relative, files.train_error.relative);
    EXPECT_EQ(other->test_error.relative, files.test_error.relative);
    EXPECT_EQ(other->noise_floor.size(), files.noise_floor.size());
    EXPECT_FALSE(other->preprocessing.in_memory.empty()) << "shared with the result, which diagnose(fit, test) asks";
  }
}

TEST(InMemoryRecordings, GiveTheSameEvaluationAndPayloadAsFiles) {
  const Laboratory lab;
  const InFile loaded(lab.recording(
      3, {parse_hidden_effect("payload:" + lab.arm.frames().back().name + ":mass=0.4")}));
  EXPECT_EQ(evaluate(lab.arm, {loaded.memory}).train_error.relative,
            evaluate(lab.arm, {loaded.path}).train_error.relative);
  const PayloadReport files = find_payload(lab.arm, {loaded.path});
  const PayloadReport memory = find_payload(lab.arm, {loaded.memory});
  ASSERT_FALSE(files.links.empty());
  EXPECT_TRUE(memory.found());
  EXPECT_EQ(memory.links.front().frame, files.links.front().frame);
  EXPECT_EQ(memory.links.front().mass, files.links.front().mass);
}

TEST(InMemoryRecordings, GiveTheSameDiagnosisAsFiles) {
  const Laboratory lab;
  const std::vector<HiddenEffect> hidden = {
      parse_hidden_effect("quadratic_drag:yaw:coefficient=0.5")};
  const InFile a(lab.recording(1, hidden)), b(lab.recording(2, hidden)), c(lab.recording(3, hidden));
  DiagnosisOptions options;
  options.effects = {"quadratic_drag", "stribeck_friction"};
  const Diagnosis files = diagnose(lab.bare, {a.path, b.path}, {c.path}, options);
  const Diagnosis memory = diagnose(lab.bare, {a.memory, b.memory}, {c.memory}, options);
  ASSERT_EQ(files.findings.size(), memory.findings.size());
  ASSERT_FALSE(files.findings.empty());
  EXPECT_TRUE(same_cause(memory.findings.front().cause, files.findings.front().cause));
  EXPECT_EQ(memory.findings.front().p_value, files.findings.front().p_value);
  EXPECT_EQ(memory.data_quality.size(), 3u);
}

TEST(Recordings, HaveUniqueNames) {
  const Laboratory lab;
  Recording one = lab.recording(1), two = lab.recording(2);
  one.source = two.source = "";
  Recordings list{one, two};
  EXPECT_EQ(list.names(), (std::vector<std::string>{"recording 1", "recording 2"}));
  one.source = two.source = "monday";
  const Recordings same{one, two};
  EXPECT_EQ(same.names(), (std::vector<std::string>{"monday", "monday (2)"}));
  RecordingsInMemory memory;
  const std::vector<std::string> train = same.register_in(memory);
  const std::vector<std::string> test = Recordings{two}.register_in(memory);
  EXPECT_EQ(test, std::vector<std::string>{"monday (3)"});
  EXPECT_EQ(memory.at("monday (3)")->q, two.q);
  EXPECT_EQ(same.register_in(memory), train) << "what is there already keeps its name";
  EXPECT_THROW(Recordings{Recording()}, InvalidInput);
}

TEST(Reading, AnInterruptionEndsAnIdentificationWithAnException) {
  const Laboratory lab;
  IdentificationOptions options;
  options.preprocessing.interrupted = [] { return true; };
  EXPECT_THROW(identify(lab.bare, {lab.recording(1)}, {}, options), Interrupted);
}

}  // namespace
}  // namespace veridyn
