#include "veridyn/identification/robot_check.hpp"
#include "veridyn/identification/verdict.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <utility>

#include "identification/check/check_thresholds.hpp"
#include "identification/check/quick_fit.hpp"
#include "identification/check/questions.hpp"
#include "math/median.hpp"
#include "math/numbers.hpp"
#include "math/parallel.hpp"
#include "recordings/kept_recordings.hpp"
#include "recordings/recorded_motion.hpp"
#include "recordings/quality/quality_checks.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

/// travel < kWeakly * range and < kNearlyStraight [rad]: gravity along it is nearly a straight line, as a spring is.
constexpr double kWeakly = 0.3, kNearlyStraight = 1.3;
/// relative error of some joint > kAskedAbove: questions are asked of recordings that were identified.
constexpr double kAskedAbove = 0.08;
/// largest gain > kEqualGains * smallest gain: currents are no torques in another unit.
constexpr double kEqualGains = 1.05;
/// drive gain < kLeastGain [N m/A] of some joint: small efforts say nothing about their unit.
constexpr double kLeastGain = 2.0;
/// recorded torque < kBehindGear * that of the file's values, on all joints: in front of gears.
constexpr double kBehindGear = 0.2;

std::string percent(double share) {
  return text(quality::number(100.0 * share), " %");
}

// A set of questions that are answered by yes, and the fit that follows.
struct Answer {
  std::vector<Question> set;
  QuickFit fit;
};

class RobotCheck {
 public:
  RobotCheck(const Model& arm, Recording recording, const PreprocessingOptions& options, const CheckThresholds& limits)
      : given_(arm), options_(options), limits_(limits), recording_(std::move(recording)), fitter_(arm, options, limits) {
    for (const Coordinate& c : arm.coordinates()) names_.push_back(c.name);
    moves_ = quality::Head(recording_, QualityNumbers()).moves;
  }

  std::vector<QualityFinding> run() {
    tell_what_hardly_moves();
    if (!is_identifiable()) return std::move(findings_);
    noise_ = fitter_.noise(recording_);
    best_.fit = fitter_.fit(recording_);
    const double before = best_.fit.left();
    while (static_cast<int>(best_.set.size()) < limits_.most_together && !is_explained(best_.fit) && add_best()) {
    }
    take_gears();
    report(before);
    if (!given_.inertial_values() && best_.set.empty()) warn_of_small_efforts();
    return std::move(findings_);
  }

 private:
  // True if the base parameters are identifiable; otherwise wrong signals would fit as well as
  // right ones.
  bool is_identifiable() {
    if (std::none_of(moves_.begin(), moves_.end(), [](bool moves) { return moves; })) {
      warn_of_small_efforts();
      return false;
    }
    const auto [determined, condition] = fitter_.determined(recording_);
    if (determined >= fitter_.base_size() && condition < limits_.worst_condition) return true;
    add("not_compared", 0, determined,
        text("Signs, order and units of the joints are not compared with ", given_.name(),
             ": the recording ", determined < fitter_.base_size() ? "determines " : "hardly tells apart ",
             determined, " of its ", fitter_.base_size(), " base parameters."));
    findings_.back().severity = Severity::kInfo;
    warn_of_small_efforts();
    return false;
  }

  void tell_what_hardly_moves() {
    for (int i = 0; i < joints() && recording_.rows() > 0; ++i) {
      const Limits& limits = given_.coordinates()[i].limits;
      double lowest = kInfinity, highest = -kInfinity;
      for (const double q : recording_.q.col(i)) {
        if (!std::isfinite(q)) continue;
        lowest = std::min(lowest, q);
        highest = std::max(highest, q);
      }
      const double share = (highest - lowest) / (limits.upper - limits.lower);
      if (!moves(i) || !std::isfinite(limits.upper - limits.lower)) continue;
      const std::string seconds = quality::number(recording_.time[recording_.rows() - 1] - recording_.time[0]);
      const bool hardly = share < kHardlyMoves;
      if (!hardly && (given_.coordinates()[static_cast<size_t>(i)].prismatic || !(share < kWeakly) || !(highest - lowest < kNearlyStraight))) continue;
      add(hardly ? "hardly_moves" : "weak_motion", i + 1, share,
          text("In its first ", seconds, " s ", joint(i), " moves over ", percent(share), " of its range: ",
               hardly ? "little of its friction and inertia can be identified."
                      : "a spring and a load cannot be told apart there, and torques at other angles are extrapolated."));
      findings_.back().severity = Severity::kWarning;
    }
  }

