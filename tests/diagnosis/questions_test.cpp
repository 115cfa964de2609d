#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/candidates.hpp"
#include "diagnosis/search/channel_words.hpp"
#include "diagnosis/search/row_constants.hpp"
#include "effects/kinematic_error.hpp"
#include "veridyn/files/model_file.hpp"

// Links, channels and constants of an arm that a diagnosis tests.

namespace veridyn {
namespace {

TEST(Candidates, FramesThatAreFixedToEachOtherAreOneLink) {
  const Model arm = read_model("psm-3dof");
  const std::vector<FrameIndex> frames = payload_frames(arm);
  for (size_t a = 0; a < frames.size(); ++a) {
    for (size_t b = 0; b < a; ++b) EXPECT_FALSE(same_link(arm, frames[a], frames[b]));
  }
  for (int k = 0; k < static_cast<int>(arm.frames().size()); ++k) {
    const bool moves = arm.moves({k}, {0}) || arm.moves({k}, {1}) || arm.moves({k}, {2});
    EXPECT_EQ(std::count_if(frames.begin(), frames.end(),
                            [&](FrameIndex other) { return moves && same_link(arm, {k}, other); }),
              moves ? 1 : 0);
  }
}

TEST(EffectFacts, ComeFromTheEffects) {
  EXPECT_TRUE(is_friction("coulomb_friction"));
  EXPECT_FALSE(is_friction("joint_spring"));
  EXPECT_FALSE(is_friction("payload"));
}

TEST(EffectFacts, ZerosAreLengthsOfPrismaticAndAnglesOfRevoluteJoints) {
  const Model arm = read_model("psm-3dof");
  int slides = 0;
  for (int i = 0; i < arm.joints(); ++i) {
    EffectTerm term;
    term.effect = "encoder_offset";
    term.axis.coefficients = VectorXd::Unit(arm.joints(), i);
    const bool slide = arm.coordinates()[i].prismatic;
    slides += static_cast<int>(slide);
    const std::string words = channel_phrase(arm, term, {0.002});
    EXPECT_NE(words.find(slide ? "2 mm too large" : "2 mrad too large"), std::string::npos) << words;
  }
  EXPECT_EQ(slides, 1);
}

TEST(Geometry, ConstantsOfRowsAreReadAndReplaced) {
  const Model arm = read_model("planar-2r");
  const std::vector<FrameConstant> constants = row_constants(arm);
  ASSERT_EQ(constants.size(), 8U);  // four for each of two frames
  for (const FrameConstant& c : constants) {
    const Model other = with_constant(arm, c, value_in(arm, c) + 0.1);
    const int frame = c.frame.value;
    const DhRow& row = *other.frames()[frame].dh;
    const DhRow& before = *arm.frames()[frame].dh;
    const double changed = std::abs(row.a - before.a) + std::abs(row.alpha - before.alpha) +
                           std::abs(row.d - before.d) + std::abs(row.theta - before.theta);
    EXPECT_NEAR(changed, 0.1, 1e-12) << words_for(arm, c);
    EXPECT_EQ(words_for(arm, c), name_of(arm, c) + " of frame " + arm.frames()[frame].name);
    EXPECT_EQ(unit_of(c), c.number == FrameNumber::kTheta || c.number == FrameNumber::kAlpha ? "rad" : "m");
    // The text form of the cause is read back.
    EXPECT_TRUE(same_cause(parse_cause(arm, to_text(arm, KinematicError{c})), KinematicError{c})) << words_for(arm, c);
  }
}

}  // namespace
}  // namespace veridyn
