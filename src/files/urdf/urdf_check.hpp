#pragma once

#include <string>

class TiXmlDocument;

namespace veridyn {

/// Refuses a URDF that urdfdom would refuse or read in part, which names no line: xacro that was not
/// expanded, numbers that are none, joints without what their type needs, links that no tree connects.
/// @throws InvalidInput  with file, line, joint or link, and what to write.
void check_urdf(const std::string& file, const TiXmlDocument& xml);

}  // namespace veridyn