  int joints() const { return given_.joints(); }
  bool moves(int i) const { return moves_[static_cast<size_t>(i)]; }
  std::string joint(int i) const { return text("joint ", i + 1, " (", names_[static_cast<size_t>(i)], ")"); }

  // Torques may be recorded as currents, to which the options then apply.
  bool amperes() const { return recording_.current.size() > 0; }
  std::string torque_name() const { return amperes() ? "i" : "tau"; }

  void add(const std::string& finding, int joint, double value, const std::string& sentence) {
    QualityFinding f;
    f.file = recording_.source;
    f.finding = finding;
    f.joint = joint;
    f.share = quality::kNone;
    f.value = value;
    f.severity = Severity::kFault;
    f.sentence = sentence;
    findings_.push_back(std::move(f));
  }

  double near() const { return std::max(limits_.near_noise * noise_, limits_.exact); }
  bool is_explained(const QuickFit& fit) const { return fit.left() <= near() && fit.contradictions == 0.0; }

  // The recording and the arm after all transformations of a set. Columns are exchanged before they are scaled, as the
  // reader does.
  Recording changed(const std::vector<Question>& set) const {
    Recording out = recording_;
    for (const bool exchanges : {true, false}) {
      for (const Question& q : set) {
        if (q.recording && q.map.empty() != exchanges) q.recording(out);
      }
    }
    return out;
  }

  QuickFit fit_of(const std::vector<Question>& set) const {
    const Recording recording = changed(set);
    if (std::none_of(set.begin(), set.end(), [](const Question& q) { return static_cast<bool>(q.robot); })) return fitter_.fit(recording);
    ModelDescription d = given_.description();
    for (const Question& q : set) {
      if (q.robot) q.robot(d);
    }
    return QuickFitter(Model(std::move(d)), options_, limits_).fit(recording);
  }

  std::vector<Answer> tried(const std::vector<Question>& questions) const {
    std::vector<Answer> out(questions.size());
    parallel_for(static_cast<int>(questions.size()), 0, [&](int k) {
      Answer& one = out[static_cast<size_t>(k)];
      one.set = best_.set;
      one.set.push_back(questions[static_cast<size_t>(k)]);
      one.fit = fit_of(one.set);
    });
    return out;
  }

  // Questions that the answers so far leave open. What only contradicts the file's values or friction's sign is asked of
  // torques and gravity.
  std::vector<Question> open_questions() const {
    std::vector<bool> badly;
    for (int i = 0; i < joints(); ++i) badly.push_back(std::sqrt(best_.fit.shares[i]) > near());
    std::vector<Question> all = questions_of(given_, recording_, torque_name(), moves_, badly);
    const bool fits = best_.fit.left() <= near();
    const auto closed = [&](const Question& q) {
      if (fits && q.finding != "gravity" && q.finding != "current" && q.finding.rfind("torque", 0) != 0) return true;
      if (q.finding == "current" && !currents_are_asked()) return true;
      return std::any_of(best_.set.begin(), best_.set.end(), [&](const Question& chosen) {
        return chosen.excludes(q) || (chosen.finding == q.finding && chosen.joint == q.joint && chosen.second == q.second);
      });
    };
    all.erase(std::remove_if(all.begin(), all.end(), closed), all.end());
    return all;
  }

