#pragma once

#include "triangle_update.hpp"
#include "math/pack.hpp"

// Inner loops of the streaming QR, compiled once per instruction set under the rules of
// dynamics/arm_kernel_loops.hpp: raw pointers, no standard library, templates over a pack.

namespace veridyn {

/// Householder reflections in panels of eight columns. A reflection of column j is
/// I - t [u e_j; x][u e_j; x]', with x in place in the rows (not scaled to a leading one), so that
/// a panel's columns hold its reflections at the end. The panel acts on the columns behind it as
/// I - V T V', T upper triangular (compact WY form, Schreiber and Van Loan 1989).
template <typename P>
struct TriangleLoops {
  typedef double Aligned __attribute__((vector_size(sizeof(P)), may_alias));
  static constexpr int kPanel = kTrianglePanel;
  static constexpr int kAcross = kPanel / P::kSize;  // number of vectors in a panel's row
  static constexpr int kUnroll = 4;                  // rows processed at once; the total is a multiple of it
  static constexpr double kNothing = 1e-200;  // a smaller square has no finite inverse
  // Number of vectors of columns, and of reflections, that are processed at once: as many sums as fit into
  // registers.
  static constexpr int kWide = P::kSize >= 4 ? 3 : 2;
  static constexpr int kDeep = P::kSize >= 8 ? 8 : 4;

  struct Panel {
    double u[kPanel];
    double T[kPanel][kPanel];  // upper triangular
  };

  static P load(const double* from) {
    return P(typename P::Lanes(*reinterpret_cast<const Aligned*>(from)));
  }
  static void store(const P& from, double* to) { *reinterpret_cast<Aligned*>(to) = from.v; }

  // Computes d = sum over the rows of row[0] * row.
  static void first_products(const double* A, long stride, int rows, double* d) {
    P sum[kUnroll][kAcross];
    for (int k = 0; k < kUnroll; ++k)
      for (int a = 0; a < kAcross; ++a) sum[k][a] = P(0.0);
    for (int r = 0; r < rows; r += kUnroll) {
#pragma GCC unroll 4
      for (int k = 0; k < kUnroll; ++k) {
        const double* row = A + (r + k) * stride;
        const P mine(row[0]);
#pragma GCC unroll 4
        for (int a = 0; a < kAcross; ++a) sum[k][a] += mine * load(row + a * P::kSize);
      }
    }
    add_up(sum, d);
  }

  // Computes row -= row[j] * w, and d = sum of row[j + 1] * row over the new rows. The new row[j + 1] is read
  // from memory and not computed twice: if a column cancels except for rounding, the reflection consists of
  // that rounding, and a compiler that fuses only one of the two computations would make it no reflection.
  static void reflect_within(double* A, long stride, int rows, int j, const double* w, double* d) {
    P change[kAcross];
    for (int a = 0; a < kAcross; ++a) change[a] = load(w + a * P::kSize);
    P sum[kUnroll][kAcross];
    for (int k = 0; k < kUnroll; ++k)
      for (int a = 0; a < kAcross; ++a) sum[k][a] = P(0.0);
    for (int r = 0; r < rows; r += kUnroll) {
#pragma GCC unroll 4
      for (int k = 0; k < kUnroll; ++k) {
        double* row = A + (r + k) * stride;
        const P mine(row[j]);
        P now[kAcross];
#pragma GCC unroll 4
        for (int a = 0; a < kAcross; ++a) {
          now[a] = load(row + a * P::kSize) - mine * change[a];
          store(now[a], row + a * P::kSize);
        }
        const P next(row[j + 1]);
#pragma GCC unroll 4
        for (int a = 0; a < kAcross; ++a) sum[k][a] += next * now[a];
      }
    }
    add_up(sum, d);
  }

  static void add_up(P (&sum)[kUnroll][kAcross], double* d) {
    for (int a = 0; a < kAcross; ++a)
      store((sum[0][a] + sum[1][a]) + (sum[2][a] + sum[3][a]), d + a * P::kSize);
  }

  // Triangulates the eight columns that begin at A and at the triangle's diagonal.
  static void factor_panel(double* R, double* A, long stride, int rows, Panel& panel) {
    alignas(64) double d[kPanel];
    alignas(64) double w[kPanel];
    first_products(A, stride, rows, d);
    for (int j = 0; j < kPanel; ++j) {
      double* top = R + j * stride;
      const double below = d[j];
      double u = 0.0;
      double t = 0.0;
      if (!(below < kNothing)) {  // true for NaN as well, which must propagate
        const double norm = __builtin_sqrt(top[j] * top[j] + below);
        const double beta = top[j] > 0.0 ? -norm : norm;
        u = top[j] - beta;
        t = -1.0 / (beta * u);
        top[j] = beta;
      }
      panel.u[j] = u;
      // Computes column j of T from the products of x_j with the reflections before it.
      for (int i = 0; i < j; ++i) {
        double sum = 0.0;
        for (int k = i; k < j; ++k) sum += panel.T[i][k] * d[k];
        panel.T[i][j] = -t * sum;
      }
      panel.T[j][j] = t;
      for (int i = 0; i <= j; ++i) w[i] = 0.0;
      for (int i = j + 1; i < kPanel; ++i) {
        w[i] = t * (u * top[i] + d[i]);
        top[i] -= u * w[i];
      }
      if (j + 1 < kPanel) reflect_within(A, stride, rows, j, w, d);
    }
  }

