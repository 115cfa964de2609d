#include "veridyn/identification/many_machines.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <set>
#include <utility>

#include "identification/feasible/feasible_fit.hpp"
#include "identification/many/factor_bytes.hpp"
#include "identification/many_recordings.hpp"
#include "identification/validation.hpp"
#include "identification/velocity_choice.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

// The recordings of one rank: neighbours in the list, so that the tree keeps their order.
std::pair<size_t, size_t> share_of(size_t count, const Communicator& ranks) {
  const auto size = static_cast<size_t>(ranks.size());
  const auto rank = static_cast<size_t>(ranks.rank());
  return {count * rank / size, count * (rank + 1) / size};
}

void write(const std::vector<UnusedRecording>& unusable_recordings, ByteWriter& out) {
  out.number(unusable_recordings.size());
  for (const UnusedRecording& r : unusable_recordings) {
    out.text(r.source);
    out.text(r.why);
  }
}

void read(ByteReader& in, std::vector<UnusedRecording>& unusable_recordings) {
  const std::size_t count = in.count(16);
  for (std::size_t k = 0; k < count; ++k) {
    UnusedRecording r;
    r.source = in.text();
    r.why = in.text();
    unusable_recordings.push_back(std::move(r));
  }
}

void write(const PredictionError& error, ByteWriter& out) {
  for (const VectorXd* v : {&error.relative, &error.maximum, &error.moving_relative})
    out.vector(*v);
}

void read(ByteReader& in, PredictionError& error) {
  for (VectorXd* v : {&error.relative, &error.maximum, &error.moving_relative}) *v = in.vector();
}

void write(const ErrorSums& s, ByteWriter& out) {
  for (const VectorXd* v :
       {&s.torque2, &s.error2, &s.torque_max, &s.error_max, &s.moving_torque2, &s.moving_error2})
    out.vector(*v);
}

void read(ByteReader& in, ErrorSums& s) {
  for (VectorXd* v :
       {&s.torque2, &s.error2, &s.torque_max, &s.error_max, &s.moving_torque2, &s.moving_error2})
    *v = in.vector();
}

void write(const std::vector<double>& values, ByteWriter& out) {
  out.vector(Eigen::Map<const VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())));
}

std::vector<double> read_values(ByteReader& in) {
  const VectorXd values = in.vector();
  return {values.data(), values.data() + values.size()};
}

void write(const PredictionSeries& s, ByteWriter& out) {
  write(s.time, out);
  for (const auto* table : {&s.q, &s.dq, &s.ddq, &s.measured, &s.modelled}) {
    out.number(table->size());
    for (const std::vector<double>& column : *table) write(column, out);
  }
}

void read(ByteReader& in, PredictionSeries& s) {
  s.time = read_values(in);
  for (auto* table : {&s.q, &s.dq, &s.ddq, &s.measured, &s.modelled}) {
    table->resize(in.count(8));
    for (std::vector<double>& column : *table) column = read_values(in);
  }
}

void write(const MeasuredRecording& r, ByteWriter& out) {
  out.text(r.error.source);
  write(r.error.error, out);
  write(r.error.repaired, out);
  write(r.error.without_excluded, out);
  out.number(static_cast<std::uint64_t>(r.error.filled.count));
  out.real(r.error.filled.age);
  out.number(static_cast<std::uint64_t>(r.error.rows));
  out.vector(r.error.noise_floor);
  out.real(r.error.period);
  write(r.error.series, out);
  write(r.sums.as_recorded, out);
  write(r.sums.repaired, out);
  write(r.sums.without_excluded, out);
}

MeasuredRecording read_measured(ByteReader& in, int joints) {
  const ErrorSums none(joints);
  MeasuredRecording r{{}, {none, none, none}, false};
  r.error.source = in.text();
  read(in, r.error.error);
  read(in, r.error.repaired);
  read(in, r.error.without_excluded);
  r.error.filled.count = static_cast<long>(in.number());
  r.error.filled.age = in.real();
  r.error.rows = static_cast<long>(in.number());
  r.error.noise_floor = in.vector();
  r.error.period = in.real();
  read(in, r.error.series);
  read(in, r.sums.as_recorded);
  read(in, r.sums.repaired);
  read(in, r.sums.without_excluded);
  return r;
}

