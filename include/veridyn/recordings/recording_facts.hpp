#pragma once

#include <string>
#include <vector>

namespace veridyn {

/// A topic of a bag.
struct TopicFacts {
  std::string name;
  std::string type;
  long messages = 0;
  double rate = 0.0;                ///< [Hz] mean rate; 0: fewer than two messages
  std::vector<std::string> joints;  ///< joints with positions, velocities or efforts in it
  bool used = false;                ///< true: it provides signals of the arm
  std::string undecoded;  ///< reason if it is not decoded; empty: it is decoded, or not needed
};

/// A joint of the arm and the name under which it is recorded.
struct JointMatch {
  std::string joint;
  std::string recorded;
};

/// Properties of a recording other than its samples.
struct RecordingFacts {
  std::string format;               ///< "CSV", "ROS 1 bag", "MCAP", ...
  std::vector<std::string> joints;  ///< names, in the order of the columns
  std::vector<JointMatch> matched;  ///< joints that were searched for by name; empty: none were
  std::vector<TopicFacts> topics;   ///< topics of a container; empty for other files
  std::vector<std::string> remarks; ///< whole sentences for the user
  double start = 0.0;  ///< [s since 1970] of time 0; 0: times are those of the file

  /// "joints matched: shoulder_pan = shoulder_pan_joint, ..."; empty if no names were matched.
  std::string match() const;
};

}  // namespace veridyn
