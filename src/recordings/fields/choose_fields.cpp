#include "recordings/fields/choose_fields.hpp"

#include <algorithm>
#include <cctype>
#include <map>
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

// Joints of a topic that have a position, in the order of first appearance; numbers as names are sorted by
// value.
std::vector<std::string> joints_with_position(const RawRecording& raw, const std::string& topic) {
  std::vector<std::string> joints;
  for (const RawStream& stream : raw.streams) {
    if (stream.topic != topic || stream.rows() == 0) continue;
    for (const RawField& field : stream.fields) {
      if (field.signal != kQ) continue;
      if (std::find(joints.begin(), joints.end(), field.joint) == joints.end())
        joints.push_back(field.joint);
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
  std::optional<FieldPlace> best;
  std::size_t rows = 0;
  for (std::size_t s = 0; s < raw.streams.size(); ++s) {
    const RawStream& stream = raw.streams[s];
    if (stream.topic != topic || stream.rows() <= rows) continue;
    for (std::size_t f = 0; f < stream.fields.size(); ++f) {
      if (stream.fields[f].signal != signal || stream.fields[f].joint != joint) continue;
      best = FieldPlace{static_cast<int>(s), static_cast<int>(f)};
      rows = stream.rows();
    }
  }
  return best;
}

std::vector<std::string> topics_of(const RawRecording& raw, const SignalChoice& choice) {
  std::vector<std::string> topics;
  for (const RawStream& stream : raw.streams) {
    const bool wanted = choice.topics.empty() || std::find(choice.topics.begin(),
                                                           choice.topics.end(),
                                                           stream.topic) != choice.topics.end();
    if (wanted && std::find(topics.begin(), topics.end(), stream.topic) == topics.end())
      topics.push_back(stream.topic);
  }
  return topics;
}

void require_topics(const RawRecording& raw, const std::string& path, const SignalChoice& choice) {
  if (choice.topics.empty()) return;
  std::vector<std::string> known;
  for (const RawTopic& topic : raw.topics) known.push_back(topic.name);
  for (const RawStream& stream : raw.streams) {
    if (std::find(known.begin(), known.end(), stream.topic) == known.end())
      known.push_back(stream.topic);
  }
  for (const std::string& topic : choice.topics) {
    const bool there = std::find(known.begin(), known.end(), topic) != known.end();
    require(there, path, ": found no topic ", topic, did_you_mean(topic, known), ", expected one of: ",
            listed(known), ".");
    for (const RawTopic& t : raw.topics) {
      require(t.name != topic || t.undecoded.empty(), path, ": topic ", topic, " (", t.type,
              ") cannot be used: ", t.undecoded, ".");
    }
  }
}

// Rank of a topic: measured ones first, then unnamed, then commanded ones.
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
  std::vector<std::string> wanted;
  for (const WantedJoint& joint : choice.joints) wanted.push_back(joint.name);
  if (wanted.empty()) {
    c.matched = static_cast<int>(c.recorded.size());
    for (int k = 0; k < c.matched; ++k) c.match.push_back(k);
  } else {
    try {
      c.match = match_joints(wanted, c.recorded, renamed);
    } catch (const InvalidInput& error) {
      c.problem = error.what();
      c.match.assign(wanted.size(), -1);
    }
    c.matched = static_cast<int>(std::count_if(c.match.begin(), c.match.end(), [](int k) { return k >= 0; }));
  }
  for (const std::string& joint : c.recorded)
    c.efforts = c.efforts || place_of(raw, topic, joint, kTau) ||
                place_of(raw, topic, joint, kCurrent);
  return c;
}

bool is_better(const Candidate& a, const Candidate& b) {
  if (a.matched != b.matched) return a.matched > b.matched;
  if (a.rank != b.rank) return a.rank < b.rank;
  return a.efforts && !b.efforts;
}

// The joints of a file without positions, for messages.
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
  const std::size_t all = words.size();
  if (all > 12) words.resize(12);
  return listed(words) + (all > 12 ? text(", ... (", all, ")") : "");
}