// Results of several recordings: factors of those that could be used.
struct Part {
  FactorSet factors;
  std::vector<UnusedRecording> unusable_recordings;
  std::string refusal;  // why the whole work cannot go on; empty: it can
};

class Job {
 public:
  Job(const Model& arm, const IdentificationOptions& options, Communicator& ranks,
      const KeepFactors& keep)
      : arm_(arm), options_(options), ranks_(ranks), keep_(keep) {}

  // Compresses this rank's share one by one, so that an unusable recording does not affect the
  // others.
  Part compress_share(const std::vector<std::string>& train) const {
    const auto [first, end] = share_of(train.size(), ranks_);
    Part out;
    out.factors = compress(arm_, std::vector<std::string>(), options_.preprocessing, 1);
    size_t kept = 0;
    for (size_t k = first; k < end; ++k) {
      try {
        CompressedRecording one =
            compress(arm_, train[k], options_.preprocessing, options_.threads);
        require(one.rows > 0.0, train[k],
                ": found no usable samples after gaps, edges and row limits.");
        merge_blocks(one, blocks_of_each(static_cast<int>(train.size())));
        out.factors.recordings.push_back(std::move(one));
      } catch (const InvalidInput& error) {
        out.unusable_recordings.push_back({train[k], error.what()});
      }
      const size_t done = k + 1 - first;
      if (keep_ && (done >= 2 * kept || k + 1 == end)) {
        try {
          keep_(out.factors, false);
        } catch (const InvalidInput& error) {
          out.refusal = error.what();
          return out;
        }
        kept = done;
      }
    }
    return out;
  }

  // Collects factors and names of unusable recordings at rank 0, in the order of the list.
  void bring_together(Part& share) const {
    for (int step = 1; step < ranks_.size(); step *= 2) {
      if (ranks_.rank() % (2 * step) != 0) {
        ByteWriter out;
        out.text(share.refusal);
        write(share.unusable_recordings, out);
        out.text(to_bytes(share.factors));
        ranks_.send(ranks_.rank() - step, out.bytes());
        return;
      }
      if (ranks_.rank() + step >= ranks_.size()) continue;
      const std::string bytes = ranks_.receive(ranks_.rank() + step);
      const std::string name = text("factors of rank ", ranks_.rank() + step);
      ByteReader in(bytes, 0, name);
      const std::string refusal = in.text();
      if (share.refusal.empty()) share.refusal = refusal;
      read(in, share.unusable_recordings);
      share.factors = merge(std::move(share.factors), factors_from_bytes(in.text(), name));
    }
  }

  // Errors of these values on this rank's recordings, collected at rank 0. @param refusal  of the first rank whose
  // recordings cannot be read again.
  std::vector<MeasuredRecording> measured(const std::vector<CompressedRecording>& mine,
                                          const PreprocessingOptions& how, const VectorXd& values,
                                          int recordings, std::string& refusal) const {
    std::vector<MeasuredRecording> out;
    try {
      for (const CompressedRecording& r : mine)
        out.push_back(
            measure(arm_, r, how, values, series_samples_of_each(recordings), options_.threads));
    } catch (const InvalidInput& error) {
      if (refusal.empty()) refusal = error.what();
    }
    if (ranks_.rank() != 0) {
      ByteWriter bytes;
      bytes.text(refusal);
      bytes.number(out.size());
      for (const MeasuredRecording& r : out) write(r, bytes);
      ranks_.send(0, bytes.bytes());
      return {};
    }
    for (int r = 1; r < ranks_.size(); ++r) {
      const std::string bytes = ranks_.receive(r);
      const std::string name = text("errors of rank ", r);
      ByteReader in(bytes, 0, name);
      const std::string of_rank = in.text();
      if (refusal.empty()) refusal = of_rank;
      const std::size_t count = in.count(8);
      for (std::size_t k = 0; k < count; ++k) out.push_back(read_measured(in, arm_.joints()));
    }
    return out;
  }

 private:
  const Model& arm_;
  const IdentificationOptions& options_;
  Communicator& ranks_;
  const KeepFactors& keep_;
};

