#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>

#include "effects/effect_support.hpp"
#include "effects/registry.hpp"
#include "veridyn/effects/cause.hpp"
#include "veridyn/math/require.hpp"
#include "effects/effect_names.hpp"

namespace veridyn {
namespace {

bool is_effect_key(const std::string& word) {
  const auto& keys = effect_keys();
  return std::find(keys.begin(), keys.end(), word) != keys.end();
}

class EveryAxisEffect : public testing::TestWithParam<std::string> {
 protected:
  static const AxisEffect& effect() { return find_axis_effect(GetParam()); }
};
INSTANTIATE_TEST_SUITE_P(Axis, EveryAxisEffect, testing::ValuesIn(axis_effect_names()),
                         effect_case);

// docs/contract.md names every effect and every other cause, and nothing else; docs/causes.md explains them.
TEST(EffectRegistry, EveryEffectAndCauseIsDocumentedAndNoOther) {
  std::ifstream file(std::string(VERIDYN_SOURCE_DIR) + "/docs/contract.md");
  ASSERT_TRUE(file.good());
  const std::string all((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const std::size_t begin = all.find("These names are used in files");
  ASSERT_NE(begin, std::string::npos);
  const std::string section = all.substr(all.find("\n\n", begin), all.find("\n## ", begin) - all.find("\n\n", begin));
  const std::regex name("`([a-z_]+)`");
  std::set<std::string> in_contract;
  for (std::sregex_iterator it(section.begin(), section.end(), name), end; it != end; ++it) in_contract.insert((*it)[1]);
#define VERIDYN_NAME_OF(name) #name,
  std::set<std::string> known{VERIDYN_EFFECTS(VERIDYN_NAME_OF)};
#undef VERIDYN_NAME_OF
  for (const std::string& cause : names_of_causes()) known.insert(cause);
  known.insert("none");
  known.erase("tabulated_force");  // a diagnosis writes it; nobody asks for it by name
  EXPECT_EQ(in_contract, known);

  std::ifstream page(std::string(VERIDYN_SOURCE_DIR) + "/docs/causes.md");
  const std::string causes((std::istreambuf_iterator<char>(page)), std::istreambuf_iterator<char>());
  const std::regex row("\\| `([a-z_]+)`<br>!\\[");
  std::set<std::string> explained{"none"};
  for (std::sregex_iterator it(causes.begin(), causes.end(), row), end; it != end; ++it) explained.insert((*it)[1]);
  EXPECT_EQ(explained, known);
}

TEST(EffectRegistry, AnUnknownNameIsRejectedWithAlternatives) {
  EXPECT_FALSE(has_effect("payload"));
  EXPECT_TRUE(has_effect("backlash"));
  try {
    find_effect("viscos_friction");
    FAIL() << "nothing was thrown";
  } catch (const InvalidInput& e) {
    EXPECT_NE(std::string(e.what()).find("did you mean 'viscous_friction'?"), std::string::npos)
        << e.what();
  }
}

TEST_P(EveryAxisEffect, HasUniqueParameterNamesThatAreNoReservedKeys) {
  std::set<std::string> names;
  ASSERT_FALSE(effect().parameters().empty());
  EXPECT_LE(effect().parameters().size(), size_t{kMaxEffectParameters});
  EXPECT_LE(effect().shapes().size(), size_t{kMaxEffectShapes});
  for (const EffectParameter& p : effect().parameters()) {
    EXPECT_TRUE(names.insert(p.name).second) << p.name;
    EXPECT_TRUE(!is_effect_key(p.name) || has_offset_parameter(GetParam())) << p.name;
    EXPECT_FALSE(p.unit_revolute.empty() || p.unit_prismatic.empty()) << p.name;
  }
  for (const EffectShape& s : effect().shapes()) {
    EXPECT_TRUE(names.insert(s.name).second) << s.name;
    EXPECT_FALSE(is_effect_key(s.name)) << s.name;
    EXPECT_FALSE(s.unit_revolute.empty() || s.unit_prismatic.empty()) << s.name;
  }
}

TEST_P(EveryAxisEffect, InitialShapeConstantsLieWithinTheirBounds) {
  for (const EffectShape& s : effect().shapes()) {
    EXPECT_LT(s.lower, s.upper) << s.name;
    if (!s.searched) continue;
    EXPECT_TRUE(s.lower < s.initial && s.initial < s.upper) << s.name;
    const bool metres_inside = s.lower < s.initial_prismatic && s.initial_prismatic < s.upper;
    EXPECT_TRUE(s.initial_prismatic == 0.0 || metres_inside) << s.name;
    EXPECT_TRUE(!s.logarithmic || s.lower > 0.0) << s.name;
  }
}

// Units follow from each other: N m is force times metre, and a radian is no unit of its own where
// a torque turns into a force.
TEST_P(EveryAxisEffect, HasEffortsInNewtonMetresOrInNewtons) {
  for (const EffectParameter& p : effect().parameters()) {
    if (p.unit_revolute.rfind("N m", 0) != 0) continue;
    EXPECT_EQ(p.unit_prismatic[0], 'N') << p.name;
    EXPECT_NE(p.unit_prismatic.rfind("N m", 0), 0U) << p.name;
    EXPECT_EQ(p.unit_prismatic.find("rad"), std::string::npos) << p.name;
  }
}

TEST_P(EveryAxisEffect, WritesFiniteNumbersIntoItsOwnColumnsOnly) {
  BoundEffect e = bound(GetParam());
  const auto count = static_cast<size_t>(e.parameter_count());
  for (const AxisSample& x : random_samples(3)) {
    EffectColumns row;
    row.fill(NAN);
    e.columns(x, row);
    for (size_t c = 0; c < row.size(); ++c) EXPECT_EQ(std::isfinite(row[c]), c < count) << c;
  }
}

TEST_P(EveryAxisEffect, ChangesItsStateOnlyIfDeclared) {
  if (effect().traits().memory) GTEST_SKIP() << "has a memory";
  const BoundEffect e = bound(GetParam());
  EffectState state{};
  EffectColumns row{};
  for (const AxisSample& x : random_samples(4)) effect().columns(x, e.shape(), state, row);
  EXPECT_EQ(state, EffectState{});
}

TEST_P(EveryAxisEffect, UsesLoadAndSourceOnlyIfDeclared) {
  BoundEffect plain = bound(GetParam());
  BoundEffect other_load = bound(GetParam());
  BoundEffect other_source = bound(GetParam());
  bool load_matters = false;
  bool source_matters = false;
  for (AxisSample x : random_samples(5)) {
    EffectColumns expected{};
    EffectColumns row{};
    plain.columns(x, expected);
    x.load = 1.0 + 2.0 * x.load;
    other_load.columns(x, row);
    load_matters = load_matters || row != expected;
    x.load = 0.5 * (x.load - 1.0);
    x.from_s += 1.0;
    x.from_ds -= 1.0;
    EffectColumns source_row{};
    other_source.columns(x, source_row);
    for (int c = 0; c < plain.parameter_count(); ++c) {
      source_matters = source_matters ||
                       std::abs(source_row[c] - expected[c]) > 1e-6 * (1 + std::abs(expected[c]));
    }
  }
  EXPECT_EQ(load_matters, effect().traits().uses_load);
  EXPECT_EQ(source_matters, effect().traits().uses_source);
}

TEST_P(EveryAxisEffect, HasACompletePhraseForBothJointTypes) {
  for (const Axis& axis : {yaw_axis(), insertion_axis()}) {
    const BoundEffect e(bare_arm({}), term_of(GetParam(), axis));
    const std::vector<double> values(e.parameter_count(), 0.25);
    const std::string phrase = e.phrase(values);
    EXPECT_GT(phrase.size(), 10U);
    EXPECT_EQ(phrase.find(kSourceUnit), std::string::npos) << phrase;
    EXPECT_EQ(phrase.find("nan "), std::string::npos) << phrase;
    EXPECT_NE(phrase.back(), '.') << phrase;
  }
}

TEST(EffectPhrase, PrintsSizesWithSuitablePrefixes) {
  const auto insertion = [](const std::string& effect, std::map<std::string, double> shape,
                            const std::vector<double>& values) {
    return BoundEffect(bare_arm({}), term_of(effect, insertion_axis(), std::move(shape)))
        .phrase(values);
  };
  EXPECT_EQ(insertion("presliding_hysteresis", {{"distance", 1.4e-4}}, {0.5}),
            "0.50 N of friction with memory: after a reversal it builds up over 0.14 mm");
  EXPECT_EQ(bound("presliding_hysteresis").phrase({0.0731}),
            "73 mN m of friction with memory: after a reversal it builds up over 5.0 mrad");
  EXPECT_EQ(insertion("rotor_inertia", {}, {0.68}), "0.68 kg of reflected rotor inertia");
  EXPECT_EQ(insertion("rotor_inertia", {}, {0.05}), "50 g of reflected rotor inertia");
  EXPECT_EQ(bound("load_dependent_friction").phrase({0.06}),
            "friction of 6.0 % of the torque that it carries");
  EXPECT_EQ(bound("torque_ripple", {{"order", 202}}).phrase({0.03, -0.04}),
            "a ripple of 50 mN m, 202 waves per turn");
  EXPECT_EQ(bound("transmission_compliance").phrase({-0.7e-3}),
            "an elastic transmission: a resonance near 6.0 Hz, measured on the motor");
  EXPECT_EQ(bound("torque_drift").phrase({-0.002}), "a torque that drifts by -0.12 N m per minute");
}

}  // namespace
}  // namespace veridyn
