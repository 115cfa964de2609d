#include "veridyn/identification/many_machines.hpp"

#include <algorithm>
#include <iterator>
#include <optional>
#include <unordered_map>
#include <utility>

#include "identification/feasible/feasible_fit.hpp"
#include "identification/many/factor_bytes.hpp"
#include "identification/recording_passes.hpp"
#include "identification/velocity_choice.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {

void exchange(ByteExchange& bytes, UnusedRecording& r) { bytes(r.source, r.why); }

void exchange(ByteExchange& bytes, PredictionError& e) { bytes(e.relative, e.maximum, e.moving_relative); }

void exchange(ByteExchange& bytes, ErrorSums& s) {
  bytes(s.torque2, s.error2, s.torque_max, s.error_max, s.moving_torque2, s.moving_error2);
}

void exchange(ByteExchange& bytes, JointIndex& joint) { bytes(joint.value); }

void exchange(ByteExchange& bytes, PredictionSeries& s) { bytes(s.time, s.q, s.dq, s.ddq, s.measured, s.modelled); }

void exchange(ByteExchange& bytes, MeasuredRecording& r) {
  bytes(r.error.source, r.error.error, r.error.repaired, r.error.without_excluded, r.error.filled.count, r.error.filled.age,
        r.error.rows, r.error.noise_floor, r.error.period, r.error.series, r.sums.as_recorded, r.sums.repaired,
        r.sums.without_excluded);
}

namespace {

// MeasuredRecording with a default constructor, which ByteExchange needs for reading.
struct Measured : MeasuredRecording {
  Measured() : MeasuredRecording{{}, {ErrorSums(0), ErrorSums(0), ErrorSums(0)}, false} {}
  explicit Measured(MeasuredRecording one) : MeasuredRecording(std::move(one)) {}
};

enum class Work { kCompress, kMeasure, kRefuse, kEnd };

// A message of rank 0 to all ranks; for the first two kinds of work rank 0 takes part as well.
struct Request {
  Work work = Work::kCompress;
  // Settings that differ between the fits of one identification: joints with derived velocities, and periods
  // that an earlier fit has found.
  std::vector<JointIndex> derived = {};
  std::vector<std::string> sources = {};
  std::vector<double> periods = {};
  VectorXd values = {};       // parameters whose errors are measured
  int series_samples = 0;
  std::string reason = {};    // reason of a refusal, or of the status of the result
  int status = 0;
};

// Reply of a rank. All other fields of a refusal are empty.
struct RankReply {
  std::string refusal = {};
  std::vector<UnusedRecording> unusable = {};
  std::string factors = {};  // to_bytes()
  std::vector<Measured> train = {}, test = {};
};

void exchange(ByteExchange& bytes, Request& r) {
  int work = static_cast<int>(r.work);
  bytes(work, r.derived, r.sources, r.periods, r.values, r.series_samples, r.reason, r.status);
  r.work = static_cast<Work>(work);
}

void exchange(ByteExchange& bytes, RankReply& a) { bytes(a.refusal, a.unusable, a.factors, a.train, a.test); }

template <typename Message>
Message message_from(const std::string& bytes) {
  Message out;
  ByteExchange(bytes, 0, "a message between ranks")(out);
  return out;
}

// The recordings of one rank, and the passes over them.
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

  RankReply answer(const Request& request) {
    try {
      return request.work == Work::kCompress ? compress_train(request) : measure_all(request);
    } catch (const InvalidInput& error) {
      return {error.what()};
    }
  }

 private:
  // Processes each recording of this rank, so that an unusable one does not affect the others.
  template <typename Do, typename After>
  void for_own(const std::vector<std::string>& all, RankReply& answer, const Do& act, const After& after) const {
    const auto size = static_cast<size_t>(ranks_.size()), rank = static_cast<size_t>(ranks_.rank());
    // Each rank has consecutive recordings, so that the collected factors are in the order of the list.
    for (size_t k = all.size() * rank / size; k < all.size() * (rank + 1) / size; ++k) {
      try {
        act(all[k]);
      } catch (const InvalidInput& error) {
        answer.unusable.push_back({all[k], error.what()});
      }
      after(k + 1 == all.size() * (rank + 1) / size);
    }
  }

  RankReply compress_train(const Request& request) {
    derive_velocities({request.derived.begin(), request.derived.end()}, options_);
    options_.preprocessing.known_periods.clear();
    for (size_t k = 0; k < request.sources.size(); ++k) options_.preprocessing.known_periods[request.sources[k]] = request.periods[k];
    mine_ = compress(arm_, std::vector<std::string>(), options_.preprocessing, 1);
    RankReply out;
    size_t kept = 0;
    const auto compress_one = [&](const std::string& path) {
      CompressedRecording one = compress(arm_, path, options_.preprocessing, options_.threads);
      require(one.rows > 0.0, path, ": found no usable samples after gaps, edges and row limits.");
      merge_blocks(one, blocks_of_each(static_cast<int>(train_.size())));
      mine_.recordings.push_back(std::move(one));
    };
    for_own(train_, out, compress_one, [&](bool last) {
      const size_t done = mine_.recordings.size();
      if (!keep_ || (done < 2 * kept && !last)) return;
      keep_(mine_, false);
      kept = done;
    });
    out.factors = to_bytes(mine_);
    return out;
  }

