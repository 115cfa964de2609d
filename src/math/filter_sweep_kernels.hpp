#pragma once

#include "filter_sweep.hpp"
#include "math/pack.hpp"

// Inner loops of the zero-phase filter, compiled once per instruction set under the rules of
// dynamics/arm_kernel_loops.hpp.

namespace veridyn {

template <typename P>
struct FilterLoops {
  typedef double Aligned __attribute__((vector_size(sizeof(P)), may_alias));
  static constexpr int kAcross = kFilterLanes / P::kSize;
  // Number of sections that process one sample at a time, with their states in registers.
  static constexpr int kTogether = P::kSize >= 4 ? 3 : 1;

  static P load(const double* from) {
    return P(typename P::Lanes(*reinterpret_cast<const Aligned*>(from)));
  }
  static void store(const P& from, double* to) { *reinterpret_cast<Aligned*>(to) = from.v; }

  // Runs kN sections over all samples, from `first` on in steps of `step` doubles.
  template <int kN>
  static void sweep(const FilterSection* sections, double* first, long step, long samples) {
    P s1[kN][kAcross];
    P s2[kN][kAcross];
    for (int a = 0; a < kAcross; ++a) {
      const P x = load(first + a * P::kSize);
      for (int n = 0; n < kN; ++n) {
        s1[n][a] = P(sections[n].start1) * x;
        s2[n][a] = P(sections[n].start2) * x;
      }
    }
    double* at = first;
    for (long i = 0; i < samples; ++i, at += step) {
#pragma GCC unroll 4
      for (int a = 0; a < kAcross; ++a) {
        P x = load(at + a * P::kSize);
#pragma GCC unroll 4
        for (int n = 0; n < kN; ++n) {
          const FilterSection& f = sections[n];
          const P y = P(f.b0) * x + s1[n][a];
          const P old = s1[n][a];
          s1[n][a] = (P(f.c1) * x + s2[n][a]) - P(f.a1) * old;
          s2[n][a] = P(f.c2) * x - P(f.a2) * old;
          x = y;
        }
        store(x, at + a * P::kSize);
      }
    }
  }

  // Runs all sections over all samples, as sweep().
  static void all_sections(const FilterSweep& in, double* first, long step, long samples) {
    int n = 0;
    for (; n + kTogether <= in.count; n += kTogether)
      sweep<kTogether>(in.sections + n, first, step, samples);
    for (; n < in.count; ++n) sweep<1>(in.sections + n, first, step, samples);
  }

  static void run(const FilterSweep& in) {
    if (in.lanes == kFilterLanes) run_lanes<kFilterLanes>(in);
    else if (in.lanes == 1) run_lanes<1>(in);
    else run_lanes<0>(in);
  }

  // kLanes is the number of lanes in use, 0 if it is known at run time only.
  template <int kLanes>
  static void run_lanes(const FilterSweep& in) {
    const int lanes = kLanes > 0 ? kLanes : in.lanes;
    const long rows = in.rows, samples = rows + 2 * in.pad;
    double* body = in.work + in.pad * kFilterLanes;
    double* end = body + (rows - 1) * kFilterLanes;
    for (long i = 0; lanes < kFilterLanes && i < samples * kFilterLanes; ++i) in.work[i] = 0.0;
    for (long i = 0; i < rows; ++i)
      for (int l = 0; l < lanes; ++l) body[i * kFilterLanes + l] = in.columns[l][i];
    for (long i = 1; i <= in.pad; ++i) {  // odd reflections
      for (int l = 0; l < lanes; ++l) {
        const double* column = in.columns[l];
        body[l - i * kFilterLanes] = 2.0 * column[0] - column[i];
        end[l + i * kFilterLanes] = 2.0 * column[rows - 1] - column[rows - 1 - i];
      }
    }
    all_sections(in, in.work, kFilterLanes, samples);
    all_sections(in, in.work + (samples - 1) * kFilterLanes, -long{kFilterLanes}, samples);
    for (long i = 0; i < rows; ++i)
      for (int l = 0; l < lanes; ++l) in.columns[l][i] = body[i * kFilterLanes + l];
  }

  static FilterKernels kernels() {
    FilterKernels out;
    out.run = &run;
    return out;
  }
};

}  // namespace veridyn
