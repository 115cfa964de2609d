#include "veridyn/diagnosis/diagnosis.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>
#include <utility>

#include "diagnosis/causes/contacts.hpp"
#include "findings.hpp"
#include "diagnosis/causes/geometry.hpp"
#include "diagnosis/evidence/held_out.hpp"
#include "diagnosis/shapes/inquiry.hpp"
#include "next_experiment.hpp"
#include "diagnosis/shapes/refinement.hpp"
#include "diagnosis/causes/ripple.hpp"
#include "diagnosis/causes/snags.hpp"
#include "veridyn/identification/arm_effects.hpp"
#include "math/parallel.hpp"
#include "diagnosis/causes/wrong_constant.hpp"

namespace veridyn {
namespace {

// A model's values are estimates, and what they leave over, a little off as they are, is no change.
// Chosen on 16 unchanged simulated arms: it left one false name (a payload, gain 0.36) of four;
// real changes gained 0.2 and more.
constexpr double kSmallestChange = 0.1;
constexpr int kCycles = 2;
constexpr int kChannels = 3;  // errors of channels that are corrected one after the other

bool asks_for(const DiagnosisOptions& options, const std::string& effect) {
  return options.effects.empty() ||
         std::find(options.effects.begin(), options.effects.end(), effect) != options.effects.end();
}

std::vector<std::pair<Hypothesis, EffectTerm>> known_terms(const AugmentedModel& fitted) {
  std::vector<std::pair<Hypothesis, EffectTerm>> out;
  for (const Hypothesis& h : fitted.hypotheses) {
    if (h.term >= 0) out.emplace_back(h, fitted.model.effects()[static_cast<size_t>(h.term)]);
  }
  return out;
}

// Where the fitted hypotheses stand in a longer list that begins with them.
std::vector<int> same_ones(const AugmentedModel& fitted, const Inquiry& q) {
  std::vector<int> out;
  for (const Hypothesis& h : fitted.hypotheses) {
    for (size_t k = 0; k < q.augmented.hypotheses.size(); ++k) {
      if (q.augmented.hypotheses[k].family != h.family) continue;
      if (std::find(out.begin(), out.end(), static_cast<int>(k)) != out.end()) continue;
      out.push_back(static_cast<int>(k));
      break;
    }
  }
  return out;
}

// One run of the questions, from recordings to findings.
class Investigation {
 public:
  Investigation(const Model& arm, const std::vector<std::string>& train,
                const std::vector<std::string>& test, const DiagnosisOptions& options)
      : arm_(arm), train_(train), test_(test), options_(options) {
    d_.changes = has_all_values(arm);
    d_.provisional = train.size() == 1;
    if (d_.changes) options_.smallest_gain = std::max(options_.smallest_gain, kSmallestChange);
  }

  Diagnosis run() {
    check_quality();
    d_.baseline = look(arm_);
    if (!d_.baseline.model) return std::move(d_);
    remember_periods();
    leave_out_snags(d_.baseline);
    start_ = d_.baseline;
    investigate();
    // Contacts and small snags show once the model's own errors are out of the way; then all is
    // asked anew without these moments.
    const bool snags = leave_out_snags(d_.extended);
    if (snags) start_ = d_.baseline;
    if (leave_out_contacts(d_.extended) || snags) investigate();
    for (size_t k = 0; k < d_.findings.size(); ++k) d_.findings[k].rank = static_cast<int>(k) + 1;
    return std::move(d_);
  }

 private:
  void check_quality() {
    std::vector<std::string> all = train_;
    for (const std::string& path : test_) {
      if (std::find(all.begin(), all.end(), path) == all.end()) all.push_back(path);
    }
    const PreprocessingOptions& how = options_.identification.preprocessing;
    d_.data_quality.resize(all.size());
    parallel_for(static_cast<int>(all.size()), options_.identification.threads, [&](int k) {
      RecordingOptions reading;
      reading.columns = how.columns;
      reading.rate = how.header_rate;
      d_.data_quality[static_cast<size_t>(k)] =
          check_recording(all[static_cast<size_t>(k)], reading);
    });
    choose_velocities();
  }

