#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "identification/synthetic_recording.hpp"
#include "support/near.hpp"
#include "veridyn/identification/identification.hpp"
#include "veridyn/files/model_file.hpp"

// What an identification leaves in its MODEL file for later statistics.

namespace veridyn {
namespace {

constexpr double kNineDigits = 1e-8;

Recording noisy_planar(double duration, unsigned seed) {
  MotionShape shape;
  shape.duration = duration;
  shape.rate = 100.0;
  shape.seed = seed;
  Recording r = synthetic_recording(read_model("planar-2r"), shape);
  r.tau += noise_like(r.tau, 0.1, seed);
  return r;
}

Identification identified(Method method) {
  IdentificationOptions options;
  options.method = method;
  return identify(read_model("planar-2r"), noisy_planar(30.0, 4), options);
}

double value_of(const IdentifiedParameter& p, const Model& arm) {
  double sum = 0.0;
  for (const StandardParameter& s : standard_parameters(arm)) {
    const auto found = p.combination.find(s.name);
    if (found != p.combination.end()) sum += found->second * s.value;
  }
  return sum;
}

TEST(TheIdentifiedBase, HasTheValuesOfTheModelAndTheDeviationsOfTheReport) {
  const Identification id = identified(Method::kFeasible);
  const std::optional<IdentifiedBase>& base = id.model->description().identified;
  ASSERT_TRUE(base.has_value());
  ASSERT_EQ(base->parameters.size(), id.base.size());
  EXPECT_EQ(base->recordings, std::vector<std::string>{"synthetic"});
  EXPECT_TRUE(near(base->error, id.train_error.relative, 0.0));
  for (size_t j = 0; j < id.base.size(); ++j) {
    const IdentifiedParameter& p = base->parameters[j];
    const double size = std::abs(p.value) + 1.0;
    EXPECT_NEAR(p.value, id.base[j].value, kNineDigits * size);
    EXPECT_NEAR(value_of(p, *id.model), p.value, kNineDigits * size) << p.name;
    EXPECT_NEAR(p.scatter.norm(), id.base[j].std, kNineDigits * id.base[j].std);
    EXPECT_EQ(p.scatter.size(), base->clusters);
  }
}

// `free` is what weighted least squares finds, whatever conditions the values were held to.
TEST(TheIdentifiedBase, HasTheUnconstrainedLeastSquaresValuesToo) {
  const Identification held = identified(Method::kFeasible);
  const Identification free = identified(Method::kWls);
  for (size_t j = 0; j < free.base.size(); ++j) {
    const double expected = free.base[j].value;
    EXPECT_NEAR(held.model->description().identified->parameters[j].free, expected,
                kNineDigits * (1.0 + std::abs(expected)));
  }
}

// The shares of all clusters in the squares of a column make one.
TEST(TheIdentifiedBase, SharesOfAllClustersAddUpToOne) {
  const IdentifiedBase base = *identified(Method::kWls).model->description().identified;
  ASSERT_EQ(base.motion.rows(), base.clusters);
  ASSERT_EQ(base.motion.cols(), 2);
  EXPECT_TRUE(near(base.motion.colwise().squaredNorm().transpose(), Eigen::Vector2d(1, 1), 1e-3));
}

TEST(TheIdentifiedBase, IsKeptInAFileAndDroppedIfValuesChange) {
  const Identification id = identified(Method::kFeasible);
  const std::string path =
      testing::TempDir() + "identified_base_test_" + std::to_string(::getpid()) + ".yaml";
  save(id, path);
  const Model read = read_model(path);
  std::filesystem::remove(path);
  EXPECT_EQ(to_yaml(read), to_yaml(*id.model));
  ASSERT_TRUE(read.description().identified.has_value());
  EXPECT_EQ(with_values(read, id.parameters, id.parameter_deviations).description().identified,
            std::nullopt);
}

// Beyond kClustersKept the covariance is kept in another factor, no wider than it must be.
TEST(TheIdentifiedBase, SizeDoesNotGrowWithTheNumberOfRecordings) {
  std::vector<std::string> paths;
  for (unsigned k = 0; k < 16; ++k) {
    paths.push_back(testing::TempDir() + "identified_base_test_" + std::to_string(::getpid()) +
                    "_" + std::to_string(k) + ".csv");
    write_recording(noisy_planar(17.0, k + 1), paths.back());
  }
  IdentificationOptions options;
  options.method = Method::kWls;
  const Identification id = identify(read_model("planar-2r"), paths, {}, options);
  for (const std::string& path : paths) std::filesystem::remove(path);
  const IdentifiedBase base = *id.model->description().identified;
  ASSERT_GT(base.clusters, kClustersKept);
  EXPECT_EQ(base.motion.rows(), 0);
  for (size_t j = 0; j < id.base.size(); ++j) {
    EXPECT_EQ(base.parameters[j].scatter.size(), static_cast<Eigen::Index>(id.base.size()));
    EXPECT_NEAR(base.parameters[j].scatter.norm(), id.base[j].std, 1e-7 * id.base[j].std);
  }
}

}  // namespace
}  // namespace veridyn
