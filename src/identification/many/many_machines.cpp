#include "veridyn/identification/many_machines.hpp"

#include <algorithm>
#include <iterator>
#include <optional>
#include <set>
#include <unordered_map>
#include <utility>

#include "identification/feasible/feasible_fit.hpp"
#include "identification/many/factor_bytes.hpp"
#include "identification/recording_passes.hpp"
#include "identification/velocity_choice.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {

template <typename Bytes>
void exchange(Bytes& bytes, UnusedRecording& r) {
  bytes(r.source, r.why);
}

template <typename Bytes>
void exchange(Bytes& bytes, PredictionError& e) {
  bytes(e.relative, e.maximum, e.moving_relative);
}

template <typename Bytes>
void exchange(Bytes& bytes, ErrorSums& s) {
  bytes(s.torque2, s.error2, s.torque_max, s.error_max, s.moving_torque2, s.moving_error2);
}

template <typename Bytes>
void exchange(Bytes& bytes, PredictionSeries& s) {
  bytes(s.time, s.q, s.dq, s.ddq, s.measured, s.modelled);
}

template <typename Bytes>
void exchange(Bytes& bytes, MeasuredRecording& r) {
  bytes(r.error.source, r.error.error, r.error.repaired, r.error.without_excluded, r.error.filled.count, r.error.filled.age,
        r.error.rows, r.error.noise_floor, r.error.period, r.error.series, r.sums.as_recorded, r.sums.repaired,
        r.sums.without_excluded);
}

namespace {

// The recordings of one rank: neighbours in the list, whose order the collected factors keep.
std::pair<size_t, size_t> share_of(size_t count, const Communicator& ranks) {
  const auto size = static_cast<size_t>(ranks.size());
  const auto rank = static_cast<size_t>(ranks.rank());
  return {count * rank / size, count * (rank + 1) / size};
}

// Requests of rank 0 to all ranks, itself included, and its last message to the others.
enum class Request : std::uint64_t { kCompress, kMeasure, kRefusal, kDone };

ByteWriter request(Request kind) {
  ByteWriter out;
  out.number(static_cast<std::uint64_t>(kind));
  return out;
}

// Settings that differ between the fits of one identification: joints whose velocities are derived from the position,
// and periods that an earlier fit found.
void write_settings(const PreprocessingOptions& how, ByteWriter& out) {
  out.number(how.derive_velocity_of.size());
  for (const int j : how.derive_velocity_of) out.number(static_cast<std::uint64_t>(j));
  out.number(how.known_periods.size());
  for (const auto& [source, period] : how.known_periods) {
    out.text(source);
    out.real(period);
  }
}

void read_settings(ByteReader& in, IdentificationOptions& how) {
  std::set<int> joints;
  for (std::size_t left = in.count(8); left > 0; --left) joints.insert(static_cast<int>(in.number()));
  derive_velocities(joints, how);
  how.preprocessing.known_periods.clear();
  for (std::size_t left = in.count(8); left > 0; --left) {
    const std::string source = in.text();
    how.preprocessing.known_periods[source] = in.real();
  }
}

// The recordings of one rank and the map over them.
class Share {
 public:
  Share(const Model& file, const std::vector<std::string>& train, const std::vector<std::string>& test,
        const IdentificationOptions& options, const Communicator& ranks, const KeepFactors& keep)
      : arm_(AskedArm(file, options.friction).effective_arm()),
        train_(train),
        test_(test),
        options_(options),
        ranks_(ranks),
        keep_(keep) {}

  const Model& arm() const { return arm_; }

  // The reply to a request: an error message, empty if there is none, and the result.
  std::string answer(const std::string& bytes) {
    ByteWriter out;
    out.text("");
    try {
      ByteReader in(bytes, 0, source_);
      if (static_cast<Request>(in.number()) == Request::kCompress) {
        compress_train(in, out);
      } else {
        measure_all(in, out);
      }
    } catch (const InvalidInput& error) {
      out = ByteWriter();
      out.text(error.what());
    }
    return out.bytes();
  }

