#include <gtest/gtest.h>

#include <algorithm>

#include "diagnosis/two_joint_arm.hpp"

// The largest number of findings.

namespace veridyn {
namespace {

class NamesAndCurves : public TwoJointArm {
 protected:
  Diagnosis diagnosed(const std::vector<std::string>& hidden, int most) const {
    std::vector<std::string> train;
    for (unsigned k = 1; k <= 3; ++k) train.push_back(record(k, hidden));
    const std::string test = record(4, hidden);
    DiagnosisOptions options;
    options.identification.threads = 1;
    options.max_effects = most;
    return diagnose(read_model("planar-2r"), train, {test}, options);
  }

  static Words names(const Diagnosis& d) {
    Words out;
    for (const Finding& f : d.findings) {
      if (!f.shape) out.push_back(to_text(*d.baseline.model, f.cause));
    }
    std::sort(out.begin(), out.end());
    return out;
  }
};

TEST_F(NamesAndCurves, WithoutNamesACurveExplainsTheError) {
  const std::vector<std::string> hidden = {"end_stop:shoulder:stiffness=60,centre=0,reach=0.7,side=1"};
  const Diagnosis one = diagnosed(hidden, 1);
  EXPECT_EQ(names(one), Words{"end_stop:shoulder"}) << one.report();
  const Diagnosis none = diagnosed(hidden, 0);
  EXPECT_TRUE(names(none).empty()) << none.report();
  EXPECT_EQ(none.joints[0].state, JointState::kUnnamed) << none.report();
}

TEST_F(NamesAndCurves, AreNotMoreThanTheOptionAllows) {
  const std::vector<std::string> hidden = {"end_stop:shoulder:stiffness=60,centre=0,reach=0.7,side=1",
                                           "quadratic_drag:elbow:coefficient=0.6"};
  EXPECT_EQ(names(diagnosed(hidden, 2)), (Words{"end_stop:shoulder", "quadratic_drag:elbow"}));
  const Diagnosis one = diagnosed(hidden, 1);
  EXPECT_EQ(names(one).size(), 1U) << one.report();
}

}  // namespace
}  // namespace veridyn
