#pragma once

#include <string>
#include <vector>

namespace veridyn {

/// A topic of a bag.
struct TopicFacts {
  std::string name;
  std::string type;
  long messages = 0;
  double rate = 0.0;                ///< [Hz] mean; 0: fewer than two messages
  std::vector<std::string> joints;  ///< whose positions, velocities or efforts it holds
  bool used = false;                ///< signals of the arm are taken from it
  std::string undecoded;            ///< why it cannot be decoded; empty: it can, or need not be
};

/// A joint of the arm and the name under which it is recorded.
struct JointMatch {
  std::string joint;
  std::string recorded;
};

/// What is known of a recording beside its numbers.
struct RecordingFacts {
  std::string format;               ///< "CSV", "ROS 1 bag", "MCAP", ...
  std::vector<std::string> joints;  ///< names, in the order of the columns
  std::vector<JointMatch> matched;  ///< joints that were looked for; empty: none were
  std::vector<TopicFacts> topics;   ///< Topics of a container; empty otherwise
  std::vector<std::string> remarks; ///< whole sentences for the user
  double start = 0.0;  ///< [s since 1970] of time 0; 0: the time column is as in the file

  /// "joints matched: shoulder_pan = shoulder_pan_joint, ..."; empty where no names were matched.
  std::string match() const;
};

}  // namespace veridyn
