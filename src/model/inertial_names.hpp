#pragma once

namespace veridyn {

/// Symbol of a parameter in the order of InertialParameters: "m", "hx" .. "hz", "Lxx", "Lxy", "Lyy", "Lxz",
/// "Lyz", "Lzz".
constexpr const char* inertial_symbol(int component) {
  constexpr const char* kSymbols[] = {"m",   "hx",  "hy",  "hz",  "Lxx",
                                      "Lxy", "Lyy", "Lxz", "Lyz", "Lzz"};
  return kSymbols[component];
}

constexpr const char* inertial_unit(int component) {
  return component == 0 ? "kg" : component < 4 ? "kg m" : "kg m^2";
}

}  // namespace veridyn
