#include "model/expression.hpp"

#include <muParser.h>

#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "math/excerpt.hpp"
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

mu::Parser parser_with(const Constants& constants) {
  mu::Parser parser;
  parser.DefineConst("pi", M_PI);
  for (const auto& [name, value] : constants) parser.DefineConst(name, value);
  return parser;
}

std::string hint(const mu::Parser::exception_type& error, const Constants& constants) {
  if (error.GetCode() != mu::ecUNASSIGNABLE_TOKEN) return "";
  std::vector<std::string> names{"pi"};
  for (const auto& [name, value] : constants) names.push_back(name);
  return did_you_mean(error.GetToken(), names);
}

std::string why(const mu::Parser::exception_type& error) {
  if (error.GetCode() != mu::ecUNASSIGNABLE_TOKEN) return error.GetMsg();
  return "'" + error.GetToken() + "' is neither a number nor a constant";
}

double parsed(const std::string& expression, const Constants& constants) {
  try {
    mu::Parser parser = parser_with(constants);
    parser.SetExpr(expression);
    const double value = parser.Eval();
    require(parser.GetNumResults() == 1, "'", excerpt(expression),
            "' (several values, separated by commas)");
    return value;
  } catch (const mu::Parser::exception_type& error) {
    throw InvalidInput(text("'", excerpt(expression), "' (", excerpt(why(error), 200), ")", hint(error, constants)));
  }
}

}  // namespace

double evaluate(const std::string& expression, const Constants& constants) {
  const std::optional<double> number = plain_number(expression);
  const double value = number ? *number : parsed(expression, constants);
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