  // A velocity that is not the derivative of its position in scale is taken from the position.
  void choose_velocities() {
    std::set<int> wrong;
    for (RecordingQuality& recording : d_.data_quality) {
      for (QualityFinding& f : recording.findings) {
        if (f.finding != "velocity_scale" || f.severity == Severity::kInfo || f.joint < 1) continue;
        wrong.insert(f.joint - 1);
        f.sentence += "; the velocity of this joint is taken from its position";
      }
    }
    options_.identification.preprocessing.derive_velocity_of.assign(wrong.begin(), wrong.end());
    if (options_.identification.test_preprocessing) {
      options_.identification.test_preprocessing->derive_velocity_of =
          options_.identification.preprocessing.derive_velocity_of;
    }
  }

  // The arm on the recordings: identified, or as it stands if its values are facts.
  Identification look(const Model& arm) const {
    return d_.changes ? evaluate(arm, train_, test_, options_.identification)
                      : identify(arm, train_, test_, options_.identification);
  }

  // The recordings are read many times; their periods stay what they are.
  void remember_periods() {
    std::map<std::string, double>& known = options_.identification.preprocessing.known_periods;
    for (const auto* list : {&d_.baseline.train, &d_.baseline.test}) {
      for (const RecordingError& r : *list) known.emplace(r.source, r.period);
    }
    if (options_.identification.test_preprocessing)
      options_.identification.test_preprocessing->known_periods = known;
  }

  void leave_out(const std::vector<LeftOut>& parts) {
    IdentificationOptions& how = options_.identification;
    how.preprocessing.left_out.insert(how.preprocessing.left_out.end(), parts.begin(), parts.end());
    if (how.test_preprocessing) {
      auto& there = how.test_preprocessing->left_out;
      there.insert(there.end(), parts.begin(), parts.end());
    }
    d_.left_out.insert(d_.left_out.end(), parts.begin(), parts.end());
  }

  // True if there are any that were not known.
  bool leave_out_snags(const Identification& seen) {
    if (!seen.model) return false;
    std::vector<Snag> snags = find_snags(seen);
    snags.erase(std::remove_if(snags.begin(), snags.end(),
                               [this](const Snag& snag) { return is_known(snag); }),
                snags.end());
    if (snags.empty()) return false;
    for (const Snag& snag : snags) report(snag);
    snags_.insert(snags_.end(), snags.begin(), snags.end());
    leave_out(left_out_rows(snags, seen));
    const Identification again = look(arm_);
    if (again.model) d_.baseline = again;
    return true;
  }

  // Rows that are left out still show their friction.
  bool is_known(const Snag& snag) const {
    return std::any_of(snags_.begin(), snags_.end(), [&snag](const Snag& other) {
      return other.source == snag.source && other.joint == snag.joint && other.from < snag.to &&
             snag.from < other.to;
    });
  }

  void report(const Snag& snag) {
    const Coordinate& joint = arm_.coordinates()[static_cast<size_t>(snag.joint)];
    QualityFinding f;
    f.file = snag.source;
    f.finding = "snag";
    f.signal = "tau";
    f.joint = snag.joint + 1;
    f.value = snag.friction;
    f.unit = effort_unit(joint);
    f.severity = Severity::kWarning;
    f.sentence = snag_text(snag, joint);
    for (RecordingQuality& q : d_.data_quality) {
      if (q.file == snag.source) q.findings.push_back(f);
    }
  }

  // True if there are any that were not known.
  bool leave_out_contacts(const Identification& seen) {
    if (!asks_for(options_, "external_contact") || !seen.model) return false;
    const std::vector<Contact> contacts = find_contacts(seen);
    if (contacts.empty()) return false;
    contacts_known_ = contacts.size();
    leave_out(left_out_rows(contacts));
    d_.findings.clear();
    const Identification without = look(arm_);
    add_contacts(contacts, d_.baseline, without, d_);
    start_ = without.model ? without : d_.baseline;
    return true;
  }