  // Adds the best question if it is much better than what there is and than every other one that excludes it. Questions
  // that come close to each other are what joints that move alike make of a torque that the arm does not explain.
  bool add_best() {
    const std::vector<Question> questions = open_questions();
    const std::vector<Answer> all = tried(questions);
    std::vector<char> possible;
    for (const Question& q : questions) possible.push_back(is_possible(q) ? 1 : 0);
    const auto gain = [&](size_t k) { return best_.fit.misfit - all[k].fit.misfit; };
    const auto passes = [&](size_t k) { return gain(k) > (questions[k].finding == "current" ? limits_.gains_better : limits_.better); };
    std::optional<size_t> best;
    for (size_t k = 0; k < all.size(); ++k) {
      const bool first = !best || possible[k] > possible[*best];
      if (passes(k) && (first || (possible[k] == possible[*best] && gain(k) > gain(*best)))) best = k;
    }
    if (!best) return false;
    const Question& q = questions[*best];
    if (possible[*best] == 0) return say_perhaps(all[*best], "as recorded, all positions lie within the limits of the joints");
    const bool common = q.finding == "torque_sign" || q.neighbours;  // signs are the commonest mistake; directions are polished
    for (size_t k = 0; !common && k < all.size(); ++k) {
      if (k == *best || possible[k] == 0 || !q.excludes(questions[k]) || gain(k) < gain(*best) - limits_.better) continue;
      if (questions[k].finding == q.finding && q.finding != "swapped_joints" && all[k].fit.left() > near()) continue;
      return say_perhaps(all[*best], "another exchange does nearly as well, so that none of them is sure");
    }
    if (!common && !holds_throughout(q, all[*best].fit))
      return say_perhaps(all[*best], "a joint that it concerns is explained no better in a part of the recording");
    best_ = polished(all[*best]);
    return true;
  }

  // Moves the last question of a set to its better neighbours, by steps that halve.
  Answer polished(Answer answer) const {
    const std::vector<Question> before(answer.set.begin(), answer.set.end() - 1);
    for (double step = 0.5 * answer.set.back().first_distance; answer.set.back().neighbours && step > limits_.finest * answer.set.back().first_distance;) {
      const std::vector<Question> near = answer.set.back().neighbours(step);
      std::vector<Answer> all(near.size());
      parallel_for(static_cast<int>(near.size()), 0, [&](int k) {
        Answer& one = all[static_cast<size_t>(k)];
        one.set = before;
        one.set.push_back(near[static_cast<size_t>(k)]);
        one.fit = fit_of(one.set);
      });
      const auto least = std::min_element(all.begin(), all.end(), [](const Answer& a, const Answer& b) { return a.fit.misfit < b.fit.misfit; });
      if (least->fit.misfit < answer.fit.misfit) answer = *least;
      else step *= 0.5;
    }
    return answer;
  }

  // True if every part of the recording explains every joint concerned better than before.
  bool holds_throughout(const Question& q, const QuickFit& fit) const {
    for (const int k : {q.joint, q.second}) {
      if (k > 0 && (fit.folds.row(k - 1).array() > best_.fit.folds.row(k - 1).array()).any()) return false;
    }
    return true;
  }

  // Number of joints whose positions leave their limits.
  int beyond_limits(const Recording& recording) const {
    const std::vector<Coordinate>& coordinates = given_.coordinates();
    int out = 0;
    for (size_t i = 0; i < coordinates.size(); ++i) {
      const Limits& limits = coordinates[i].limits;
      if (!std::isfinite(limits.upper - limits.lower)) continue;
      const double margin = limits_.beyond_limits * (limits.upper - limits.lower);
      const auto q = recording.q.col(i).array();
      out += (q < limits.lower - margin || q > limits.upper + margin).any() ? 1 : 0;
    }
    return out;
  }

  // The limits of the joints admit the positions that follow, no worse than those recorded; other units also
  // need positions that are none in radians.
  bool is_possible(const Question& q) const {
    const int as_recorded = beyond_limits(changed(best_.set));
    if (q.finding == "degrees" && q.units.rfind("q=", 0) == 0) return as_recorded > 0 || !has_limits();
    std::vector<Question> with = best_.set;
    with.push_back(q);
    return beyond_limits(changed(with)) <= as_recorded;
  }

  bool has_limits() const {
    return std::any_of(given_.coordinates().begin(), given_.coordinates().end(), [](const Coordinate& c) {
      return !c.prismatic && std::isfinite(c.limits.upper - c.limits.lower);
    });
  }

  bool say_perhaps(const Answer& answer, const std::string& but) {
    const Question& q = answer.set.back();
    std::string what = q.what;
    what.front() = static_cast<char>(std::tolower(static_cast<unsigned char>(what.front())));
    add(q.finding, q.joint, answer.fit.left(),
        text("Perhaps ", what, ": so the arm leaves ", percent(answer.fit.left()), " of the torque on held-out rows instead of ",
             percent(best_.fit.left()), ", but ", but, "."));
    findings_.back().severity = Severity::kInfo;
    return false;
  }