  RankReply measure_all(const Request& request) const {
    const PreprocessingOptions& of_test = options_.test_preprocessing.value_or(options_.preprocessing);
    const auto errors = [&](const std::vector<CompressedRecording>& all, const PreprocessingOptions& how) {
      std::vector<Measured> out;
      for (const CompressedRecording& r : all)
        out.emplace_back(measure(arm_, r, how, request.values, request.series_samples, options_.threads));
      return out;
    };
    RankReply out;
    FactorSet held_out;
    for_own(test_, out, [&](const std::string& path) {
      held_out.recordings.push_back(compress_test(arm_, {path}, of_test, options_.threads).front());
    }, [](bool) {});
    out.factors = to_bytes(held_out);
    out.train = errors(mine_.recordings, options_.preprocessing);
    out.test = errors(held_out.recordings, of_test);
    return out;
  }

  const Model arm_;
  const std::vector<std::string>& train_;
  const std::vector<std::string>& test_;
  IdentificationOptions options_;
  const Communicator& ranks_;
  const KeepFactors& keep_;
  FactorSet mine_;
};

// Passes of rank 0: each is a request to all ranks, whose replies are merged in the order of the recordings.
class RankPasses final : public RecordingPasses {
 public:
  RankPasses(Share& share, Communicator& ranks, size_t recordings, bool keeps)
      : share_(share), ranks_(ranks), recordings_(recordings), keeps_(keeps) {}

  std::vector<CompressedRecording> compress(const Model&, const std::vector<std::string>& train,
                                            const PreprocessingOptions& how, int) const override {
    Request request;
    request.derived = how.derive_velocity_of;
    for (const auto& [source, period] : how.known_periods) {
      request.sources.push_back(source);
      request.periods.push_back(period);
    }
    FactorSet all;
    unusable_.clear();
    for (RankReply& one : answers(request)) all = merge(std::move(all), factors_from_bytes(one.factors));
    require(!all.recordings.empty(), "not one of ", train.size(), " recordings can be used: ",
            unusable_.empty() ? "" : unusable_.front().why);
    if (keeps_ && !first_) first_ = all;
    if (keeps_) last_ = all;
    return std::move(all.recordings);
  }

  MeasuredRecordings measure(const Model& arm, const std::vector<std::string>&, int, const Identification& id) const override {
    Request request;
    request.work = Work::kMeasure;
    request.series_samples = series_samples_of_each(static_cast<int>(recordings_));
    request.values = values_of(arm, id.parameters);
    MeasuredRecordings out;
    for (RankReply& one : answers(request)) {
      FactorSet held_out = factors_from_bytes(one.factors);
      std::move(held_out.recordings.begin(), held_out.recordings.end(), std::back_inserter(out.held_out));
      std::move(one.train.begin(), one.train.end(), std::back_inserter(out.train));
      std::move(one.test.begin(), one.test.end(), std::back_inserter(out.test));
    }
    return out;
  }

  void send_others(const Request& request) const {
    for (int r = 1; r < ranks_.size(); ++r) ranks_.send(r, bytes_of(request));
  }

  const std::vector<UnusedRecording>& unusable() const { return unusable_; }
  // All factors, with the velocities of the final choice.
  const FactorSet& factors(const Identification& id) const {
    return id.preprocessing.derive_velocity_of.empty() ? *first_ : last_;
  }

 private:
  std::vector<RankReply> answers(const Request& request) const {
    send_others(request);
    std::vector<RankReply> out = {share_.answer(request)};
    for (int r = 1; r < ranks_.size(); ++r) out.push_back(message_from<RankReply>(ranks_.receive(r)));
    for (const RankReply& one : out)
      if (!one.refusal.empty()) throw InvalidInput(one.refusal);
    for (const RankReply& one : out) unusable_.insert(unusable_.end(), one.unusable.begin(), one.unusable.end());
    return out;
  }

  // Parameters of the ranks' arm. Effects that the recordings did not determine, and the fit removed, are
  // zero.
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

// Serves the requests of rank 0 until it ends the work.
Identification serve(Share& share, Communicator& ranks, Identification id) {
  while (true) {
    const auto request = message_from<Request>(ranks.receive(0));
    if (request.work == Work::kRefuse) throw InvalidInput(request.reason);
    if (request.work == Work::kEnd) {
      id.status = static_cast<IdentificationStatus>(request.status);
      id.reason = request.reason;
      return id;
    }
    ranks.send(0, bytes_of(share.answer(request)));
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
  Request end;
  end.work = Work::kRefuse;
  try {
    id = fit(options);
    std::vector<std::string> readable = train;
    for (const UnusedRecording& r : id.unusable_recordings) readable.erase(std::remove(readable.begin(), readable.end(), r.source), readable.end());
    id = with_chosen_velocities(file, std::move(id), readable, options, fit);
  } catch (const InvalidInput& error) {
    end.reason = error.what();
    passes.send_others(end);
    throw;
  }
  end.work = Work::kEnd;
  end.status = static_cast<int>(id.status);
  end.reason = id.reason;
  passes.send_others(end);
  if (keep) keep(passes.factors(id), true);
  return id;
}

}  // namespace veridyn
