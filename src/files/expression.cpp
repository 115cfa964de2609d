#include "files/expression.hpp"

#include <muParser.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "model/excerpt.hpp"
#include "veridyn/math/require.hpp"
#include "model/suggestion.hpp"

namespace veridyn {
namespace {

std::optional<double> plain_number(const std::string& text) {
  double value = 0.0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (stop != end || error == std::errc::invalid_argument) return std::nullopt;
  return error == std::errc{} ? value : std::numeric_limits<double>::infinity();
}

bool is_name_character(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

// A parser with those constants whose names occur in the expression: a file may have thousands.
mu::Parser parser_of(const std::string& expression, const Constants& constants) {
  mu::Parser parser;
  parser.DefineConst("pi", M_PI);
  for (std::size_t at = 0; at < expression.size();) {
    std::size_t end = at;
    const bool name = is_name_character(expression[at]) && std::isdigit(static_cast<unsigned char>(expression[at])) == 0;
    while (name && end < expression.size() && is_name_character(expression[end])) ++end;
    const auto known = constants.find(expression.substr(at, end - at));
    if (known != constants.end()) parser.DefineConst(known->first, known->second);
    at = std::max(end, at + 1);
  }
  parser.SetExpr(expression);
  return parser;
}

std::string error_hint(const mu::Parser::exception_type& error, const Constants& constants) {
  if (error.GetCode() != mu::ecUNASSIGNABLE_TOKEN) return "";
  std::vector<std::string> names{"pi"};
  for (const auto& [name, value] : constants) names.push_back(name);
  return did_you_mean(error.GetToken(), names);
}

std::string reason_of(const mu::Parser::exception_type& error) {
  if (error.GetCode() != mu::ecUNASSIGNABLE_TOKEN) return error.GetMsg();
  return "'" + error.GetToken() + "' is neither a number nor a constant";
}

double evaluated(const std::string& expression, const Constants& constants) {
  try {
    mu::Parser parser = parser_of(expression, constants);
    const double value = parser.Eval();
    require(parser.GetNumResults() == 1, "'", excerpt(expression),
            "' (several values, separated by commas)");
    return value;
  } catch (const mu::Parser::exception_type& error) {
    throw InvalidInput(text("'", excerpt(expression), "' (", excerpt(reason_of(error), 200), ")", error_hint(error, constants)));
  }
}

}  // namespace

double evaluate(const std::string& expression, const Constants& constants) {
  const std::optional<double> number = plain_number(expression);
  const double value = number ? *number : evaluated(expression, constants);
  require(std::isfinite(value), "'", excerpt(expression), "' (not finite)");
  return value;
}

bool is_plain_number(const std::string& text) {
  return plain_number(text).has_value();
}

void require_constant_name(const std::string& name) {
  try {
    mu::Parser parser;
    require(name != "pi" && parser.GetFunDef().count(name) == 0, "'", name,
            "', which has a meaning already");
    parser.DefineConst(name, 0.0);
  } catch (const mu::Parser::exception_type& error) {
    throw InvalidInput(text("'", name, "' (", error.GetMsg(), ")"));
  }
}

}  // namespace veridyn