  // Torques that are a few times too small or too large, joint by joint, for every unit: those of the motors.
  void take_gears() {
    const VectorXd& ratios = best_.fit.ratios;
    std::vector<double> known;
    for (const double ratio : ratios) {
      if (ratio != 0.0) known.push_back(ratio);
    }
    if (amperes() || known.empty() || *std::max_element(known.begin(), known.end()) > kBehindGear || *std::min_element(known.begin(), known.end()) <= 0.0) return;
    Question q;
    q.finding = "torque_unit";
    VectorXd gears(joints());
    std::string list;
    for (int i = 0; i < joints(); ++i) {
      gears[i] = std::round(1.0 / (ratios[i] != 0.0 ? ratios[i] : median(known)));
      q.units += text(i > 0 ? "," : "", "tau", i + 1, "=", gears[i]);
      list += text(i > 0 ? ", " : "", gears[i]);
    }
    q.what = text("Torques are those of the motors in front of gears of about ", list);
    q.recording = [gears](Recording& r) { r.tau = (r.tau * gears.asDiagonal()).eval(); };
    Answer with = best_;
    with.set.push_back(q);
    with.fit = fit_of(with.set);
    if (best_.fit.misfit - with.fit.misfit > limits_.better) best_ = std::move(with);
  }

  // One line for each answer, with what the arm leaves without it and all options together.
  void report(double before) {
    const std::string options = options_of(best_.set);
    for (const Question& q : best_.set) {
      std::vector<Question> others;
      for (const Question& other : best_.set) {
        if (&other != &q) others.push_back(other);
      }
      const double without = others.empty() ? before : fit_of(others).left();
      const double left = best_.fit.left();
      std::string sentence = q.what + ": ";
      if (left < without) sentence += text("so the arm leaves ", percent(left), " of the torque on held-out rows instead of ", percent(without), "; ");
      else sentence += "its friction or the values of the robot file say so; ";
      if (is_explained(best_.fit)) sentence += options + " mends it.";
      else sentence += text(options, " makes it better, but the noise is at ", percent(noise_), ": not the whole truth.");
      add(q.finding, q.joint, left, sentence);
    }
  }

  bool has_gains() const {
    return std::all_of(given_.coordinates().begin(), given_.coordinates().end(),
                       [](const Coordinate& c) { return c.drive_gain > 0.0; });
  }

  // Equal gains would fit torques as well.
  bool currents_are_asked() const {
    if (!has_gains() || amperes() || joints() < 2) return false;
    if (given_.inertial_values()) return true;
    const VectorXd gains = this->gains();
    return gains.maxCoeff() > kEqualGains * gains.minCoeff();
  }

  VectorXd gains() const {
    VectorXd out(joints());
    for (int i = 0; i < joints(); ++i) out[i] = given_.coordinates()[static_cast<size_t>(i)].drive_gain;
    return out;
  }

  void warn_of_small_efforts() {
    if (!has_gains() || amperes() || !look_like_currents(gains())) return;
    add("current", 0, quality::kNone,
        text("All efforts are so small beside the limits of ", given_.name(),
             " that they may be motor currents, as the drivers of Universal Robots publish them: "
             "if they are, --units tau=A mends it."));
    findings_.back().severity = Severity::kWarning;
  }

  // True if every joint's largest effort is below the current at its torque limit.
  bool look_like_currents(const VectorXd& gains) const {
    double nearest = 0.0;
    for (int i = 0; i < joints(); ++i) {
      const double limit = given_.coordinates()[i].limits.effort;
      if (!std::isfinite(limit) || gains[i] < kLeastGain) return false;
      double largest = 0.0;
      for (const double tau : recording_.tau.col(i)) {
        if (std::isfinite(tau)) largest = std::max(largest, std::abs(tau));
      }
      nearest = std::max(nearest, largest * gains[i] / limit);
    }
    return nearest < 1.0;
  }

  const Model& given_;
  const PreprocessingOptions& options_;
  const CheckThresholds& limits_;
  Recording recording_;
  QuickFitter fitter_;
  std::vector<std::string> names_;
  std::vector<bool> moves_;  // joints that can be checked
  double noise_ = 0.0;       // relative, see QuickFitter::noise()
  Answer best_;
  std::vector<QualityFinding> findings_;
};

}  // namespace