// Compresses the held-out recordings of one rank one by one.
std::vector<CompressedRecording> compress_held_out(const Model& arm,
                                                   const std::vector<std::string>& test,
                                                   const Identification& id, int threads,
                                                   const Communicator& ranks,
                                                   std::vector<UnusedRecording>& unusable_recordings) {
  const auto [first, end] = share_of(test.size(), ranks);
  std::vector<CompressedRecording> out;
  for (size_t k = first; k < end; ++k) {
    try {
      out.push_back(compress_test(arm, {test[k]}, id.test_preprocessing, threads).front());
    } catch (const InvalidInput& error) {
      unusable_recordings.push_back({test[k], error.what()});
    }
  }
  return out;
}

// Computes the model from all factors, at rank 0.
void solve(AskedArm& arm, std::vector<CompressedRecording> all, size_t listed,
           const IdentificationOptions& options, Identification& id) {
  const std::string first = id.unusable_recordings.empty() ? "" : id.unusable_recordings.front().why;
  if (all.empty()) {
    id.reason = text("not one of ", listed, " recordings can be used: ", first);
    return;
  }
  for (CompressedRecording& r : all) merge_blocks(r, blocks_of_each(static_cast<int>(all.size())));
  if (fit_factors(arm, all, options, id)) id.factors = std::move(all);
}

// Broadcasts bytes from rank 0.
std::string broadcast(std::string bytes, Communicator& ranks) {
  if (ranks.rank() != 0) return ranks.receive(0);
  for (int r = 1; r < ranks.size(); ++r) ranks.send(r, bytes);
  return bytes;
}

Identification identify_once(const Model& file, const std::vector<std::string>& train,
                             const std::vector<std::string>& test,
                             const IdentificationOptions& options, Communicator& ranks,
                             const KeepFactors& keep) {
  AskedArm arm(file, options.friction);
  // Compresses first, then measures errors with the arm actually used.
  const Job job(arm.used(), options, ranks, keep);
  Identification id = described(file, options);
  const auto begin = std::chrono::steady_clock::now();
  Part share = job.compress_share(train);
  const std::vector<CompressedRecording> mine = share.factors.recordings;
  job.bring_together(share);
  std::string refusal = share.refusal;
  if (ranks.rank() == 0 && refusal.empty()) {
    if (keep) keep(share.factors, true);
    id.unusable_recordings = std::move(share.unusable_recordings);
    id.seconds.compress =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    try {
      solve(arm, std::move(share.factors.recordings), train.size(), options, id);
    } catch (const InvalidInput& error) {
      refusal = error.what();
    }
  }
  ByteWriter answer;
  answer.text(refusal);
  answer.number(id.model ? 1 : 0);
  answer.number(arm.used().effects().size());
  answer.number(static_cast<std::uint64_t>(id.status));
  answer.text(id.reason);
  answer.vector(id.parameters);
  const std::string bytes = broadcast(answer.bytes(), ranks);
  const std::string name = "answer of rank 0";
  ByteReader in(bytes, 0, name);
  refusal = in.text();
  if (!refusal.empty()) throw InvalidInput(refusal);
  const bool solved = in.number() != 0;
  if (in.number() < arm.used().effects().size()) arm.leave_rotors_out();
  id.status = static_cast<IdentificationStatus>(in.number());
  id.reason = in.text();
  id.parameters = in.vector();
  const bool nothing = !solved && id.status == IdentificationStatus::kNoData;
  if (nothing && id.reason.compare(0, 11, "not one of ") == 0) throw InvalidInput(id.reason);
  if (!solved) return id;
  std::vector<UnusedRecording> unused;
  const std::vector<CompressedRecording> held_out =
      compress_held_out(arm.used(), test, id, options.threads, ranks, unused);
  const auto count = static_cast<int>(train.size() + test.size());
  std::vector<MeasuredRecording> of_train =
      job.measured(mine, id.preprocessing, id.parameters, count, refusal);
  std::vector<MeasuredRecording> of_test =
      job.measured(held_out, id.test_preprocessing, id.parameters, count, refusal);
  Part names;
  names.factors = compress(arm.used(), std::vector<std::string>(), options.preprocessing, 1);
  names.unusable_recordings = std::move(unused);
  job.bring_together(names);
  refusal = broadcast(refusal, ranks);
  if (!refusal.empty()) throw InvalidInput(refusal);
  if (ranks.rank() != 0) return id;
  id.unusable_recordings.insert(id.unusable_recordings.end(), names.unusable_recordings.begin(), names.unusable_recordings.end());
  take_errors(arm.used(), std::move(of_train), std::move(of_test), id);
  keep_training_error(id);
  return id;
}