Candidate best_candidate(const RawRecording& raw, const std::string& path,
                         const SignalChoice& choice,
                         const std::map<std::string, std::string>& renamed,
                         std::vector<std::string>* remarks) {
  std::vector<Candidate> candidates;
  for (const std::string& topic : topics_of(raw, choice)) {
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

// Adds the efforts of a separate topic with as many numbers as joints and a matching name.
void add_separate_efforts(const RawRecording& raw, const std::vector<std::string>& taken_topics,
                          ChosenFields* chosen) {
  const auto lacks = [&](int signal) {
    return std::none_of(chosen->places.begin(), chosen->places.end(),
                        [&](const auto& p) { return p[signal].has_value(); });
  };
  if (!lacks(kTau) || !lacks(kCurrent)) return;
  const std::size_t n = chosen->joints.size();
  for (const RawStream& stream : raw.streams) {  // the same joints on another topic
    if (stream.topic == taken_topics.front() || rank_of(stream.topic) > 1) continue;
    for (std::size_t j = 0; j < n; ++j)
      chosen->places[j][kTau] = place_of(raw, stream.topic, chosen->recorded[j], kTau);
    if (std::all_of(chosen->places.begin(), chosen->places.end(),
                    [](const auto& p) { return p[kTau].has_value(); })) {
      chosen->remarks.push_back(text("torques are taken from ", stream.topic, "."));
      return;
    }
    for (auto& place : chosen->places) place[kTau] = {};
  }
  for (std::size_t s = 0; s < raw.streams.size(); ++s) {
    const RawStream& stream = raw.streams[s];
    if (std::find(taken_topics.begin(), taken_topics.end(), stream.topic) != taken_topics.end())
      continue;
    if (stream.topic.empty() || rank_of(stream.topic) > 1) continue;
    int signal = -1;
    for (const std::string& word : words_of(stream.topic)) {
      if (word == "effort" || word == "efforts" || word == "torque" || word == "torques")
        signal = kTau;
      if (word == "current" || word == "currents") signal = kCurrent;
    }
    std::vector<int> fields;
    for (std::size_t f = 0; f < stream.fields.size(); ++f) {
      if (stream.fields[f].path.rfind("data/", 0) == 0) fields.push_back(static_cast<int>(f));
    }
    if (signal < 0 || fields.size() != n) continue;
    for (std::size_t j = 0; j < n; ++j)
      chosen->places[j][signal] = {static_cast<int>(s), fields[j]};
    chosen->remarks.push_back(text(signal == kTau ? "torques" : "currents", " are taken from ",
                                   stream.topic, ", its ", n, " numbers in the order of the joints."));
    return;
  }
}

// Throws if the file lacks joints of the arm; the message has their names and those in the file.
void require_all_joints(const Candidate& c, const std::string& path, const SignalChoice& choice,
                        const std::vector<char>& mapped) {
  std::vector<std::string> missing;
  for (std::size_t j = 0; j < choice.joints.size(); ++j) {
    if (c.match[j] < 0 && mapped[j] == 0) missing.push_back(choice.joints[j].name);
  }
  if (missing.empty()) return;
  const std::string& one = missing.front();
  throw InvalidInput(text(path, ": found joints ", listed(c.recorded),
                          c.topic.empty() ? "" : " on topic " + c.topic, ", and none that is ",
                          listed(missing), ", expected --map ", one, "=NAME, or --fix ", one,
                          "=VALUE where it is not recorded; files with a part of the joints each are one recording, a.csv+b.csv",
                          c.problem.empty() ? "" : " (" + c.problem + ")", "."));
}

// Columns named exactly like a joint are its positions.
void name_bare_positions(const SignalChoice& choice, RawRecording* raw) {
  for (const RawStream& stream : raw->streams) {
    for (const RawField& field : stream.fields) {
      if (field.signal == kQ) return;
    }
  }
  for (RawStream& stream : raw->streams) {
    std::vector<std::string> names;
    for (const RawField& field : stream.fields) names.push_back(field.path);
    std::vector<std::string> wanted;
    for (const WantedJoint& joint : choice.joints) wanted.push_back(joint.name);
    std::vector<int> match;
    try {
      match = match_joints(wanted, names, {});
    } catch (const InvalidInput&) {
      continue;
    }
    if (match.empty() || std::find(match.begin(), match.end(), -1) != match.end()) continue;
    for (const int field : match) {
      RawField& found = stream.fields[field];
      found.joint = found.path;
      found.signal = kQ;
    }
  }
}

}  // namespace

ChosenFields choose_fields(const RawRecording& given, const std::string& path,
                           const SignalChoice& choice) {
  require_topics(given, path, choice);
  RawRecording named;
  const RawRecording* raw = &given;
  if (!choice.joints.empty() && given.topics.empty()) {
    named = given;
    name_bare_positions(choice, &named);
    raw = &named;
  }
  const FieldMap map(*raw, path, choice);
  ChosenFields chosen;
  std::vector<char> mapped;
  if (map.maps_all_positions()) {
    // All positions are mapped, so that no topic has to be found.
    const std::size_t n = choice.joints.empty() ? map.largest_joint() : choice.joints.size();
    for (std::size_t j = 0; j < n; ++j) {
      chosen.joints.push_back(choice.joints.empty() ? std::to_string(j + 1) : choice.joints[j].name);
      chosen.recorded.push_back(chosen.joints.back());
    }
    chosen.places.resize(n);
  } else {
    const Candidate c = best_candidate(*raw, path, choice, map.renamed(), &chosen.remarks);
    const std::size_t n = c.match.size();
    mapped.resize(n);
    for (std::size_t j = 0; j < n; ++j) mapped[j] = map.place(kQ, j) ? 1 : 0;
    if (!choice.joints.empty()) require_all_joints(c, path, choice, mapped);
    chosen.places.resize(n);
    std::vector<std::string> topics = {c.topic};
    for (std::size_t j = 0; j < n; ++j) {
      const std::string recorded =
          c.match[j] < 0 ? std::string() : c.recorded[c.match[j]];
      chosen.recorded.push_back(recorded);
      chosen.joints.push_back(choice.joints.empty() ? recorded : choice.joints[j].name);
      if (recorded.empty()) continue;
      for (int signal = 0; signal < kSignalCount; ++signal) {
        std::optional<FieldPlace>& place = chosen.places[j][signal];
        place = place_of(*raw, c.topic, recorded, signal);
        // Further chosen topics provide the signals that the first one lacks.
        for (const std::string& other : choice.topics) {
          if (!place) place = place_of(*raw, other, recorded, signal);
        }
      }
    }
    if (!map.maps_signal(kTau) && !map.maps_signal(kCurrent)) add_separate_efforts(*raw, topics, &chosen);
  }
  const auto by_name = chosen.places;
  for (const auto& [to, from] : map.taken()) {
    require(to.second < by_name.size() && from.joint < by_name.size(), path,
            ": --map: found joint ", std::max(to.second, from.joint) + 1, ", expected 1 to ",
            by_name.size(), ".");
    chosen.places[to.second][to.first] =
        by_name[from.joint][from.signal];
  }
  for (std::size_t j = 0; j < chosen.places.size(); ++j) {
    for (int signal = 0; signal < kSignalCount; ++signal) {
      if (const auto place = map.place(signal, j)) chosen.places[j][signal] = place;
    }
  }
  return chosen;
}

}  // namespace veridyn::recordings
