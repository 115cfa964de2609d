#pragma once

#include <map>
#include <string>

namespace veridyn {

using Constants = std::map<std::string, double>;

/// Value of an arithmetic expression in `pi`, the constants and muParser's functions (sin, atan2,
/// sqrt, ...).
///
/// @throws InvalidInput  the expression has no finite value; the message has the reason and no file
/// name.
double evaluate(const std::string& expression, const Constants& constants);

/// True if the text is a plain number and no expression.
bool is_plain_number(const std::string& text);

/// @throws InvalidInput  the name cannot be a constant's name in an expression.
void require_constant_name(const std::string& name);

}  // namespace veridyn
