#include "veridyn/recordings/recording_facts.hpp"

namespace veridyn {

std::string RecordingFacts::match() const {
  std::string line;
  for (const JointMatch& one : matched)
    line += (line.empty() ? "joints matched: " : ", ") + one.joint + " = " + one.recorded;
  return line;
}

}  // namespace veridyn