  struct Questions {
    Inquiry q;
    NormalBlocks data;
  };

  // One round of questions and what was accepted of them.
  struct Round : Questions {
    Selection selection;
    bool changed = true;  // from what it began with
  };

  Questions questions(const QuestionList& list) const {
    Inquiry q = prepare(start_, train_, test_, list, options_.identification);
    NormalBlocks data(q.train, q.columns);
    return {std::move(q), std::move(data)};
  }

  // `accepted`: to begin with; their terms are among those that the questions know.
  Round answer(Questions asked, const AugmentedModel* accepted = nullptr) const {
    const Inquiry& q = asked.q;
    const std::vector<int> initial =
        accepted == nullptr ? std::vector<int>() : same_ones(*accepted, q);
    Selection selection =
        select_effects(asked.data, q.base, q.augmented.hypotheses, for_the_rest(), initial);
    std::vector<int> chosen;
    for (const Accepted& a : selection.accepted) chosen.push_back(a.evidence.hypothesis);
    return {std::move(asked), std::move(selection), chosen != initial};
  }

  Fit fitted(Round& round) const {
    return fit_accepted(start_, round.q, round.selection, d_.changes, train_, test_, options_);
  }

  void investigate() {
    d_.findings.resize(contacts_known_);
    d_.not_supported.clear();
    d_.cannot_tell.clear();
    QuestionList list;
    list.wanted = options_.effects;
    list.changes = d_.changes;
    if (asks_for(options_, "torque_ripple")) list.ripple_orders = ripple_orders(start_);
    std::optional<Questions> first(questions(list));
    if (!d_.changes && asks_for(options_, "coupling_error") && correct_constant(*first))
      first.emplace(questions(list));
    std::optional<Round> round(answer(std::move(*first)));
    for (int turn = 0; turn < kChannels && correct_channel(*round); ++turn)
      round.emplace(answer(questions(list)));
    size_t selected = round->selection.accepted.size();
    std::optional<Fit> fit(fitted(*round));
    // Refined constants made some findings superfluous: what stood behind them is asked once more.
    for (int cycle = 0; cycle < kCycles && round->selection.accepted.size() < selected; ++cycle) {
      list.known = known_terms(fit->inquiry.augmented);
      round.emplace(answer(questions(list), &fit->inquiry.augmented));
      selected = round->selection.accepted.size();
      fit.emplace(fitted(*round));
    }
    challenge(list, round, fit);
    write_down(*round, *fit);
  }

  // The accepted ones against their rivals, all with refined constants.
  void challenge(QuestionList& list, std::optional<Round>& round, std::optional<Fit>& fit) const {
    const auto rivals = refined_rivals(start_, round->q, round->selection, d_.changes, train_,
                                       options_.identification);
    if (rivals.empty()) return;
    list.known = known_terms(fit->inquiry.augmented);
    list.known.insert(list.known.end(), rivals.begin(), rivals.end());
    round.emplace(answer(questions(list), &fit->inquiry.augmented));
    if (round->changed) fit.emplace(fitted(*round));
  }

  void write_down(const Round& round, const Fit& fit) {
    std::set<std::string> families;
    for (const Hypothesis& h : round.q.augmented.hypotheses) families.insert(h.family);
    d_.hypotheses = static_cast<int>(families.size());
    const FindingWriter writer(round.q, round.data, round.selection, fit, start_, d_.changes,
                               options_);
    writer.add_findings(d_);
    writer.add_the_rest(d_);
    d_.extended = round.selection.accepted.empty() ? start_ : look(writer.extended_arm());
    d_.next_experiment = next_experiment(d_);
  }

