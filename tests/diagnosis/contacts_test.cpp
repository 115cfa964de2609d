#include "diagnosis/findings/contacts.hpp"

#include <gtest/gtest.h>

#include "veridyn/files/model_file.hpp"

// Contacts: rows that are left out, and the words of the finding.

namespace veridyn {
namespace {

Contact push(int joint, double from, double to, double effort) {
  Contact out;
  out.source = "push.csv";
  out.from = from;
  out.to = to;
  out.last_joint = joint;
  out.effort = VectorXd::Zero(2);
  out.effort[joint] = effort;
  out.deviation = 0.05;
  out.peak = 20.0;
  return out;
}

TEST(Contacts, RowsAroundTheContactAreLeftOut) {
  const std::vector<ExcludedInterval> rows = excluded_intervals({push(1, 12.0, 13.0, 1.0)});
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].source, "push.csv");
  EXPECT_FALSE(rows[0].joint);
  EXPECT_LT(rows[0].from, 12.0);
  EXPECT_GT(rows[0].to, 13.0);
}

TEST(Contacts, FindingsGiveTimePlaceAndForce) {
  Identification id;
  id.model = read_model("planar-2r");
  id.test_error.relative = Eigen::Vector2d(0.3, 0.2);
  id.test_without_excluded.relative = Eigen::Vector2d(0.1, 0.1);
  const std::vector<Finding> findings = findings_of({push(1, 12.0, 13.0, -1.4), push(0, 21.0, 21.6, -2.0), push(1, 30.0, 31.0, -1.0)}, id);
  ASSERT_EQ(findings.size(), 2U);  // one of each link
  const Finding& f = findings[0];
  EXPECT_EQ(f.joint, JointIndex{1});
  EXPECT_EQ(f.source, "push.csv");
  ASSERT_EQ(f.parameters.size(), 8U);
  EXPECT_EQ(f.parameters[5].name, "from_2");
  EXPECT_EQ(f.parameters[5].value, 30.0);
  EXPECT_LT(f.parameters[0].low, -1.4);
  EXPECT_GT(f.parameters[0].high, -1.4);
  EXPECT_GT(f.parameters[0].low, -2.0);
  EXPECT_NEAR(f.parameters[1].value, 12.0, 0.05);
  EXPECT_NEAR(f.parameters[2].value, 13.0, 0.05);
  EXPECT_LT(f.p_value, 1e-3);
  EXPECT_EQ(f.test_before, id.test_error.relative);
  EXPECT_EQ(f.test_outside, id.test_without_excluded.relative);
  EXPECT_NE(f.phrase.find("pushes the arm on link fore or beyond it"), std::string::npos) << f.phrase;
}

}  // namespace
}  // namespace veridyn
