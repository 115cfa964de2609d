#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <vector>

#include "veridyn/math/require.hpp"

// Options that a class takes, and then one of them wrong at a time.

namespace veridyn {

inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kEndless = std::numeric_limits<double>::infinity();

template <typename Options>
using Wrongs = std::vector<std::function<void(Options&)>>;

template <typename Options, typename Make>
void refuses(const Options& good, const Wrongs<Options>& wrongs, const Make& make) {
  EXPECT_NO_THROW(make(good));
  for (size_t k = 0; k < wrongs.size(); ++k) {
    Options wrong = good;
    wrongs[k](wrong);
    EXPECT_THROW(make(wrong), InvalidInput) << "wrong number " << k;
  }
}

// Every one of these numbers below, at or above what it may be, and none at all.
template <typename Options>
Wrongs<Options> each(const std::vector<double Options::*>& members, const std::vector<double>& values) {
  Wrongs<Options> all;
  for (const auto member : members)
    for (const double value : values) all.push_back([=](Options& o) { o.*member = value; });
  return all;
}

template <typename Options>
Wrongs<Options> operator+(Wrongs<Options> a, const Wrongs<Options>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

}  // namespace veridyn
