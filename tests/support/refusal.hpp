#pragma once

#include <gtest/gtest.h>

#include <string>

#include "veridyn/math/require.hpp"

namespace veridyn {

/// The message with which `act` refuses its input; empty if it does not.
template <typename Act>
std::string refusal(Act&& act) {
  try {
    act();
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

/// True if `act` refuses its input with a message that contains `part`.
template <typename Act>
testing::AssertionResult refuses_with(const std::string& part, Act&& act) {
  const std::string message = refusal(act);
  if (!message.empty() && message.find(part) != std::string::npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "found the message '" << message << "', expected '" << part << "' in it";
}

}  // namespace veridyn
