#include "veridyn/kinematics/tree.hpp"

#include <gtest/gtest.h>

#include "support/sample_arms.hpp"

namespace veridyn {
namespace {

class TreeOnEverySampleArm : public OnSampleArm {};
INSTANTIATE_TEST_SUITE_P(Sample, TreeOnEverySampleArm, testing::ValuesIn(sample_arm_names()),
                         sample_arm_name);

TEST_P(TreeOnEverySampleArm, SupportsOfALinkAreTheCoordinatesThatMoveIt) {
  for (const Tree::Keep keep : {Tree::Keep::kEveryFrame, Tree::Keep::kBodiesOnly}) {
    const Tree tree(arm(), keep);
    for (const Link& link : tree.links) {
      std::vector<int> expected;
      for (int i = 0; i < joints(); ++i) {
        if (arm().moves({link.frame}, {i})) expected.push_back(i);
      }
      std::vector<int> movers;
      for (int m = link.first_support; m < link.end_support; ++m) {
        movers.push_back(tree.supports[m].coordinate);
        const int above = tree.supports[m].parent_entry;
        EXPECT_TRUE(above < 0 || tree.supports[above].coordinate == tree.supports[m].coordinate);
        EXPECT_TRUE(above >= 0 || tree.supports[m].coefficient != 0.0)
            << "neither the parent nor the joint moves with it";
      }
      EXPECT_EQ(movers, expected);
    }
  }
}

TEST_P(TreeOnEverySampleArm, EveryFrameIsALinkIfAllAreKept) {
  const Tree tree(arm(), Tree::Keep::kEveryFrame);
  for (size_t k = 0; k < arm().frames().size(); ++k)
    EXPECT_EQ(tree.link_of_frame[k], static_cast<int>(k));
}

TEST_P(TreeOnEverySampleArm, BodiesOfTheTreeAreInTheOrderOfTheModel) {
  const Tree tree(arm());
  ASSERT_EQ(tree.body_links.size(), arm().bodies().size());
  for (size_t b = 0; b < tree.body_links.size(); ++b) {
    EXPECT_EQ(tree.links[tree.body_links[b]].frame, arm().bodies()[b].value);
    EXPECT_EQ(tree.links[tree.body_links[b]].body, static_cast<int>(b));
  }
}

// Of the coupled wrist's frames the fixed base and stand and the empty last one are not needed for
// dynamics.
TEST(Tree, FixedFramesWithoutBodiesAreMerged) {
  const Model arm = sample_arms().at("coupled_wrist");
  const Tree tree(arm);
  EXPECT_EQ(tree.links.size(), arm.frames().size() - 3);
  EXPECT_EQ(tree.link_of_frame[0], -1);
  EXPECT_EQ(tree.link_of_frame[2], -1);
  EXPECT_EQ(tree.link_of_frame.back(), -1);
}

}  // namespace
}  // namespace veridyn