  // What was found before (constants, channels) counts; contacts are moments and no effects.
  DiagnosisOptions for_the_rest() const {
    DiagnosisOptions out = options_;
    out.max_effects -= static_cast<int>(d_.findings.size() - contacts_known_);
    return out;
  }

  // A channel error or a tilt that comes first is applied to the arm before anything else is asked:
  // its columns are right to first order only, and what they leave over would look like more
  // causes.
  bool correct_channel(const Round& round) {
    const Inquiry& q = round.q;
    if (round.selection.accepted.empty()) return false;
    const Accepted& first = round.selection.accepted.front();
    const Hypothesis& h = q.augmented.hypotheses[static_cast<size_t>(first.evidence.hypothesis)];
    if (!is_arm_effect(h.effect)) return false;
    Selection one;
    one.accepted = {first};
    const Fit fit = fit_accepted(start_, q, one, d_.changes, train_, test_, options_);
    const FindingWriter writer(q, round.data, one, fit, start_, d_.changes, options_);
    const VectorXd before = start_.test_error.relative;
    writer.add_findings(d_);
    const Identification corrected = look(writer.extended_arm());
    if (!corrected.model) {
      d_.findings.pop_back();
      return false;
    }
    start_ = corrected;
    Finding& f = d_.findings.back();
    polish(h, f);
    f.test_before = before;
    f.test_after = start_.test_error.relative;
    f.explains = explained_share(before, f.test_after, d_.baseline);
    return true;
  }

  // The same question once more, at the corrected arm: one step of Gauss and Newton.
  void polish(const Hypothesis& h, Finding& f) {
    QuestionList list;
    list.wanted = {h.effect};
    list.changes = d_.changes;
    const IdentificationOptions& how = options_.identification;
    Inquiry q = prepare(start_, train_, test_, list, how);
    auto& all = q.augmented.hypotheses;
    all.erase(std::remove_if(all.begin(), all.end(),
                             [&h](const Hypothesis& other) { return other.family != h.family; }),
              all.end());
    const NormalBlocks data(q.train, q.columns);
    if (all.size() != 1 || columns_of(data, all.front()).size() != all.front().columns.size())
      return;
    Selection one;
    one.accepted.emplace_back();
    one.accepted.front().evidence.hypothesis = 0;
    const Fit fit = fit_accepted(start_, q, one, d_.changes, train_, test_, options_);
    const FindingWriter writer(q, data, one, fit, start_, d_.changes, options_);
    const Identification better = look(writer.extended_arm());
    if (!better.model ||
        better.train_error.relative.squaredNorm() > start_.train_error.relative.squaredNorm())
      return;
    start_ = better;
    writer.add_step(f);
  }

  bool correct_constant(const Questions& asked) {
    const std::vector<GeometryFinding> geometry =
        profile_geometry(arm_, train_, options_.identification);
    std::optional<Finding> wrong =
        wrong_constant(arm_, geometry, asked.q, asked.data, train_, options_);
    if (!wrong) return false;
    const VectorXd before = start_.test_error.relative;
    start_ = look(with_constant(arm_, geometry.front().constant, geometry.front().found));
    wrong->rank = static_cast<int>(d_.findings.size()) + 1;
    wrong->test_before = before;
    wrong->test_after = start_.test_error.relative;
    wrong->explains = explained_share(wrong->test_before, wrong->test_after, d_.baseline);
    d_.findings.push_back(*wrong);
    return true;
  }

  const Model& arm_;
  const std::vector<std::string>& train_;
  const std::vector<std::string>& test_;
  DiagnosisOptions options_;
  Diagnosis d_;
  Identification start_;
  size_t contacts_known_ = 0;
  std::vector<Snag> snags_;  // known ones
};

}  // namespace

Diagnosis diagnose(const Model& arm, const std::vector<std::string>& train,
                   const std::vector<std::string>& test, const DiagnosisOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  Diagnosis d = Investigation(arm, train, test, options).run();
  d.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return d;
}

}  // namespace veridyn
