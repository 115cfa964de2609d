#pragma once

#include <cmath>

namespace veridyn {

/// Several samples side by side, processed by one instruction. The tag separates the code of one
/// instruction set from that of another within one program.
///
/// Compilers map the vector to the machine's registers: two, four or eight lanes per instruction.
template <int kLanes, typename Isa>
struct Pack {
  typedef double Lanes __attribute__((vector_size(kLanes * sizeof(double))));
  typedef long long Mask __attribute__((vector_size(kLanes * sizeof(long long))));
  typedef double Unaligned
      __attribute__((vector_size(kLanes * sizeof(double)), aligned(8), may_alias));
  static constexpr int kSize = kLanes;

  Lanes v;

  Pack() = default;
  Pack(double x)
      : v(x - Lanes{}) {
  }  // NOLINT: a constant is a pack of equals; x - 0 costs nothing, 0 + x an addition
  Pack(const Pack<1, Isa>& x) : Pack(x.v) {}  // NOLINT: the same number in every lane
  explicit Pack(const Lanes& lanes) : v(lanes) {}

  Pack& operator+=(const Pack& b) {
    v += b.v;
    return *this;
  }
  Pack& operator-=(const Pack& b) {
    v -= b.v;
    return *this;
  }
  friend Pack operator+(const Pack& a, const Pack& b) { return Pack(a.v + b.v); }
  friend Pack operator-(const Pack& a, const Pack& b) { return Pack(a.v - b.v); }
  friend Pack operator*(const Pack& a, const Pack& b) { return Pack(a.v * b.v); }
  friend Pack operator/(const Pack& a, const Pack& b) { return Pack(a.v / b.v); }
  friend Pack operator-(const Pack& a) { return Pack(-a.v); }
};

/// One sample with the tag of an instruction set: a number whose functions belong to that set
/// alone, and which combines with all lanes of a wider pack.
template <typename Isa>
struct Pack<1, Isa> {
  static constexpr int kSize = 1;

  double v;

  Pack() = default;
  Pack(double x) : v(x) {}  // NOLINT: a constant

  Pack& operator+=(const Pack& b) {
    v += b.v;
    return *this;
  }
  Pack& operator-=(const Pack& b) {
    v -= b.v;
    return *this;
  }
  friend Pack operator+(const Pack& a, const Pack& b) { return a.v + b.v; }
  friend Pack operator-(const Pack& a, const Pack& b) { return a.v - b.v; }
  friend Pack operator*(const Pack& a, const Pack& b) { return a.v * b.v; }
  friend Pack operator/(const Pack& a, const Pack& b) { return a.v / b.v; }
  friend Pack operator-(const Pack& a) { return -a.v; }
};

template <typename Isa>
inline bool is_positive(const Pack<1, Isa>& x) {
  return x.v > 0.0;
}

/// Loads from memory that is aligned for doubles only.
template <typename P>
inline void load_lanes(const double* from, P& to) {
  to.v = *reinterpret_cast<const typename P::Unaligned*>(from);
}

/// Stores the first `count` lanes to such memory.
template <typename P>
inline void store_lanes(const P& from, int count, double* to) {
  if (count == P::kSize) {
    *reinterpret_cast<typename P::Unaligned*>(to) = from.v;
  } else {
    for (int l = 0; l < count; ++l) to[l] = from.v[l];
  }
}

/// Loads the first `count` lanes; the others repeat the last of these.
template <typename P>
inline P load_lanes(int count, const double* from) {
  P out(0.0);
  if (count == P::kSize) {
    load_lanes(from, out);
    return out;
  }
  for (int l = 0; l < P::kSize; ++l) out.v[l] = from[l < count ? l : count - 1];
  return out;
}

/// Sine and cosine of all lanes, to 2 units in the last place for |x| < 1e5 (Cody-Waite reduction
/// in three parts, then the Taylor-like minimax polynomials of the Cephes library's published
/// coefficients).
template <int kLanes, typename Isa>
inline void sine_cosine(const Pack<kLanes, Isa>& x, Pack<kLanes, Isa>& sine,
                        Pack<kLanes, Isa>& cosine) {
  using P = Pack<kLanes, Isa>;
  using Lanes = typename P::Lanes;
  using Mask = typename P::Mask;
  // Adding and removing 1.5 * 2^52 rounds to the nearest integer; the low bits then hold the
  // quadrant.
  const Lanes magic = Lanes{} + 6755399441055744.0;
  const Lanes shifted = x.v * (2.0 / M_PI) + magic;
  const Lanes k = shifted - magic;
  const Mask quadrant = reinterpret_cast<Mask>(shifted);  // the bits of `shifted` as integers
  // The first two products and the first difference are exact; the rounding error of the second is
  // added to the third.
  const Lanes first = x.v - k * 1.57079632673412561417e+00;
  const Lanes second = k * 6.07710050630396597660e-11;
  const Lanes head = first - second;
  const Lanes r = head - (k * 2.02226624879595063154e-21 - ((first - head) - second));
  const Lanes z = r * r;
  Lanes s = z * 1.58962301576546568060e-10 - 2.50507477628578072866e-8;
  s = s * z + 2.75573136213857245213e-6;
  s = s * z - 1.98412698295895385996e-4;
  s = s * z + 8.33333333332211858878e-3;
  s = s * z - 1.66666666666666307295e-1;
  s = r + r * z * s;
  Lanes c = z * -1.13585365213876817300e-11 + 2.08757008419747316778e-9;
  c = c * z - 2.75573141792967388112e-7;
  c = c * z + 2.48015872888517045348e-5;
  c = c * z - 1.38888888888730564116e-3;
  c = c * z + 4.16666666666665929218e-2;
  c = 1.0 - 0.5 * z + z * z * c;
  const Mask odd = (quadrant & 1) != 0;
  const Mask sine_negative = (quadrant & 2) != 0;
  const Mask cosine_negative = ((quadrant + 1) & 2) != 0;
  const Lanes s_swapped = odd ? c : s;
  const Lanes c_swapped = odd ? s : c;
  sine = P(sine_negative ? -s_swapped : s_swapped);
  cosine = P(cosine_negative ? -c_swapped : c_swapped);
}

}  // namespace veridyn
