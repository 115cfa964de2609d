#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <utility>

#include "diagnosis/causes/geometry.hpp"
#include "diagnosis/shapes/refinement.hpp"
#include "diagnosis/shapes/shape_search.hpp"
#include "diagnosis/stage_support.hpp"
#include "veridyn/files/model_file.hpp"

// Stages that look for one kind of fault each, and the search for constants.

namespace veridyn {
namespace {

const QualityFinding* quality(const Diagnosis& d, const std::string& name) {
  for (const RecordingQuality& q : d.data_quality) {
    for (const QualityFinding& f : q.findings) {
      if (f.finding == name) return &f;
    }
  }
  return nullptr;
}

TEST_F(Stages, ATorqueWithTheWrongSignIsAFault) {
  double deviations = 0.0;
  for (const double sign : {1.0, -1.0, -100.0}) {
    DiagnosisState x = investigation(read_model("planar-2r"), {});
    for (const auto* list : {&x.train, &x.test}) {
      for (const std::string& path : *list) {
        Recording r = read_recording(path);
        r.tau *= std::abs(sign);  // in N cm the friction is the same number of standard deviations below zero
        if (sign < 0.0) r.tau.col(1) *= -1.0;
        write_recording(r, path);
      }
    }
    check_quality(x);
    ASSERT_TRUE(fit_baseline(x));
    check_torque_signs(x);
    const QualityFinding* found = quality(x.d, "torque_sign");
    ASSERT_EQ(found != nullptr, sign < 0.0);
    if (found == nullptr) continue;
    EXPECT_EQ(found->joint, 2);
    EXPECT_EQ(found->severity, Severity::kFault);
    if (deviations != 0.0) {
      EXPECT_NEAR(found->value, deviations, 1e-3 * std::abs(deviations));
    }
    deviations = found->value;
  }
}

// What the signals have wrong is said first, and causes are asked about all the same.
TEST_F(Stages, ExchangedTorquesAreSaidFirst) {
  for (const bool exchanged : {false, true}) {
    DiagnosisState x = investigation(truth_, {});
    for (size_t k = 0; k < x.train.size(); ++k) {
      Recording r = read_recording(x.train[k]);
      if (exchanged) r.tau.col(0).swap(r.tau.col(1));
      write_recording(r, x.train[k]);
    }
    const Diagnosis d = diagnose(truth_, x.train, x.test, x.options);
    EXPECT_EQ(quality(d, "swapped_joints") != nullptr, exchanged);
    EXPECT_EQ(d.verdict().rfind("The torques of joint 1 (shoulder) and joint 2 (elbow) are swapped", 0) == 0, exchanged) << d.verdict();
    EXPECT_EQ(d.verdict().find("As recorded: ") != std::string::npos, exchanged) << d.verdict();
    ASSERT_EQ(d.joints.size(), 2U);
  }
}

// Of an arm in a plane the zero of the first encoder does the same: only gravity is asked about.
TEST_F(Stages, GravityThatPointsElsewhereIsATurnAndNoLean) {
  DiagnosisState x = investigation(truth_, {});
  x.options.effects = {"gravity_tilt"};
  ModelDescription turned = truth_.description();
  turned.gravity = -turned.gravity;
  turned.values = RobotValues::kFacts;
  const Diagnosis d = diagnose(Model(std::move(turned)), x.train, x.test, x.options);
  ASSERT_FALSE(d.findings.empty());
  const Finding& f = d.findings.front();
  EXPECT_EQ(effect_of(f.cause), "gravity_tilt");
  EXPECT_NE(f.phrase.find("gravity along (0, -9.81, 0) m/s^2"), std::string::npos) << f.phrase;
}

TEST_F(Stages, AWrongLengthIsFoundAndCorrected) {
  const Model right = read_model("planar-2r");
  ModelFileOptions longer;
  longer.constants["l1"] = 0.6;
  for (const bool wrong : {false, true}) {
    DiagnosisState x = investigation(
        wrong ? read_model("planar-2r", longer) : right, {});
    correct_constants(x);
    ASSERT_EQ(x.d.findings.size(), wrong ? 1U : 0U);
    if (!wrong) continue;
    const Finding& f = x.d.findings[0];
    EXPECT_EQ(to_text(right, f.cause), "coupling_error:upper.a");
    EXPECT_NEAR(f.parameters[0].value, 0.5, 0.01);
    EXPECT_LT(f.parameters[0].low, 0.505);
    EXPECT_GT(f.parameters[0].high, 0.495);
    EXPECT_EQ(f.status, FindingStatus::kConfirmed);
    EXPECT_LT(x.start.test_error.relative.norm(), x.d.baseline.test_error.relative.norm());
  }
}

// An angle of the table and the zero of its encoder do the same; the zero is the commoner fault.
TEST_F(Stages, AnEncodersZeroGoesBeforeTheAngleThatDoesTheSame) {
  DiagnosisState x = investigation(read_model("planar-2r"), {"encoder_offset:shoulder:offset=0.1"});
  correct_constants(x);
  ASSERT_EQ(x.d.findings.size(), 1U);
  const Finding& f = x.d.findings[0];
  EXPECT_EQ(to_text(x.arm, f.cause), "encoder_offset:shoulder");
  EXPECT_NEAR(f.parameters[0].value, 0.1, 0.002);
  EXPECT_LT(f.parameters[0].low, 0.1);
  EXPECT_GT(f.parameters[0].high, 0.1);
  EXPECT_LT(f.p_value, 1e-3);
  ASSERT_FALSE(f.rivals.empty());
  EXPECT_TRUE(std::holds_alternative<KinematicError>(f.rivals[0].cause));
  EXPECT_NEAR(x.start.model->coordinates()[0].recorded.position_offset, 0.1, 0.002);
}

// Learned on an arm with another length, held out on one that is as the file says: it is found all the
// same, and said to be contradicted.
TEST_F(Stages, AHeldOutRecordingMeasuresALengthAndDoesNotChooseIt) {
  ModelFileOptions longer;
  longer.constants["l1"] = 0.6;
  const Model file = read_model("planar-2r", longer);
  Model as_the_file = plausible_model(file, 3).arm;
  DiagnosisState x{file, {}, {}, {}, {}, {}, 0, {}, {}, {}};
  for (unsigned k = 1; k <= 4; ++k) x.train.push_back(record(k, {}));
  std::swap(truth_, as_the_file);
  x.test = {record(5, {})};
  std::swap(truth_, as_the_file);
  x.options.identification.threads = 1;
  ASSERT_TRUE(fit_baseline(x));
  correct_constants(x);
  ASSERT_EQ(x.d.findings.size(), 1U);
  EXPECT_EQ(x.d.findings[0].status, FindingStatus::kConfirmed);
  EXPECT_EQ(x.d.findings[0].held_out(), Agreement::kContradicts);
}

// Friction with a memory and a force on no list, against what a broken sensor gives: the model that is
// written and every status are those of the training recordings.
TEST_F(Stages, HeldOutRowsChangeNothingThatIsChosen) {
  const std::vector<std::string> hidden = {"presliding_hysteresis:shoulder:level=3,distance=0.04",
                                           "joint_spring:2"};
  std::vector<std::string> train;
  for (unsigned k = 1; k <= 4; ++k) train.push_back(record(k, hidden));
  const std::string sound = record(5, hidden);
  Recording turned = read_recording(sound);
  turned.tau *= -0.5;
  const std::string broken = folder_.path("broken.csv");
  write_recording(turned, broken);
  const auto chosen = [&](const std::string& test) {
    DiagnosisOptions options;
    options.effects = {"presliding_hysteresis", "joint_spring", "coulomb_friction", "position_force"};
    options.identification.threads = 1;
    const Diagnosis d = diagnose(read_model("planar-2r"), train, {test}, options);
    std::set<std::string> out;
    for (const Finding& f : d.findings) out.insert(to_text(truth_, f.cause) + " " + name_of(f.status));
    return std::make_pair(out, to_yaml(*d.extended.model));
  };
  const auto [causes, model] = chosen(sound);
  const auto [causes_again, model_again] = chosen(broken);
  EXPECT_GE(causes.size(), 2U);
  EXPECT_EQ(causes, causes_again);
  EXPECT_EQ(model, model_again);
}

// From a grid to the hidden distance.
TEST_F(Stages, AConstantIsRefinedFromTheGridToTheTruth) {
  DiagnosisState x = investigation(read_model("planar-2r"),
                                  {"presliding_hysteresis:shoulder:level=3,distance=0.04"});
  x.options.max_effects = 1;
  CandidateList list = x.list();
  list.wanted = {"presliding_hysteresis", "joint_spring"};
  const CandidateTests asked = prepare_tests(x, list, x.start);
  EXPECT_EQ(asked.q.train.size(), x.train.size());
  EXPECT_LE(blocks_that_fit(x.arm, 4000), blocks_that_fit(x.arm, 4));
  for (const Hypothesis& h : asked.q.augmented.hypotheses)
    EXPECT_EQ(has_searched_shape(asked.q, h), effect_of(h.cause) != "joint_spring") << effect_of(h.cause);
  Selection selection =
      select_effects(asked.data, asked.q.base, asked.q.augmented.hypotheses, x.options);
  ASSERT_EQ(selection.accepted.size(), 1U);
  const auto distance_of = [](const AugmentedModel& model, int k) {
    return term_of(model.model, model.hypotheses[k]).values.at("distance");
  };
  const double coarse =
      distance_of(asked.q.augmented, selection.accepted[0].evidence.hypothesis);
  const Fit fit = fit_accepted(x.start, asked.q, selection, false, x.train, x.test, x.options);
  ASSERT_EQ(fit.candidate_data.augmented.hypotheses.size(), 1U);
  const double fine = distance_of(fit.candidate_data.augmented, 0);
  EXPECT_GT(std::abs(coarse - 0.04), 0.005);  // the grid does not have it
  EXPECT_NEAR(fine, 0.04, 0.004);
  ASSERT_EQ(fit.selection.shapes.size(), 1U);
  EXPECT_LT(fit.selection.shapes[0].low, fine);
  EXPECT_GT(fit.selection.shapes[0].high, fine);
  // A rival with a constant of its own is refined in the accepted one's place.
  Selection rivalled = selection;
  rivalled.accepted[0].rivals = {selection.accepted[0].evidence};
  EXPECT_TRUE(refined_rivals(x.start, asked.q, rivalled, false, x.train, x.options.identification)
                  .empty());  // itself is none
  int other = 0;
  while (other == selection.accepted[0].evidence.hypothesis ||
         !has_searched_shape(asked.q, asked.q.augmented.hypotheses[other]))
    ++other;
  rivalled.accepted[0].rivals[0].hypothesis = other;
  const auto rivals =
      refined_rivals(x.start, asked.q, rivalled, false, x.train, x.options.identification);
  ASSERT_EQ(rivals.size(), 1U);
  EXPECT_TRUE(same_candidate(rivals[0].first,
                             asked.q.augmented.hypotheses[other]));
}

// A memory of one joint, accepted with the value of the grid nearest to the hidden one.
class Memories : public Stages {
 protected:
  // Accepted: hysteresis of the shoulder with the grid's distance nearest to this one.
  Selection accepted(const CandidateTests& asked, double distance) const {
    int nearest = -1;
    double least = 0.0;
    for (size_t k = 0; k < asked.q.augmented.hypotheses.size(); ++k) {
      const Hypothesis& h = asked.q.augmented.hypotheses[k];
      if (h.joint != JointIndex{0}) continue;
      const double away =
          std::abs(std::log(term_of(asked.q.augmented.model, h).values.at("distance") / distance));
      if (nearest >= 0 && away >= least) continue;
      nearest = static_cast<int>(k);
      least = away;
    }
    Evidence e;
    e.hypothesis = nearest;
    Selection out;
    out.accepted.push_back({e});
    return out;
  }