  // Computes W[j] = sum over the rows of V[j] * columns, kDeep reflections at once.
  template <int kC>
  static void products(const double* V, const double* A, long stride, int rows,
                       P (&W)[kPanel][kC]) {
#pragma GCC unroll 2
    for (int from = 0; from < kPanel; from += kDeep) {
      P sum[kDeep][kC];
      for (int j = 0; j < kDeep; ++j)
        for (int c = 0; c < kC; ++c) sum[j][c] = P(0.0);
      for (int r = 0; r < rows; ++r) {
        const double* v = V + r * stride + from;
        const double* a = A + r * stride;
        P row[kC];
#pragma GCC unroll 4
        for (int c = 0; c < kC; ++c) row[c] = load(a + c * P::kSize);
#pragma GCC unroll 8
        for (int j = 0; j < kDeep; ++j) {
          const P factor(v[j]);
#pragma GCC unroll 4
          for (int c = 0; c < kC; ++c) sum[j][c] += factor * row[c];
        }
      }
      for (int j = 0; j < kDeep; ++j)
        for (int c = 0; c < kC; ++c) W[from + j][c] = sum[j][c];
    }
  }

  // Computes columns -= sum_j V[j] * W[j].
  template <int kC>
  static void subtract(const double* V, double* A, long stride, int rows,
                       const P (&W)[kPanel][kC]) {
#pragma GCC unroll 2
    for (int from = 0; from < kPanel; from += kDeep) {
      P w[kDeep][kC];
      for (int j = 0; j < kDeep; ++j)
        for (int c = 0; c < kC; ++c) w[j][c] = W[from + j][c];
      for (int r = 0; r < rows; ++r) {
        const double* v = V + r * stride + from;
        double* a = A + r * stride;
        P row[kC];
#pragma GCC unroll 4
        for (int c = 0; c < kC; ++c) row[c] = load(a + c * P::kSize);
#pragma GCC unroll 8
        for (int j = 0; j < kDeep; ++j) {
          const P factor(v[j]);
#pragma GCC unroll 4
          for (int c = 0; c < kC; ++c) row[c] -= factor * w[j][c];
        }
#pragma GCC unroll 4
        for (int c = 0; c < kC; ++c) store(row[c], a + c * P::kSize);
      }
    }
  }

  // Applies a panel's reflections to kC vectors of columns.
  template <int kC>
  static void apply(const Panel& panel, double* R, const double* V, double* A, long stride,
                    int rows) {
    P W[kPanel][kC];
    products<kC>(V, A, stride, rows, W);
    for (int j = 0; j < kPanel; ++j)
      for (int c = 0; c < kC; ++c)
        W[j][c] += P(panel.u[j]) * load(R + j * stride + c * P::kSize);
    for (int j = kPanel - 1; j >= 0; --j) {  // W = T' W, in place from the last row up
      for (int c = 0; c < kC; ++c) {
        P sum = P(panel.T[j][j]) * W[j][c];
        for (int i = 0; i < j; ++i) sum += P(panel.T[i][j]) * W[i][c];
        W[j][c] = sum;
        double* top = R + j * stride + c * P::kSize;
        store(load(top) - P(panel.u[j]) * sum, top);
      }
    }
    subtract<kC>(V, A, stride, rows, W);
  }

  static void update(const TriangleUpdate& in) {
    const long stride = in.stride;
    Panel panel;
    for (int at = 0; at < in.columns; at += kPanel) {
      const int rows = in.begun[at / kPanel];
      if (rows == 0) continue;
      double* R = in.R + at * stride + at;
      double* A = in.A + at;
      factor_panel(R, A, stride, rows, panel);
      const int vectors = (in.columns - at - kPanel) / P::kSize;
      int c = 0;
      for (; c + kWide <= vectors; c += kWide) {
        const long to = kPanel + c * P::kSize;
        apply<kWide>(panel, R + to, A, A + to, stride, rows);
      }
      for (; c < vectors; ++c) {
        const long to = kPanel + c * P::kSize;
        apply<1>(panel, R + to, A, A + to, stride, rows);
      }
    }
  }

  static TriangleKernels kernels() {
    TriangleKernels out;
    out.update = &update;
    return out;
  }
};

}  // namespace veridyn