 private:
  // One by one, so that an unusable recording does not affect the others.
  void compress_train(ByteReader& in, ByteWriter& out) {
    read_settings(in, options_);
    mine_ = compress(arm_, std::vector<std::string>(), options_.preprocessing, 1);
    std::vector<UnusedRecording> unusable;
    const auto [first, end] = share_of(train_.size(), ranks_);
    size_t kept = 0;
    for (size_t k = first; k < end; ++k) {
      try {
        CompressedRecording one = compress(arm_, train_[k], options_.preprocessing, options_.threads);
        require(one.rows > 0.0, train_[k], ": found no usable samples after gaps, edges and row limits.");
        merge_blocks(one, blocks_of_each(static_cast<int>(train_.size())));
        mine_.recordings.push_back(std::move(one));
      } catch (const InvalidInput& error) {
        unusable.push_back({train_[k], error.what()});
      }
      const size_t done = k + 1 - first;
      if (!keep_ || (done < 2 * kept && k + 1 != end)) continue;
      keep_(mine_, false);
      kept = done;
    }
    out(unusable);
    out.text(to_bytes(mine_));
  }

  void measure_all(ByteReader& in, ByteWriter& out) const {
    const PreprocessingOptions& of_test = options_.test_preprocessing.value_or(options_.preprocessing);
    const auto samples = static_cast<int>(in.number());
    const VectorXd values = in.vector();
    std::vector<UnusedRecording> unusable;
    FactorSet held_out;
    const auto [first, end] = share_of(test_.size(), ranks_);
    for (size_t k = first; k < end; ++k) {
      try {
        held_out.recordings.push_back(compress_test(arm_, {test_[k]}, of_test, options_.threads).front());
      } catch (const InvalidInput& error) {
        unusable.push_back({test_[k], error.what()});
      }
    }
    out(unusable);
    out.text(to_bytes(held_out));
    for (const FactorSet* set : {&mine_, static_cast<const FactorSet*>(&held_out)}) {
      const PreprocessingOptions& how = set == &held_out ? of_test : options_.preprocessing;
      out.number(set->recordings.size());
      for (const CompressedRecording& r : set->recordings) {
        MeasuredRecording one = measure(arm_, r, how, values, samples, options_.threads);
        out(one);
      }
    }
  }

  const std::string source_ = "request of rank 0";
  const Model arm_;
  const std::vector<std::string>& train_;
  const std::vector<std::string>& test_;
  IdentificationOptions options_;
  const Communicator& ranks_;
  const KeepFactors& keep_;
  FactorSet mine_;
};

// At rank 0: every pass is a request to all ranks, whose answers are merged in the order of the recordings.
class RankPasses final : public RecordingPasses {
 public:
  RankPasses(Share& share, Communicator& ranks, size_t recordings, bool keeps)
      : share_(share), ranks_(ranks), recordings_(recordings), keeps_(keeps) {}

  std::vector<CompressedRecording> compress(const Model&, const std::vector<std::string>& train,
                                            const PreprocessingOptions& how, int) const override {
    ByteWriter asked = request(Request::kCompress);
    write_settings(how, asked);
    FactorSet all;
    unusable_.clear();
    request_all(asked.bytes(), [&](ByteReader& in, const std::string& from) {
      add_unusable(in);
      all = merge(std::move(all), factors_from_bytes(in.text(), from));
    });
    require(!all.recordings.empty(), "not one of ", train.size(), " recordings can be used: ",
            unusable_.empty() ? "" : unusable_.front().why);
    if (keeps_ && !first_) first_ = all;
    if (keeps_) last_ = all;
    return std::move(all.recordings);
  }

  MeasuredRecordings measure(const Model& arm, const std::vector<std::string>&, int, const Identification& id) const override {
    ByteWriter asked = request(Request::kMeasure);
    asked.number(static_cast<std::uint64_t>(series_samples_of_each(static_cast<int>(recordings_))));
    asked.vector(values_of(arm, id.parameters));
    const ErrorSums none(arm.joints());
    MeasuredRecordings out;
    request_all(asked.bytes(), [&](ByteReader& in, const std::string& from) {
      add_unusable(in);
      FactorSet held_out = factors_from_bytes(in.text(), from);
      std::move(held_out.recordings.begin(), held_out.recordings.end(), std::back_inserter(out.held_out));
      for (auto* recordings : {&out.train, &out.test}) {
        for (std::size_t left = in.count(8); left > 0; --left) {
          recordings->push_back({{}, {none, none, none}, false});
          in(recordings->back());
        }
      }
    });
    return out;
  }