// Messages of rank 0 after the first fit begin with one of these; an empty one is the end.
enum class Message : std::uint64_t { kQuestion, kRefusal };

std::string refusal(const std::string& why) {
  ByteWriter out;
  out.number(static_cast<std::uint64_t>(Message::kRefusal));
  out.text(why);
  return out.bytes();
}

// Joints whose velocities a further fit derives from the position, and the periods of the recordings
// from the first one.
std::string question(const IdentificationOptions& how) {
  ByteWriter out;
  out.number(static_cast<std::uint64_t>(Message::kQuestion));
  out.number(how.preprocessing.derive_velocity_of.size());
  for (const int j : how.preprocessing.derive_velocity_of)
    out.number(static_cast<std::uint64_t>(j));
  out.number(how.preprocessing.known_periods.size());
  for (const auto& [source, period] : how.preprocessing.known_periods) {
    out.text(source);
    out.real(period);
  }
  return out.bytes();
}

void read_question(const std::string& bytes, IdentificationOptions& how) {
  const std::string name = "question of rank 0";
  ByteReader in(bytes, 0, name);
  if (in.number() == static_cast<std::uint64_t>(Message::kRefusal)) throw InvalidInput(in.text());
  std::set<int> joints;
  for (std::size_t left = in.count(8); left > 0; --left)
    joints.insert(static_cast<int>(in.number()));
  derive_velocities(joints, how);
  how.preprocessing.known_periods.clear();
  for (std::size_t left = in.count(8); left > 0; --left) {
    const std::string source = in.text();
    how.preprocessing.known_periods[source] = in.real();
  }
}

std::vector<std::string> usable(const std::vector<std::string>& train, const Identification& id) {
  std::vector<std::string> out;
  for (const std::string& path : train) {
    if (std::none_of(id.unusable_recordings.begin(), id.unusable_recordings.end(),
                     [&](const UnusedRecording& r) { return r.source == path; }))
      out.push_back(path);
  }
  return out;
}

}  // namespace

Identification identify(const Model& file, const std::vector<std::string>& train,
                        const std::vector<std::string>& test, const IdentificationOptions& options,
                        Communicator& ranks, const KeepFactors& keep) {
  require(!train.empty(), "identify: there is no recording to train on.");
  require(options.known_masses.empty(),
          "identify: drive gains are found on one machine; leave known masses away.");
  require(options.method != Method::kIv && options.method != Method::kDidim,
          "identify: found a method with instruments, which need samples; ranks share factors alone.");
  if (options.method == Method::kFeasible) require_prior_fits(file, options);
  std::optional<FactorSet> first;
  FactorSet last;
  const KeepFactors hold = [&](const FactorSet& factors, bool whole) {
    if (!whole) return keep(factors, false);
    if (!first) first = factors;
    last = factors;
  };
  const KeepFactors kept = keep ? hold : KeepFactors();
  Identification id = identify_once(file, train, test, options, ranks, kept);
  if (ranks.rank() != 0) {
    IdentificationOptions how = options;
    for (std::string asked = ranks.receive(0); !asked.empty(); asked = ranks.receive(0)) {
      read_question(asked, how);
      id = identify_once(file, train, test, how, ranks, kept);
    }
    return id;
  }
  const std::vector<std::string> readable = usable(train, id);
  bool all_know = false;  // of a refusal within a further fit
  try {
    id = with_chosen_velocities(file, std::move(id), readable, options,
                                [&](const IdentificationOptions& how) {
                                  broadcast(question(how), ranks);
                                  all_know = true;
                                  Identification again = identify_once(file, train, test, how, ranks, kept);
                                  all_know = false;
                                  return again;
                                });
  } catch (const InvalidInput& error) {
    if (!all_know) broadcast(refusal(error.what()), ranks);
    throw;
  }
  broadcast("", ranks);
  if (keep) keep(id.preprocessing.derive_velocity_of.empty() ? *first : last, true);
  return id;
}

}  // namespace veridyn