  Fit fit(const std::vector<std::string>& hidden, double distance) const {
    DiagnosisState x = investigation(read_model("planar-2r"), hidden);
    CandidateList list = x.list();
    list.wanted = {"presliding_hysteresis"};
    const CandidateTests asked = prepare_tests(x, list, x.start);
    Selection selection = accepted(asked, distance);
    return fit_accepted(x.start, asked.q, selection, false, x.train, x.test, x.options);
  }
};

// A constant of a strong effect is known to what the search leaves open, that of a weak one less well.
TEST_F(Memories, TheIntervalOfAConstantGrowsWithTheNoise) {
  std::vector<double> widths;
  for (const char* level : {"3", "0.2"}) {
    const Fit found =
        fit({std::string("presliding_hysteresis:shoulder:distance=0.04,level=") + level}, 0.04);
    ASSERT_EQ(found.selection.shapes.size(), 1U) << level;
    const ShapeInterval& interval = found.selection.shapes[0];
    EXPECT_EQ(interval.shape, "distance");
    EXPECT_LT(interval.low, 0.04) << level;
    EXPECT_GT(interval.high, 0.04) << level;
    widths.push_back(std::log(interval.high / interval.low));
  }
  EXPECT_GE(widths[0], 2.0 * numerics::kShapeOpen);
  EXPECT_GT(widths[1], 1.5 * widths[0]);
  EXPECT_LT(widths[1], 2.0);
}

}  // namespace
}  // namespace veridyn
