#pragma once

#include <map>
#include <string>

namespace veridyn {

using Constants = std::map<std::string, double>;

/// The value of an arithmetic text over `pi`, the constants and muParser's functions (sin, atan2,
/// sqrt, ...).
///
/// @throws InvalidInput  the expression and the reason why it has no finite value; no file name.
double evaluate(const std::string& expression, const Constants& constants);

/// True if the text is a plain number and not arithmetic.
bool is_plain_number(const std::string& text);

/// @throws InvalidInput  the name cannot stand for a constant in an expression.
void require_constant_name(const std::string& name);

}  // namespace veridyn