const std::vector<TableNumber<CheckThresholds>>& check_numbers() {
  using T = CheckThresholds;
  static const std::vector<TableNumber<T>> kAll = {
      number_of<&T::most_rows>("most_rows"),
      number_of<&T::fewest_rows>("fewest_rows"),
      number_of<&T::worst_condition>("worst_condition"),
      number_of<&T::better>("better"),
      number_of<&T::gains_better>("gains_better"),
      number_of<&T::near_noise>("near_noise"),
      number_of<&T::exact>("exact"),
      number_of<&T::smallest_share>("smallest_share"),
      number_of<&T::friction_share>("friction_share"),
      number_of<&T::friction_above_rest>("friction_above_rest"),
      number_of<&T::friction_significance>("friction_significance"),
      number_of<&T::gives_energy>("gives_energy"),
      number_of<&T::telling>("telling"),
      number_of<&T::torque_factor>("torque_factor"),
      number_of<&T::most_off>("most_off"),
      number_of<&T::beyond_limits>("beyond_limits"),
      number_of<&T::most_together>("most_together"),
      number_of<&T::finest>("finest")};
  return kAll;
}

std::vector<QualityFinding> check_against(const Model& arm, const std::string& path,
                                          const PreprocessingOptions& options) {
  const CheckThresholds limits;
  RecordingOptions reading = reading_of(arm, options);
  reading.first_row = std::max(0L, options.first_row);
  reading.row_count = std::min<long>(options.row_count.value_or(limits.most_rows), limits.most_rows);
  Recording recording = read_rows(path, reading, options.kept.get());
  recording.source = path;
  PreprocessingOptions rest = options;
  rest.first_row = 0;
  rest.row_count.reset();
  return check_against(arm, std::move(recording), rest, limits);
}

std::vector<QualityFinding> check_against(const Model& arm, Recording recording,
                                          const PreprocessingOptions& options) {
  return check_against(arm, std::move(recording), options, CheckThresholds());
}

std::vector<QualityFinding> check_against(const Model& arm, Recording recording, const PreprocessingOptions& options,
                                          const CheckThresholds& limits) {
  require_joints_of(arm, recording.joints(), recording.source);
  const long first = std::min<long>(options.first_row, recording.rows());
  const long wanted = std::min<long>(options.row_count.value_or(limits.most_rows), limits.most_rows);
  const long count = std::min(wanted, recording.rows() - first);
  if (first > 0 || count < recording.rows())
    recording = rows_of(recording, static_cast<int>(first), static_cast<int>(count));
  if (recording.rows() < limits.fewest_rows) return {};
  if (options.cutoff > 0.0 && median_step(recording.time) * options.cutoff >= 0.5) return {};  // the filter needs two rows a wave
  if (recording.tau.size() == 0 && recording.current.size() > 0) {
    // Signs, exchanged joints and angles of currents are checked through their gains.
    recording.tau = recording.current;
    for (int i = 0; i < arm.joints(); ++i) {
      const double gain = arm.coordinates()[i].drive_gain;
      if (gain > 0.0) recording.tau.col(i) *= gain;
    }
  }
  if (recording.tau.size() == 0) return {};
  return RobotCheck(arm, std::move(recording), options, limits).run();
}

bool answers_question(const QualityFinding& finding) {
  static const char* const kNames[] = {"torque_sign", "position_sign", "swapped_joints", "degrees", "millimetres", "counts", "share_of_range",
                                       "motor_side", "torque_unit", "current", "gravity", "dh_convention"};
  // Degrees that velocities alone show belong to a joint.
  return finding.severity == Severity::kFault && (finding.finding != "degrees" || finding.joint == 0) &&
         std::find(std::begin(kNames), std::end(kNames), finding.finding) != std::end(kNames);
}

std::vector<QualityFinding> questions_answered(const Model& arm, const std::vector<std::string>& recordings, const PreprocessingOptions& options,
                                               const VectorRef& errors) {
  std::vector<QualityFinding> out;
  if (errors.size() == 0 || !(errors.maxCoeff() > kAskedAbove)) return out;
  for (const std::string& name : recordings) {
    const Recording* there = find_in_memory(options.in_memory, name);
    for (QualityFinding& f : there != nullptr ? check_against(arm, *there, options) : check_against(arm, name, options)) {
      if (f.severity != Severity::kFault) continue;
      f.file = name;
      out.push_back(std::move(f));
    }
    if (out.empty()) break;  // mistakes of a set-up are in the first recording too
  }
  return out;
}

}  // namespace veridyn
