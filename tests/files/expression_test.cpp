#include "files/expression.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "veridyn/math/require.hpp"
#include "support/refusal.hpp"

namespace veridyn {
namespace {

std::string reason(const std::string& expression, const Constants& constants = {}) {
  return refusal([&] { evaluate(expression, constants); });
}

TEST(Expression, NumbersAreReadExactly) {
  EXPECT_EQ(evaluate("0.1", {}), 0.1);
  EXPECT_EQ(evaluate("-1.2345678901234567e-300", {}), -1.2345678901234567e-300);
}

TEST(Expression, EvaluatesPiFunctionsAndConstants) {
  EXPECT_EQ(evaluate("-pi/2", {}), -M_PI / 2);
  EXPECT_EQ(evaluate("atan(0.0430/0.1437)", {}), std::atan(0.0430 / 0.1437));
  EXPECT_EQ(evaluate("2*l^2 + sqrt(l)", {{"l", 4.0}}), 34.0);
}

TEST(Expression, TheLongestMatchingNameIsRead) {
  const Constants constants = {{"l", 1.0}, {"l_2", 10.0}, {"l_20", 100.0}, {"_a", 1000.0}, {"E", 7.0}, {"e3", 9.0}};
  EXPECT_EQ(evaluate("l_20-l_2+l", constants), 91.0);
  EXPECT_EQ(evaluate("(_a)*2", constants), 2000.0);
  EXPECT_EQ(evaluate("E*1E3+e3*1e3", constants), 16000.0);
}

TEST(Expression, InvalidExpressionsAreQuotedWithTheReason) {
  EXPECT_NE(reason("2*(3").find("'2*(3' ("), std::string::npos);
  EXPECT_NE(reason("").find("''"), std::string::npos);
  EXPECT_NE(reason("1, 2").find("several values"), std::string::npos);
  EXPECT_NE(reason("betta/2", {{"beta", 1.0}}).find("did you mean 'beta'?"), std::string::npos);
}

TEST(Expression, NonFiniteValuesAreRejected) {
  for (const char* expression : {"1/0", "sqrt(-1)", "nan", "inf", "1e999"})
    EXPECT_NE(reason(expression), "") << expression;
}

TEST(Expression, ReservedAndInvalidConstantNamesAreRefused) {
  for (const char* name : {"pi", "sin", "2x", "a-b", ""})
    EXPECT_THROW(require_constant_name(name), InvalidInput) << name;
  EXPECT_NO_THROW(require_constant_name("l_2"));
}

}  // namespace
}  // namespace veridyn
