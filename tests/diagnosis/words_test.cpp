#include <gtest/gtest.h>

#include <cctype>
#include <limits>
#include <sstream>

#include "diagnosis/findings/finding_words.hpp"
#include "diagnosis/findings/next_experiment.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/regressor/standard_parameters.hpp"

// The words of findings, and the next experiment.

namespace veridyn {
namespace {

Finding finding(Cause cause, const std::string& phrase) {
  Finding f;
  f.cause = std::move(cause);
  f.joint = acting_joint(read_model("planar-2r"), f.cause);
  f.phrase = phrase;
  return f;
}

TEST(FindingWords, EveryKindOfCauseHasASentence) {
  const Model arm = read_model("planar-2r");
  const auto said = [&arm](Cause cause, const std::string& phrase) {
    return sentence(arm, finding(std::move(cause), phrase));
  };
  EXPECT_EQ(said(NewEffect{"joint_spring", {1}}, "a spring"), "Joint 2 (elbow): a spring.");
  EXPECT_EQ(said(ChangedEffect{"joint_spring", {0}}, "it changed"),
            "Joint 1 (shoulder): it changed.");
  EXPECT_EQ(said(AddedLoad{{1}}, "a load of 1 kg"), "A load of 1 kg sits on fore.");
  EXPECT_EQ(said(ChannelError{"time_delay", {}}, "a delay"), "The arm has a delay.");
  EXPECT_EQ(said(ChannelError{"time_delay", JointIndex{1}}, "a delay"),
            "Joint 2 (elbow) has a delay.");
  EXPECT_EQ(said(KinematicError{FrameConstant{{0}, FrameNumber::kA}}, "a of frame upper is 1 m there"),
            "The robot file has a wrong constant: a of frame upper is 1 m there.");
  Finding contact = finding(ExternalContact{{1}}, "something pushes");
  contact.source = "one.csv";
  EXPECT_EQ(sentence(arm, contact), "one.csv: something pushes.");
  Finding large = finding(ChannelError{"time_delay", {}}, "a delay");
  large.remark = "That is large.";
  EXPECT_EQ(sentence(arm, large), "The arm has a delay. That is large.");
}

TEST(FindingWords, RefittingUpdatesValuesAndNeverNarrowsIntervals) {
  Identification id;
  id.model = read_model("planar-2r");
  const std::vector<std::string> names = parameter_names(standard_parameters(*id.model));
  const auto count = static_cast<Eigen::Index>(names.size());
  id.parameters = VectorXd::LinSpaced(count, 1.0, static_cast<double>(count));
  id.parameter_deviations = VectorXd::Constant(count, 1e-3);
  id.effective_samples = 1000.0;
  Finding f = finding(NewEffect{"viscous_friction", {0}}, "");
  f.parameters = {{"coefficient", "", 0.0, -0.5, 0.5}};
  refresh(id, {names[4]}, f);
  EXPECT_DOUBLE_EQ(f.parameters[0].value, 5.0);
  EXPECT_DOUBLE_EQ(f.parameters[0].low, 4.5);
  id.parameter_deviations[4] = 1.0;
  refresh(id, {names[4]}, f);
  EXPECT_NEAR(f.parameters[0].high, 5.0 + 1.96, 0.01);
}

TEST(FindingWords, AFitWithoutTheParameterChangesNothing) {
  Finding f = finding(NewEffect{"viscous_friction", {0}}, "as before");
  f.parameters = {{"coefficient", "", 0.3, 0.2, 0.4}};
  Identification id;
  refresh(id, {"no_model"}, f);
  id.model = read_model("planar-2r");
  const std::vector<std::string> names = parameter_names(standard_parameters(*id.model));
  refresh(id, {names[4]}, f);  // no fit
  const auto count = static_cast<Eigen::Index>(names.size());
  id.parameters = VectorXd::Constant(count, 7.0);
  id.parameter_deviations = VectorXd::Constant(count, std::numeric_limits<double>::quiet_NaN());
  id.effective_samples = 100.0;
  refresh(id, {names[4]}, f);  // it does not know how well
  refresh(id, {"another"}, f);
  EXPECT_EQ(f.parameters[0].value, 0.3);
  EXPECT_EQ(f.parameters[0].low, 0.2);
  EXPECT_EQ(f.phrase, "as before");
}

// For a cause on one joint the sum and that joint count; for a wrong zero or constant the sum alone.
TEST(FindingWords, TheStatusDependsOnTheJointThatACauseActsOn) {
  const auto status = [](Cause cause) {
    Finding f = finding(std::move(cause), "");
    f.folds_before = Eigen::Vector2d(0.2, 0.2);
    f.folds_after = Eigen::Vector2d(0.21, 0.1);  // joint 1 is worse, the sum is better
    return status_of(f);
  };
  EXPECT_EQ(status(NewEffect{"joint_spring", {0}}), FindingStatus::kNotConfirmed);
  EXPECT_EQ(status(NewEffect{"joint_spring", {1}}), FindingStatus::kConfirmed);
  EXPECT_EQ(status(ChannelError{"torque_gain", JointIndex{0}}), FindingStatus::kNotConfirmed);
  EXPECT_EQ(status(ChannelError{"encoder_offset", JointIndex{0}}), FindingStatus::kConfirmed);
  EXPECT_EQ(status(KinematicError{JointZero{{0}}}), FindingStatus::kConfirmed);
}

Diagnosis with_rival(Cause cause, Cause rival) {
  Diagnosis d;
  d.baseline.model = read_model("planar-2r");
  d.findings = {finding(std::move(cause), "something")};
  d.findings[0].rivals = {{std::move(rival), "as good"}};
  return d;
}

TEST(NextExperiment, IsForTheFirstPairThatAMotionCanSeparate) {
  const Model arm = read_model("planar-2r");
  const NextExperiment load =
      next_experiment(with_rival(AddedLoad{{1}}, ChannelError{"torque_gain", JointIndex{1}}));
  ASSERT_EQ(load.between.size(), 2U);
  EXPECT_EQ(to_text(arm, load.between[0]), "payload:fore");
  EXPECT_EQ(to_text(arm, load.between[1]), "torque_gain:elbow");
  EXPECT_EQ(load.words(arm, 0), "payload on fore");
  EXPECT_EQ(load.words(arm, 1), "torque_gain on joint 2");
  EXPECT_EQ(load.slow_passes, 0);
  EXPECT_GT(next_experiment(with_rival(NewEffect{"backlash", {0}},
                                       NewEffect{"presliding_hysteresis", {0}}))
                .slow_passes,
            0);
  // The same cause on another joint, and causes that no motion can separate.
  EXPECT_TRUE(next_experiment(with_rival(NewEffect{"backlash", {0}}, NewEffect{"backlash", {1}}))
                  .between.empty());
  EXPECT_TRUE(next_experiment(with_rival(ChannelError{"encoder_offset", JointIndex{0}},
                                         KinematicError{JointZero{{0}}}))
                  .between.empty());
}

// A curve over positions, or over the travel since a reversal, needs slow motion.
TEST(NextExperiment, IsForTheFirstCurveIfThereIsNothingToSeparate) {
  Diagnosis d = with_rival(NewEffect{"backlash", {0}}, NewEffect{"backlash", {1}});
  EXPECT_TRUE(next_experiment(d).shows.empty());
  for (const char* signal : {"q2", "history1", "dq1", "tau1"}) {
    Finding curve = finding(NewEffect{"backlash", {0}}, "something");
    curve.shape.emplace();
    curve.shape->signals = {"t", signal};
    d.findings = {with_rival(NewEffect{"backlash", {0}}, NewEffect{"backlash", {1}}).findings[0], curve, curve};
    const NextExperiment next = next_experiment(d);
    EXPECT_EQ(next.shows, std::string("what joint 1 depends on over t and ") + signal);
    EXPECT_EQ(next.slow_passes > 0, signal[0] == 'q' || signal[0] == 'h') << signal;
    d.next_experiment = next;
    EXPECT_NE(d.report("excite it").find("next experiment, to show " + next.shows + ":\n  excite it\n"), std::string::npos);
    EXPECT_NE(d.report().find("next experiment, to show " + next.shows + "\n"), std::string::npos);
  }
  d.findings[0].rivals = {{NewEffect{"presliding_hysteresis", {0}}, "as good"}};
  EXPECT_TRUE(next_experiment(d).shows.empty());  // what is to be separated goes first
}

// A load of which torques tell a moment alone.
TEST(DiagnosisReport, PrintsNoMassThatMayBeAnything) {
  Diagnosis d = with_rival(NewEffect{"backlash", {0}}, NewEffect{"backlash", {1}});
  d.findings[0].parameters = {{"mass", "kg", 0.0, -64.0, 64.0}, {"moment", "kg m", 0.017, 0.015, 0.02}};
  EXPECT_EQ(d.report().find("mass ="), std::string::npos) << d.report();
  EXPECT_NE(d.report().find("moment = 0.017"), std::string::npos) << d.report();
  d.findings[0].parameters[0].low = 1.0;
  EXPECT_NE(d.report().find("mass ="), std::string::npos) << d.report();
}

TEST(DiagnosisReport, NamesTheLimitsOfTheRecordings) {
  Diagnosis d = with_rival(NewEffect{"backlash", {0}}, NewEffect{"backlash", {1}});
  EXPECT_EQ(d.report().find("provisional"), std::string::npos);
  d.provisional = true;
  d.moving_as_one = {{{0}, {1}}};
  d.remarks = {"a word"};
  d.changes = true;
  RecordingQuality quality;
  quality.file = "one.csv";
  QualityFinding info, warning;
  info.sentence = "a fact";
  info.severity = Severity::kInfo;
  warning.sentence = "a warning";
  warning.severity = Severity::kWarning;
  quality.findings = {info, warning};
  d.data_quality = {quality};
  const std::string report = d.report();
  for (const char* words : {"one recording to learn from: names are provisional\n", "joints 1 and 2 move as one in all training recordings",
                            "remark: a word\n", "\nwhat changed since the model was made:\n", "recording one.csv: a warning\n"})
    EXPECT_NE(report.find(words), std::string::npos) << words << "\n" << report;
  EXPECT_EQ(report.find("a fact"), std::string::npos);
}

// What is wrong with the recordings whatever the arm is precedes causes, which it may imitate.
TEST(DiagnosisReport, BeginsWithAWrongClockAndWithACopiedColumn) {
  for (const QualityKind kind : {QualityKind::kRateContradiction, QualityKind::kSameColumn, QualityKind::kSampleRate}) {
    Diagnosis d = with_rival(NewEffect{"backlash", {0}}, NewEffect{"backlash", {1}});
    QualityFinding fault;
    fault.kind = kind;
    fault.sentence = "a fault.";
    fault.severity = Severity::kFault;
    d.data_quality = {RecordingQuality{}};
    d.data_quality[0].findings = {fault};
    d.data_quality.push_back(d.data_quality[0]);
    d.data_quality[1].findings[0].sentence = "the same with another number.";
    EXPECT_EQ(d.verdict().find("a fault. As recorded: ") == 0, kind != QualityKind::kSampleRate) << d.verdict();
  }
}

// Against a MODEL the held-out recordings alone do not show that nothing has changed.
TEST(DiagnosisReport, NamesARecordingInWhichAModelFailsAlone) {
  Diagnosis d = with_rival(NewEffect{"backlash", {0}}, NewEffect{"backlash", {1}});
  d.findings.clear();
  d.joints = {};
  d.changes = true;
  const auto with = [](const char* source, double error) {
    RecordingError r;
    r.source = source;
    r.error.relative = Eigen::Vector2d(0.004, error);
    return r;
  };
  d.baseline.train = {with("one.csv", 0.005), with("two.csv", 0.3)};
  d.baseline.test = {with("three.csv", 0.006)};
  EXPECT_EQ(d.verdict().find("nothing has changed in the held-out recordings, but two.csv differs from the other recordings: the model leaves 30 % of the torque of elbow in two.csv, 0.5 % in one.csv."), 0U)
      << d.verdict();
  for (const double error : {0.02, 0.005}) {
    d.baseline.train[1] = with("two.csv", error);
    EXPECT_EQ(d.verdict(), "nothing has changed");
  }
  // Beside a finding it differs all the same.
  d.baseline.train[1] = with("two.csv", 0.3);
  d.findings = with_rival(NewEffect{"backlash", {0}}, NewEffect{"backlash", {1}}).findings;
  EXPECT_NE(d.verdict().find(" But two.csv differs from the other recordings: "), std::string::npos) << d.verdict();
  d.findings.clear();
  // A model that explains a joint nowhere tells no recordings apart.
  d.baseline.train = {with("one.csv", 0.05), with("two.csv", 0.3)};
  d.baseline.test = {with("three.csv", 0.06)};
  EXPECT_EQ(d.verdict(), "nothing has changed");
}

// A contact is no error of the model and has no share of the removable error.
TEST(DiagnosisReport, GivesTheErrorsOutsideOfAContact) {
  Diagnosis d = with_rival(NewEffect{"backlash", {0}}, NewEffect{"backlash", {1}});
  d.findings = {finding(ExternalContact{{1}}, "something pushes")};
  d.findings[0].source = "one.csv";
  d.findings[0].test_before = d.findings[0].test_after = Eigen::Vector2d(0.31, 0.42);
  d.findings[0].test_outside = Eigen::Vector2d(0.11, 0.12);
  const std::string report = d.report();
  EXPECT_NE(report.find("held-out error outside of what is left out, %:"), std::string::npos) << report;
  EXPECT_NE(report.find("11.00"), std::string::npos) << report;
  EXPECT_EQ(report.find("31.00"), std::string::npos) << report;
  EXPECT_EQ(report.find("removable"), std::string::npos) << report;
}

TEST(DiagnosisReport, ListsFindingsRivalsAndOpenQuestions) {
  Diagnosis d = with_rival(NewEffect{"backlash", {1}}, AddedLoad{{1}});
  d.findings[0].rank = 1;
  d.findings[0].explains = 0.25;
  d.cannot_tell = {{"joint_spring", NewEffect{"joint_spring", {0}}, "it never acts"},
                   {"joint_spring", NewEffect{"joint_spring", {0}}, "it never acts"},
                   {"joint_spring", NewEffect{"joint_spring", {1}}, "it never acts"},
                   {AddedLoad::kName, std::nullopt, "no model from before"}};
  d.next_experiment.between = {d.findings[0].cause, d.findings[0].rivals[0].cause};
  d.summary.main = 1;
  const std::string report = d.report("excite it");
  for (const char* words :
       {"1. Joint 2 (elbow): something.", "explains 25 %", "rival: payload on fore: as good",
        "to separate backlash on joint 2 from payload on fore:\n  excite it",
        "cannot tell: joint_spring on joint 1 (shoulder), on joint 2 (elbow): it never acts\n",
        "cannot tell: payload: no model from before"})
    EXPECT_NE(report.find(words), std::string::npos) << words << "\n" << report;
  EXPECT_EQ(d.verdict(), "Joint 2 (elbow): something. The recordings cannot tell it from payload on fore.");
  d.findings[0].rivals[0].share = 0.99;
  EXPECT_EQ(d.verdict(), "Joint 2 (elbow): something.");
}

TEST(DiagnosisReport, TheStateOfAJointAgreesWithItsNumbers) {
  Diagnosis d = with_rival(NewEffect{"backlash", {1}}, AddedLoad{{1}});
  JointVerdict v;
  v.joint = {1};
  v.held_out = 0.2008;
  v.floor = 0.0054;
  v.removable = 0.1954;
  v.extended = 0.0134;
  v.left = 0.0081;
  v.state = JointState::kNamed;
  d.joints = {v};
  EXPECT_NE(d.report().find("19.54: named in part (18.74 with names, 0.53 without, 0.27 left)"), std::string::npos) << d.report();
  d.joints[0].extended = d.joints[0].left = v.floor;
  EXPECT_NE(d.report().find("19.54: named (19.54 with names, 0.00 without, 0.00 left)"), std::string::npos) << d.report();
}

// A small finding between two main ones makes the errors of the latter jump.
TEST(DiagnosisReport, ExplainsJumpsOfErrorsAndPrintsNoShareOfZero) {
  Diagnosis d = with_rival(NewEffect{"backlash", {1}}, AddedLoad{{1}});
  d.findings[0].status = FindingStatus::kConfirmed;
  d.findings[0].explains = 0.004;
  d.findings[0].test_before = Eigen::Vector2d(0.2, 0.3);
  d.findings[0].test_after = Eigen::Vector2d(0.2, 0.25);
  d.findings.push_back(d.findings[0]);
  d.findings[1].test_before = d.findings[0].test_after;
  d.findings.push_back(d.findings[0]);
  d.findings[2].main = false;
  d.summary.main = 2;
  d.summary.explained_by_main = d.summary.explained_by_all = 0.3;
  EXPECT_NE(d.report().find("explains less than 1 % of"), std::string::npos) << d.report();
  EXPECT_EQ(d.report().find(" 0 %"), std::string::npos) << d.report();
  EXPECT_NE(d.report().find("\nmore:\n"), std::string::npos) << d.report();
  d.findings[1].test_before = Eigen::Vector2d(0.2, 0.24);
  EXPECT_NE(d.report().find("\nmore, which came between"), std::string::npos) << d.report();
}

TEST(DiagnosisReport, PlacesAreJointsFramesOrTheWholeArm) {
  Diagnosis d = with_rival(NewEffect{"backlash", {1}}, ChannelError{"time_delay", {}});
  d.findings[0].rivals.push_back({ChannelError{"time_delay", JointIndex{0}}, "as good"});
  d.findings[0].main = true;
  d.cannot_tell = {{"time_delay", ChannelError{"time_delay", {}}, "nothing moves"},
                   {AddedLoad::kName, AddedLoad{{1}}, "nothing moves"}};
  const std::string report = d.report();
  for (const char* words :
       {"rival: time_delay of the whole arm: as good", "rival: time_delay on joint 1 (shoulder): as good",
        "cannot tell: time_delay of the whole arm: nothing moves", "cannot tell: payload on joint 2 (elbow): nothing moves"})
    EXPECT_NE(report.find(words), std::string::npos) << words << "\n" << report;
}

std::vector<std::string> lines_of(const std::string& report, size_t from) {
  std::istringstream text(report.substr(from));
  std::vector<std::string> out;
  for (std::string line; std::getline(text, line) && !line.empty();) out.push_back(line);
  return out;
}

TEST(DiagnosisReport, ErrorsAreAlignedWithTheNamesOfTheirJointsHoweverLong) {
  for (const char* robot : {"planar-2r", "ur10e"}) {
    Diagnosis d;
    d.baseline.model = read_model(robot);
    const int joints = d.baseline.model->joints();
    d.baseline.test_error.relative = VectorXd::LinSpaced(joints, 0.01, 1.2345);
    d.extended.test_error.relative = VectorXd::LinSpaced(joints, 0.02, 0.9);
    const std::string report = d.report();
    const std::vector<std::string> lines = lines_of(report, report.find("  held out, baseline"));
    ASSERT_GE(lines.size(), 2U) << report;
    const size_t at = report.rfind('\n', report.find("  held out, baseline") - 2) + 1;
    const std::string header = lines_of(report, at).front();
    for (const Coordinate& c : d.baseline.model->coordinates()) {
      const size_t begins = header.find(" " + c.name);
      ASSERT_NE(begins, std::string::npos) << header;
      const size_t end = begins + 1 + c.name.size();
      EXPECT_TRUE(end == header.size() || header[end] == ' ') << header;
      for (size_t k = 0; k < 2; ++k) {
        EXPECT_TRUE(std::isdigit(lines[k][end - 1])) << lines[k];
        EXPECT_TRUE(lines[k].size() == end || lines[k][end] == ' ') << lines[k];
      }
    }
    EXPECT_EQ(header.size(), lines[0].size());
  }
}

}  // namespace
}  // namespace veridyn