  void broadcast(const std::string& bytes) const {
    for (int r = 1; r < ranks_.size(); ++r) ranks_.send(r, bytes);
  }

  const std::vector<UnusedRecording>& unusable() const { return unusable_; }
  // All factors, with the velocities that were chosen in the end.
  const FactorSet& factors(const Identification& id) const {
    return id.preprocessing.derive_velocity_of.empty() ? *first_ : last_;
  }

 private:
  template <typename Read>
  void request_all(const std::string& bytes, const Read& take) const {
    broadcast(bytes);
    std::vector<std::string> answers = {share_.answer(bytes)};
    for (int r = 1; r < ranks_.size(); ++r) answers.push_back(ranks_.receive(r));
    for (const bool refusals : {true, false}) {
      for (size_t r = 0; r < answers.size(); ++r) {
        const std::string from = text("answer of rank ", r);
        ByteReader in(answers[r], 0, from);
        const std::string refusal = in.text();
        if (!refusal.empty()) throw InvalidInput(refusal);
        if (!refusals) take(in, from);
      }
    }
  }

  void add_unusable(ByteReader& in) const {
    std::vector<UnusedRecording> more;
    in(more);
    unusable_.insert(unusable_.end(), more.begin(), more.end());
  }

  // Values of the ranks' arm, which may have effects that the recordings did not determine: they are zero.
  VectorXd values_of(const Model& arm, const VectorXd& parameters) const {
    std::unordered_map<std::string, double> known;
    const std::vector<StandardParameter> own = standard_parameters(arm), all = standard_parameters(share_.arm());
    for (size_t p = 0; p < own.size(); ++p) known[own[p].name] = parameters[static_cast<Eigen::Index>(p)];
    VectorXd out = VectorXd::Zero(static_cast<Eigen::Index>(all.size()));
    for (size_t p = 0; p < all.size(); ++p) {
      if (const auto found = known.find(all[p].name); found != known.end()) out[static_cast<Eigen::Index>(p)] = found->second;
    }
    return out;
  }

  Share& share_;
  Communicator& ranks_;
  size_t recordings_;
  bool keeps_;
  mutable std::vector<UnusedRecording> unusable_;
  mutable std::optional<FactorSet> first_;
  mutable FactorSet last_;
};

// Answers rank 0 until it is done.
Identification serve(Share& share, Communicator& ranks, Identification id) {
  const std::string source = "request of rank 0";
  while (true) {
    const std::string bytes = ranks.receive(0);
    ByteReader in(bytes, 0, source);
    switch (static_cast<Request>(in.number())) {
      case Request::kRefusal:
        throw InvalidInput(in.text());
      case Request::kDone:
        id.status = static_cast<IdentificationStatus>(in.number());
        id.reason = in.text();
        return id;
      default:
        ranks.send(0, share.answer(bytes));
    }
  }
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
  Share share(file, train, test, options, ranks, keep);
  if (ranks.rank() != 0) return serve(share, ranks, empty_identification(file, options));
  const RankPasses passes(share, ranks, train.size() + test.size(), static_cast<bool>(keep));
  const auto fit = [&](const IdentificationOptions& how) {
    Identification id = identify_compressed(file, {}, train, test, how, passes);
    id.unusable_recordings = passes.unusable();
    return id;
  };
  Identification id;
  try {
    id = fit(options);
    std::vector<std::string> readable = train;
    for (const UnusedRecording& r : id.unusable_recordings) readable.erase(std::remove(readable.begin(), readable.end(), r.source), readable.end());
    id = with_chosen_velocities(file, std::move(id), readable, options, fit);
  } catch (const InvalidInput& error) {
    ByteWriter refusal = request(Request::kRefusal);
    refusal.text(error.what());
    passes.broadcast(refusal.bytes());
    throw;
  }
  ByteWriter done = request(Request::kDone);
  done.number(static_cast<std::uint64_t>(id.status));
  done.text(id.reason);
  passes.broadcast(done.bytes());
  if (keep) keep(passes.factors(id), true);
  return id;
}

}  // namespace veridyn
