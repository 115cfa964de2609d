#include "recordings/fields/choose_fields.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <set>

#include "files/words.hpp"
#include "recordings/fields/field_map.hpp"
#include "recordings/signals/joint_fields.hpp"
#include "recordings/fields/joint_match.hpp"
#include "veridyn/math/require.hpp"
#include "model/suggestion.hpp"

namespace veridyn::recordings {
namespace {

constexpr int kQ = 0, kTau = 3, kCurrent = 4;
constexpr std::size_t kNamed = 12;  // largest number of names in a message
constexpr std::size_t kDigits = 6;  // of the number of a joint; longer ones are none

template <typename List, typename Value>
bool contains(const List& list, const Value& value) {
  return std::find(list.begin(), list.end(), value) != list.end();
}

// Joints of a topic that have a position, in the order of first appearance; numbers as names are sorted by value.
std::vector<std::string> joints_with_position(const RawRecording& raw, const std::string& topic) {
  std::vector<std::string> joints;
  for (const RawStream& stream : raw.streams) {
    if (stream.topic != topic || stream.rows() == 0) continue;
    for (const RawField& field : stream.fields) {
      if (field.signal == kQ && !contains(joints, field.joint)) joints.push_back(field.joint);
    }
  }
  if (std::all_of(joints.begin(), joints.end(), is_number)) {
    std::stable_sort(joints.begin(), joints.end(), [](const auto& a, const auto& b) {
      return a.size() != b.size() ? a.size() < b.size() : a < b;
    });
  }
  return joints;
}

// The longest stream of the topic that has this signal of the joint.
std::optional<FieldPlace> place_of(const RawRecording& raw, const std::string& topic, const std::string& joint,
                    int signal) {
  return longest_field(raw, [&](const RawStream& stream, const RawField& field) {
    return stream.topic == topic && field.signal == signal && field.joint == joint;
  });
}

// Adds the topics of all streams to those that are known already.
std::vector<std::string> with_streams(std::vector<std::string> topics, const RawRecording& raw) {
  for (const RawStream& stream : raw.streams) {
    if (!contains(topics, stream.topic)) topics.push_back(stream.topic);
  }
  return topics;
}

void require_topics(const RawRecording& raw, const std::string& path, const SignalChoice& choice) {
  std::vector<std::string> known;
  for (const RawTopic& topic : raw.topics) known.push_back(topic.name);
  known = with_streams(std::move(known), raw);
  for (const std::string& topic : choice.topics) {
    require(contains(known, topic), path, ": found no topic ", topic, did_you_mean(topic, known), ", expected one of: ",
            listed(known), ".");
    for (const RawTopic& t : raw.topics) {
      require(t.name != topic || t.undecoded.empty(), path, ": topic ", topic, " (", t.type,
              ") cannot be used: ", t.undecoded, ".");
    }
  }
}

// Rank of a topic by its name: measured topics come first, then other names, then commanded ones.
int rank_of(const std::string& topic) {
  static const std::set<std::string> kCommanded = {"setpoint", "desired", "goal",     "command",
                                                   "target",   "servo",   "commands", "reference",
                                                   "move",     "interpolate"};
  int rank = 1;
  for (const std::string& word : words_of(topic)) {
    if (word == "measured" || word == "actual") rank = 0;
    if (kCommanded.count(word) > 0) rank = 3;
  }
  return rank;
}

std::vector<std::string> wanted_names(const std::vector<WantedJoint>& joints) {
  std::vector<std::string> names;
  for (const WantedJoint& joint : joints) names.push_back(joint.name);
  return names;
}

struct Candidate {
  std::string topic;
  std::vector<std::string> recorded;  // joints with a position
  std::vector<int> match;             // for each wanted joint an index into recorded, or -1
  int matched = 0;
  int rank = 0;
  bool efforts = false;
  std::string problem;  // reason for which names are ambiguous
};

Candidate candidate_of(const RawRecording& raw, const std::string& topic,
                       const SignalChoice& choice, const std::map<std::string, std::string>& renamed) {
  Candidate c;
  c.topic = topic;
  c.recorded = joints_with_position(raw, topic);
  c.rank = rank_of(topic);
  try {
    c.match = match_joints(wanted_names(choice.joints), c.recorded, renamed);
  } catch (const InvalidInput& error) {
    c.problem = error.what();
    c.match.assign(choice.joints.size(), -1);
  }
  if (choice.joints.empty()) {
    c.match.resize(c.recorded.size());
    std::iota(c.match.begin(), c.match.end(), 0);
  }
  c.matched = static_cast<int>(std::count_if(c.match.begin(), c.match.end(), [](int k) { return k >= 0; }));
  c.efforts = std::any_of(c.recorded.begin(), c.recorded.end(), [&](const std::string& joint) {
    return place_of(raw, topic, joint, kTau) || place_of(raw, topic, joint, kCurrent);
  });
  return c;
}

bool is_better(const Candidate& a, const Candidate& b) {
  if (a.matched != b.matched) return a.matched > b.matched;
  if (a.rank != b.rank) return a.rank < b.rank;
  return a.efforts && !b.efforts;
}

// Lists the joints of a file without positions, for messages.
std::string found_joints_text(const RawRecording& raw) {
  std::vector<std::string> words;
  for (const RawTopic& topic : raw.topics)
    words.push_back(topic.name + " (" + topic.type + ")" +
                    (topic.undecoded.empty() ? "" : ", not decoded: " + topic.undecoded));
  if (raw.topics.empty()) {
    for (const RawStream& stream : raw.streams) {
      for (const RawField& field : stream.fields) words.push_back(field.path);
    }
  }
  return first_listed(std::move(words));
}

Candidate best_candidate(const RawRecording& raw, const std::string& path,
                         const SignalChoice& choice,
                         const std::map<std::string, std::string>& renamed,
                         std::vector<std::string>* remarks) {
  std::vector<Candidate> candidates;
  for (const std::string& topic : with_streams({}, raw)) {
    if (!choice.topics.empty() && !contains(choice.topics, topic)) continue;
    Candidate candidate = candidate_of(raw, topic, choice, renamed);
    if (!candidate.recorded.empty()) candidates.push_back(std::move(candidate));
  }
  require(!candidates.empty(), path, ": found ", found_joints_text(raw),
          ", expected positions of joints (sensor_msgs/JointState, columns such as q1 or "
          "shoulder/position); --map names others.");
  std::stable_sort(candidates.begin(), candidates.end(), is_better);
  const Candidate& first = candidates.front();
  if (candidates.size() > 1 && !is_better(first, candidates[1])) {
    std::vector<std::string> equal;
    for (const Candidate& c : candidates) {
      if (!is_better(first, c)) equal.push_back(c.topic);
    }
    require(choice.joints.empty() || first.matched == 0, path, ": found the arm's joints on topics ",
            listed(equal), ", expected one: choose it with --topic.");
    remarks->push_back(text("joints are on topics ", listed(equal), "; ", first.topic,
                            " is taken (--topic chooses)."));
  }
  require(first.problem.empty() || first.matched > 0, path, ": ", first.problem);
  return first;
}

// The signal that the name of a topic of plain numbers stands for, or -1.
int effort_signal_of(const std::string& topic) {
  static const std::map<std::string, int> kWords = {{"effort", kTau},  {"efforts", kTau},     {"torque", kTau},
                                                    {"torques", kTau}, {"current", kCurrent}, {"currents", kCurrent}};
  int signal = -1;
  for (const std::string& word : words_of(topic)) {
    const auto found = kWords.find(word);
    if (found != kWords.end()) signal = found->second;
  }
  return signal;
}

// Adds the efforts of a separate topic, which has the same joints, or as many numbers as joints and a matching
// name.
void add_separate_efforts(const RawRecording& raw, const std::string& taken, ChosenFields* chosen) {
  const auto has = [&](int signal) { return [signal](const auto& places) { return places[signal].has_value(); }; };
  auto& places = chosen->places;
  if (std::any_of(places.begin(), places.end(), has(kTau)) || std::any_of(places.begin(), places.end(), has(kCurrent))) return;
  for (const RawStream& stream : raw.streams) {
    if (stream.topic == taken || rank_of(stream.topic) > 1) continue;
    for (std::size_t j = 0; j < places.size(); ++j) places[j][kTau] = place_of(raw, stream.topic, chosen->recorded[j], kTau);
    if (std::all_of(places.begin(), places.end(), has(kTau))) {
      chosen->remarks.push_back(text("torques are taken from ", stream.topic, "."));
      return;
    }
    for (auto& place : places) place[kTau] = {};
  }
  for (std::size_t s = 0; s < raw.streams.size(); ++s) {
    const RawStream& stream = raw.streams[s];
    const int signal = stream.topic == taken || stream.topic.empty() || rank_of(stream.topic) > 1 ? -1 : effort_signal_of(stream.topic);
    std::vector<FieldPlace> numbers;
    for (std::size_t f = 0; f < stream.fields.size(); ++f) {
      if (starts_with(stream.fields[f].path, "data/")) numbers.push_back({static_cast<int>(s), static_cast<int>(f)});
    }
    if (signal < 0 || numbers.size() != places.size()) continue;
    for (std::size_t j = 0; j < places.size(); ++j) places[j][signal] = numbers[j];
    chosen->remarks.push_back(text(signal == kTau ? "torques" : "currents", " are taken from ", stream.topic, ", its ", places.size(),
                                   " numbers in the order of the joints."));
    return;
  }
}

// Throws if the file lacks joints of the arm; the message has their names and those in the file.
void require_all_joints(const Candidate& c, const std::string& path, const SignalChoice& choice, const FieldMap& map) {
  std::vector<std::string> missing;
  for (std::size_t j = 0; j < choice.joints.size(); ++j) {
    if (c.match[j] < 0 && !map.place(kQ, j)) missing.push_back(choice.joints[j].name);
  }
  if (missing.empty()) return;
  const std::string& one = missing.front();
  throw InvalidInput(text(path, ": found joints ", listed(c.recorded),
                          c.topic.empty() ? "" : " on topic " + c.topic, ", and none that is ",
                          listed(missing), ", expected --map ", one, "=NAME, or --fix ", one,
                          "=VALUE where it is not recorded; files with a part of the joints each are one recording, a.csv+b.csv",
                          c.problem.empty() ? "" : " (" + c.problem + ")", "."));
}

// Columns named exactly like a joint are its positions, in a table without others.
void name_bare_positions(const SignalChoice& choice, RawRecording& raw) {
  if (choice.joints.empty() || !raw.topics.empty()) return;
  for (const RawStream& stream : raw.streams) {
    if (std::any_of(stream.fields.begin(), stream.fields.end(), [](const RawField& f) { return f.signal == kQ; })) return;
  }
  for (RawStream& stream : raw.streams) {
    std::vector<std::string> names;
    for (const RawField& field : stream.fields) names.push_back(field.path);
    std::vector<int> match;
    try {
      match = match_joints(wanted_names(choice.joints), names, {});
    } catch (const InvalidInput&) {
      continue;
    }
    if (contains(match, -1)) continue;
    for (const int field : match) {
      RawField& found = stream.fields[static_cast<std::size_t>(field)];
      found.joint = found.path;
      found.signal = kQ;
    }
  }
}

// The columns of the topic that fits the arm best.
ChosenFields fields_of_best_topic(const RawRecording& raw, const std::string& path, const SignalChoice& choice, const FieldMap& map) {
  ChosenFields chosen;
  const Candidate c = best_candidate(raw, path, choice, map.renamed, &chosen.remarks);
  require_all_joints(c, path, choice, map);
  // Other topics that the user chose provide the signals that the first one lacks.
  std::vector<std::string> topics = {c.topic};
  topics.insert(topics.end(), choice.topics.begin(), choice.topics.end());
  chosen.places.resize(c.match.size());
  for (std::size_t j = 0; j < c.match.size(); ++j) {
    chosen.recorded.push_back(c.match[j] < 0 ? std::string() : c.recorded[c.match[j]]);
    chosen.joints.push_back(choice.joints.empty() ? chosen.recorded[j] : choice.joints[j].name);
    for (int signal = 0; signal < kSignalCount && !chosen.recorded[j].empty(); ++signal) {
      for (const std::string& topic : topics) {
        if (!chosen.places[j][signal]) chosen.places[j][signal] = place_of(raw, topic, chosen.recorded[j], signal);
      }
    }
  }
  if (!map.maps_signal(kTau) && !map.maps_signal(kCurrent)) add_separate_efforts(raw, c.topic, &chosen);
  return chosen;
}

// The joints of a recording whose positions are all mapped, so that no topic has to be found.
ChosenFields mapped_joints(std::size_t joints, const SignalChoice& choice) {
  ChosenFields chosen;
  for (std::size_t j = 0; j < joints; ++j) chosen.joints.push_back(choice.joints.empty() ? std::to_string(j + 1) : choice.joints[j].name);
  chosen.recorded = chosen.joints;
  chosen.places.resize(joints);
  return chosen;
}

// Where the positions of a topic are numbered from 0 and another signal of as many joints from 1, or the reverse, gives the
// latter the numbers of the positions. Numbers that begin elsewhere are those of other joints.
void number_as_positions(RawRecording& raw) {
  std::map<std::pair<std::string, int>, std::set<long>> numbers;
  const auto number = [](const std::string& joint) { return is_number(joint) && joint.size() <= kDigits ? std::stol(joint) : -1; };
  for (const RawStream& stream : raw.streams) {
    for (const RawField& field : stream.fields) {
      if (field.signal >= 0) numbers[{stream.topic, field.signal}].insert(number(field.joint));
    }
  }
  for (RawStream& stream : raw.streams) {
    const std::set<long>& of_positions = numbers[{stream.topic, kQ}];
    for (RawField& field : stream.fields) {
      if (field.signal < 0 || of_positions.empty()) continue;
      const std::set<long>& own = numbers[{stream.topic, field.signal}];
      const long shift = *of_positions.begin() - *own.begin();
      const bool from_zero_and_one = std::min(*of_positions.begin(), *own.begin()) == 0 && std::abs(shift) == 1;
      if (from_zero_and_one && own.size() == of_positions.size() && *of_positions.rbegin() - *own.rbegin() == shift) field.joint = std::to_string(number(field.joint) + shift);
    }
  }
}

}  // namespace

std::string first_listed(std::vector<std::string> names) {
  const std::size_t all = names.size();
  names.resize(std::min(all, kNamed));
  return listed(names) + (all > kNamed ? text(", ... (", all, ")") : "");
}

ChosenFields choose_fields(RawRecording& raw, const std::string& path, const SignalChoice& choice) {
  require_topics(raw, path, choice);
  name_bare_positions(choice, raw);
  number_as_positions(raw);
  const FieldMap map = field_map(raw, path, choice);
  const std::size_t mapped = map.mapped_joints(choice.joints.size());
  ChosenFields chosen = mapped > 0 ? mapped_joints(mapped, choice) : fields_of_best_topic(raw, path, choice, map);
  const auto by_name = chosen.places;
  for (const auto& [to, from] : map.taken) {
    require(to.second < by_name.size() && from.second < by_name.size(), path, ": --map: found joint ",
            std::max(to.second, from.second) + 1, ", expected 1 to ", by_name.size(), ".");
    chosen.places[to.second][to.first] = by_name[from.second][from.first];
  }
  for (const auto& [to, place] : map.places) {
    if (to.second < chosen.places.size()) chosen.places[to.second][to.first] = place;
  }
  return chosen;
}

}  // namespace veridyn::recordings
