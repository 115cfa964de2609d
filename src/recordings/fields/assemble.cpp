#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "recordings/fields/choose_fields.hpp"
#include "files/words.hpp"
#include "math/median.hpp"
#include "model/suggestion.hpp"
#include "recordings/fields/import.hpp"
#include "recordings/fields/stream_clock.hpp"
#include "recordings/signals/units.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::recordings {
namespace {

constexpr double kGap = std::numeric_limits<double>::quiet_NaN();
// [ns] Larger times are counted from 1970.
constexpr std::int64_t kSinceAges = 100000000LL * 1000000000LL;
// Other streams are interpolated only across steps shorter than this number of median steps.
constexpr double kLongStep = 2.5;
// A stream is reported if its median step exceeds that of the base by this factor.
constexpr double kSlower = 1.5;

// The stream with the most columns; among equals the longest.
int base_stream(const RawRecording& raw, const ChosenFields& chosen) {
  std::map<int, std::pair<int, std::size_t>> weight;
  for (const auto& places : chosen.places) {
    for (int signal = 0; signal < kSignalCount; ++signal) {
      if (!places[signal]) continue;
      const int stream = places[signal]->stream;
      weight[stream].first += signal == 0 ? 100 : 1;
      weight[stream].second = raw.streams[stream].rows();
    }
  }
  return std::max_element(weight.begin(), weight.end(),
                          [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

// A column of another stream at the times of the base, by linear interpolation; NaN between rows that are
// farther apart than usual.
VectorXd interpolated(const RawStream& stream, std::size_t field, const StreamClock& clock,
                      std::int64_t shift, const std::vector<std::int64_t>& wanted) {
  VectorXd out = VectorXd::Constant(wanted.size(), kGap);
  const auto longest =
      static_cast<std::int64_t>(kLongStep * static_cast<double>(median_step(clock.time)));
  std::size_t next = 0;
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    const std::int64_t t = wanted[k] + shift;
    while (next < clock.time.size() && clock.time[next] < t) ++next;
    const auto at = static_cast<Eigen::Index>(k);
    if (next < clock.time.size() && clock.time[next] == t) {
      out[at] = stream.at(clock.rows[next], field);
    } else if (next > 0 && next < clock.time.size() &&
               clock.time[next] - clock.time[next - 1] <= longest) {
      const double share = static_cast<double>(t - clock.time[next - 1]) /
                           static_cast<double>(clock.time[next] - clock.time[next - 1]);
      out[at] = (1.0 - share) * stream.at(clock.rows[next - 1], field) +
                share * stream.at(clock.rows[next], field);
    }
  }
  return out;
}

class Assembler {
 public:
  Assembler(RawRecording raw, const std::string& path, const SignalChoice& choice)
      : raw_(std::move(raw)), path_(path), choice_(choice), chosen_(choose_fields(raw_, path, choice)) {}

  Imported assemble() {
    const int base = base_stream(raw_, chosen_);
    const StreamClock& clock = clock_of_stream(base);
    require(!clock.time.empty(), path_, ": found no row with positions, expected some.");
    Imported out;
    out.recording.source = path_;
    set_times(clock.time, &out);
    for (int signal = 0; signal < kSignalCount; ++signal) {
      out.recording.*kRecordingSignals[signal].values = values_of(signal, base, &out.facts);
    }
    require(out.recording.q.size() > 0, path_, ": found no positions of all joints, expected some.");
    efforts_in_amperes(&out);
    report_facts(base, &out.facts);
    return out;
  }

 private:
  const StreamClock& clock_of_stream(int stream) {
    auto found = clocks_.find(stream);
    if (found == clocks_.end()) {
      const RawStream& rows = raw_.streams[stream];
      const std::string where = rows.topic.empty() ? path_ : path_ + ": " + rows.topic;
      found = clocks_.emplace(stream, clock_of(rows, where)).first;
    }
    return found->second;
  }

  void set_times(const std::vector<std::int64_t>& time, Imported* out) const {
    const bool since_ages = time.front() > kSinceAges;
    const std::int64_t zero = since_ages ? time.front() : 0;
    if (since_ages) out->facts.start = static_cast<double>(zero) * 1e-9;
    out->recording.time.resize(static_cast<Eigen::Index>(time.size()));
    for (std::size_t k = 0; k < time.size(); ++k)
      out->recording.time[static_cast<Eigen::Index>(k)] = static_cast<double>(time[k] - zero) * 1e-9;
  }

  // Values of a field at the times of the stream `base`; interpolated if it belongs to another stream.
  VectorXd values_of(const FieldPlace& place, int base) {
    const RawStream& stream = raw_.streams[place.stream];
    const auto field = static_cast<std::size_t>(place.field);
    const StreamClock& own = clock_of_stream(base);
    if (place.stream == base) return VectorXd::NullaryExpr(own.rows.size(), [&](Eigen::Index k) { return stream.at(own.rows[k], field); });
    others_.insert(place.stream);
    // If only one of the two streams has stamps, its times are shifted by the usual delay between stamp and
    // recording.
    const StreamClock& other = clock_of_stream(place.stream);
    const bool own_stamps = own.recorded_after != 0;
    const bool other_stamps = other.recorded_after != 0;
    const std::int64_t shift = own_stamps && !other_stamps   ? own.recorded_after
                               : !own_stamps && other_stamps ? -other.recorded_after
                                                             : 0;
    return interpolated(stream, field, other, shift, own.time);
  }

  // The columns of a signal (rows x joints), or empty if the file lacks it.
  MatrixXd values_of(int signal, int base, RecordingFacts* facts) {
    const std::string name = kRecordingSignals[signal].name;
    MatrixXd values;
    std::vector<std::string> missing;
    for (std::size_t j = 0; j < chosen_.places.size(); ++j) {
      const std::optional<FieldPlace>& place = chosen_.places[j][signal];
      VectorXd one;
      if (place) one = values_of(*place, base);
      if (!place || one.array().isNaN().all()) {
        missing.push_back(chosen_.joints[j]);
        continue;
      }
      if (values.size() == 0)
        values = MatrixXd::Constant(one.size(), static_cast<Eigen::Index>(chosen_.places.size()), kGap);
      const UnitScale scale = scale_for(choice_, name, static_cast<int>(j) + 1);
      values.col(static_cast<Eigen::Index>(j)) = scale.changes_nothing() ? one : VectorXd(one.unaryExpr(scale));
    }
    if (values.size() == 0) {
      const bool in_file = std::any_of(chosen_.places.begin(), chosen_.places.end(), [signal](const auto& places) { return places[signal].has_value(); });
      if (in_file) facts->remarks.push_back(text(name, " of ", listed(missing), " holds no number in any row."));
    } else if (!missing.empty()) {
      const bool can_do_without = signal == 1 || signal == 2;
      facts->remarks.push_back(text("the recording has no ", name, " of ", joined(missing),
                                    can_do_without ? ": that of the other joints is left out, too."
                                                   : ": these rows are gaps."));
      if (can_do_without) values.resize(0, 0);
    }
    return values;
  }

  // Converts efforts to currents, if the user has declared them as such.
  void efforts_in_amperes(Imported* out) const {
    if (!is_current_unit(unit_of(choice_, "tau", 0)) || out->recording.tau.size() == 0) return;
    out->recording.current = std::move(out->recording.tau);
    out->recording.tau.resize(0, 0);
  }

  void report_facts(int base, RecordingFacts* facts) {
    facts->format = raw_.format;
    facts->joints = chosen_.joints;
    for (std::size_t j = 0; j < choice_.joints.size() && j < chosen_.recorded.size(); ++j)
      facts->matched.push_back({choice_.joints[j].name, chosen_.recorded[j]});
    for (const RawTopic& topic : raw_.topics) facts->topics.push_back(facts_of(topic));
    const std::vector<std::string> of_signals = std::exchange(facts->remarks, raw_.remarks);
    const auto add = [facts](const std::vector<std::string>& more) { facts->remarks.insert(facts->remarks.end(), more.begin(), more.end()); };
    add(chosen_.remarks);
    add(clock_of_stream(base).remarks);
    add(of_signals);
    for (const int stream : others_) remark_on_slower_stream(stream, base, &facts->remarks);
  }

  TopicFacts facts_of(const RawTopic& topic) const {
    TopicFacts t{topic.name, topic.type, topic.messages, 0.0, {}, false, topic.undecoded};
    if (topic.messages > 1 && topic.last > topic.first)
      t.rate = static_cast<double>(topic.messages - 1) / (static_cast<double>(topic.last - topic.first) * 1e-9);
    for (std::size_t s = 0; s < raw_.streams.size(); ++s) {
      if (raw_.streams[s].topic != topic.name) continue;
      t.used = t.used || !joints_on(static_cast<int>(s)).empty();
      for (const RawField& field : raw_.streams[s].fields) {
        if (field.signal >= 0 && std::find(t.joints.begin(), t.joints.end(), field.joint) == t.joints.end())
          t.joints.push_back(field.joint);
      }
    }
    return t;
  }

  // Remarks on a stream of a lower rate: interpolation to the rows adds no higher frequencies.
  void remark_on_slower_stream(int stream, int base, std::vector<std::string>* remarks) {
    const double step = 1e-9 * static_cast<double>(median_step(clock_of_stream(stream).time));
    const double own = 1e-9 * static_cast<double>(median_step(clock_of_stream(base).time));
    if (!(step > kSlower * own)) return;
    const std::string& topic = raw_.streams[stream].topic;
    remarks->push_back(text(topic.empty() ? "" : topic + ": ", "signals of ", listed(joints_on(stream)), " come every ", 1e3 * step,
                            " ms, and are interpolated at rows every ", 1e3 * own, " ms."));
  }

  // Joints with a signal in a stream.
  std::vector<std::string> joints_on(int stream) const {
    std::vector<std::string> joints;
    for (std::size_t j = 0; j < chosen_.places.size(); ++j) {
      const auto& places = chosen_.places[j];
      const bool here = std::any_of(places.begin(), places.end(), [&](const auto& place) { return place && place->stream == stream; });
      if (here) joints.push_back(chosen_.joints[j]);
    }
    return joints;
  }

  RawRecording raw_;
  const std::string& path_;
  const SignalChoice& choice_;
  ChosenFields chosen_;
  std::map<int, StreamClock> clocks_;
  std::set<int> others_;  // streams that are interpolated
};

}  // namespace

Imported assemble(RawRecording raw, const std::string& path, const SignalChoice& choice) {
  require_known_units(choice);
  return Assembler(std::move(raw), path, choice).assemble();
}

}  // namespace veridyn::recordings
