#pragma once

#include "state_links.hpp"
#include "math/pack.hpp"

// Dynamics of single states, once per instruction set; the rules of regressor_batch_kernels.hpp
// hold here too. Scalars along the tree, packs across coordinates: one lane is one column of a
// Jacobian, of the mass matrix, or one direction of a derivative.
//
// Source of the forms: Featherstone, Rigid Body Dynamics Algorithms, 2008, ch. 5 and 6; regressor:
// Atkeson, An and Hollerbach, IJRR 5(3), 1986; derivatives: the tangents of the Newton-Euler
// recursion.

namespace veridyn {

template <typename P>
struct StateLoops {
  static constexpr int kLanes = P::kSize;
  static constexpr double kQuickAngle = 1e5;  // [rad] of sine_cosine()
  typedef double Aligned __attribute__((vector_size(sizeof(P)), may_alias));
  typedef double Unaligned __attribute__((vector_size(sizeof(P)), aligned(8), may_alias));

  template <typename S>
  struct V {
    S x, y, z;
  };
  using D3 = V<double>;
  using P3 = V<P>;

  // Row by row.
  struct M3 {
    double m[9];
  };

  template <typename A, typename B>
  static auto plus(const V<A>& a, const V<B>& b) {
    return V<decltype(a.x + b.x)>{a.x + b.x, a.y + b.y, a.z + b.z};
  }
  template <typename A, typename B>
  static auto times(const A& k, const V<B>& a) {
    return V<decltype(k * a.x)>{k * a.x, k * a.y, k * a.z};
  }
  template <typename A, typename B>
  static auto cross(const V<A>& a, const V<B>& b) {
    return V<decltype(a.x * b.x)>{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z,
                                  a.x * b.y - a.y * b.x};
  }
  template <typename A, typename B>
  static auto dot(const V<A>& a, const V<B>& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
  }
  template <typename S>
  static V<S> apply(const M3& R, const V<S>& a) {
    return {R.m[0] * a.x + R.m[1] * a.y + R.m[2] * a.z, R.m[3] * a.x + R.m[4] * a.y + R.m[5] * a.z,
            R.m[6] * a.x + R.m[7] * a.y + R.m[8] * a.z};
  }
  template <typename S>
  static V<S> apply_transposed(const M3& R, const V<S>& a) {
    return {R.m[0] * a.x + R.m[3] * a.y + R.m[6] * a.z, R.m[1] * a.x + R.m[4] * a.y + R.m[7] * a.z,
            R.m[2] * a.x + R.m[5] * a.y + R.m[8] * a.z};
  }
  // L a of the six entries in the order of InertialParameters.
  template <typename S>
  static V<S> inertia(const double* L, const V<S>& a) {
    return {L[0] * a.x + L[1] * a.y + L[3] * a.z, L[1] * a.x + L[2] * a.y + L[4] * a.z,
            L[3] * a.x + L[4] * a.y + L[5] * a.z};
  }
  static D3 load3(const double* from) { return {from[0], from[1], from[2]}; }
  template <typename S>
  static V<S> zero3() {
    return {S(0.0), S(0.0), S(0.0)};
  }

  // E = [alpha]x + [omega]x [omega]x, by columns.
  template <typename S>
  struct Spin {
    V<S> x, y, z;
  };
  template <typename S>
  static Spin<S> spin(const V<S>& w, const V<S>& alpha) {
    const S xx = w.x * w.x;
    const S yy = w.y * w.y;
    const S zz = w.z * w.z;
    const S yz = w.y * w.z;
    const S xz = w.x * w.z;
    const S xy = w.x * w.y;
    return {{-(yy + zz), xy + alpha.z, xz - alpha.y},
            {xy - alpha.z, -(xx + zz), yz + alpha.x},
            {xz + alpha.y, yz - alpha.x, -(xx + yy)}};
  }
  // Its tangent.
  static Spin<P> spin_tangent(const D3& w, const P3& dw, const P3& dalpha) {
    const P xx = 2.0 * w.x * dw.x;
    const P yy = 2.0 * w.y * dw.y;
    const P zz = 2.0 * w.z * dw.z;
    const P yz = w.y * dw.z + w.z * dw.y;
    const P xz = w.x * dw.z + w.z * dw.x;
    const P xy = w.x * dw.y + w.y * dw.x;
    return {{-(yy + zz), xy + dalpha.z, xz - dalpha.y},
            {xy - dalpha.z, -(xx + zz), yz + dalpha.x},
            {xz + dalpha.y, yz - dalpha.x, -(xx + yy)}};
  }
  template <typename S>
  static V<S> apply(const Spin<S>& E, const D3& a) {
    return {E.x.x * a.x + E.y.x * a.y + E.z.x * a.z, E.x.y * a.x + E.y.y * a.y + E.z.y * a.z,
            E.x.z * a.x + E.y.z * a.y + E.z.z * a.z};
  }

  /// What is known of a link's motion.
  struct State {
    M3 R;
    double s, ds, dds;
    D3 b;  // with what a sliding joint adds
    D3 w;  // R' omega of the parent
    D3 before_alpha, before_accel;  // R' of what the parent hands on
    D3 omega, alpha, accel;
    Spin<double> E;
    D3 force, moment;
  };
  // One composite body: mass, first moment, inertia about the link's origin.
  struct Composite {
    double m;
    D3 h;
    double L[6];
  };
  struct Column {
    P3 a, b;
  };
  struct Tangent {
    P3 omega, alpha, accel, force, moment;
    Spin<P> E;
    P ds;  // of the joint variable itself
  };

  struct Memory {
    State* state;
    Composite* body;
    Column* column;
    Tangent* tangent;
    double* angle;  // three arrays of a whole number of packs
    double* joint;  // (links x links)
  };

  static unsigned long padded(unsigned long doubles) { return (doubles + 7) / 8 * 8; }
  static unsigned long lanes_for(int count) {
    return static_cast<unsigned long>((count + kLanes - 1) / kLanes * kLanes);
  }
  template <typename T>
  static unsigned long room(int count) {
    return padded(static_cast<unsigned long>(count) * sizeof(T) / sizeof(double) + 1);
  }
  static unsigned long workspace(const StateTree& tree) {
    return room<State>(tree.links) + room<Composite>(tree.links) + room<Column>(tree.links) +
           room<Tangent>(tree.links) + padded(3 * lanes_for(tree.links)) +
           padded((static_cast<unsigned long>(tree.links) + 1) * (lanes_for(tree.links) + 8));
  }
  static Memory divide(const StateTree& tree, double* memory) {
    Memory at;
    at.column = reinterpret_cast<Column*>(memory);
    memory += room<Column>(tree.links);
    at.tangent = reinterpret_cast<Tangent*>(memory);
    memory += room<Tangent>(tree.links);
    at.angle = memory;
    memory += padded(3 * lanes_for(tree.links));
    at.state = reinterpret_cast<State*>(memory);
    memory += room<State>(tree.links);
    at.body = reinterpret_cast<Composite*>(memory);
    memory += room<Composite>(tree.links);
    at.joint = memory;
    return at;
  }

  // Joint variables, and all sines and cosines in packs.
  static void angles(const StateTree& tree, const double* q, const Memory& at) {
    const auto lanes = lanes_for(tree.links);
    double* sine = at.angle + lanes;
    double* cosine = sine + lanes;
    for (int k = 0; k < tree.links; ++k) {
      const StateLink& link = tree.link[k];
      double s = link.offset;
      for (int e = link.first_share; e < link.end_share; ++e)
        s += tree.share[e].coefficient * q[tree.share[e].coordinate];
      at.angle[k] = s;
    }
    for (unsigned long k = static_cast<unsigned long>(tree.links); k < lanes; ++k)
      at.angle[k] = 0.0;
    for (unsigned long k = 0; k < lanes; k += kLanes) {
      P x;
      P s;
      P c;
      x.v = *reinterpret_cast<const Aligned*>(at.angle + k);
      sine_cosine(x, s, c);
      *reinterpret_cast<Aligned*>(sine + k) = s.v;
      *reinterpret_cast<Aligned*>(cosine + k) = c.v;
    }
    for (int k = 0; k < tree.links; ++k) {  // beyond its range the quick one loses digits
      if (__builtin_fabs(at.angle[k]) < kQuickAngle) continue;
      sine[k] = __builtin_sin(at.angle[k]);
      cosine[k] = __builtin_cos(at.angle[k]);
    }
  }

  static void rotations(const StateTree& tree, const double* q, const Memory& at) {
    angles(tree, q, at);
    const double* sine = at.angle + lanes_for(tree.links);
    const double* cosine = sine + lanes_for(tree.links);
    for (int k = 0; k < tree.links; ++k) {
      const StateLink& link = tree.link[k];
      State& state = at.state[k];
      state.s = at.angle[k];
      state.b = load3(link.b);
      if (link.motion == StateMotion::kTurns) {
        for (int e = 0; e < 9; ++e)
          state.R.m[e] = link.still[e] + link.cosine[e] * cosine[k] + link.sine[e] * sine[k];
      } else {
        for (int e = 0; e < 9; ++e) state.R.m[e] = link.still[e];
        if (link.motion == StateMotion::kSlides)
          state.b = plus(state.b, times(state.s, load3(link.z)));
      }
    }
  }

  static double rate_of(const StateTree& tree, const StateLink& link, const double* rate) {
    if (rate == nullptr) return 0.0;
    double sum = 0.0;
    for (int e = link.first_share; e < link.end_share; ++e)
      sum += tree.share[e].coefficient * rate[tree.share[e].coordinate];
    return sum;
  }

  static void velocities(const StateTree& tree, const double* dq, const double* ddq,
                         const double* gravity, const Memory& at) {
    const D3 up = {-gravity[0], -gravity[1], -gravity[2]};
    for (int k = 0; k < tree.links; ++k) {
      const StateLink& link = tree.link[k];
      State& state = at.state[k];
      state.ds = rate_of(tree, link, dq);
      state.dds = rate_of(tree, link, ddq);
      D3 middle = up;
      state.w = zero3<double>();
      state.before_alpha = zero3<double>();
      if (link.parent >= 0) {
        const State& above = at.state[link.parent];
        state.w = apply_transposed(state.R, above.omega);
        state.before_alpha = apply_transposed(state.R, above.alpha);
        middle = above.accel;
        if (link.has_a) middle = plus(middle, apply(above.E, load3(link.a)));
      }
      state.before_accel = apply_transposed(state.R, middle);
      state.omega = state.w;
      state.alpha = state.before_alpha;
      state.accel = state.before_accel;
      const D3 z = load3(link.z);
      if (link.motion == StateMotion::kTurns) {
        state.omega = plus(state.w, times(state.ds, z));
        state.alpha = plus(state.alpha, plus(times(state.ds, cross(state.w, z)),
                                             times(state.dds, z)));
      } else if (link.motion == StateMotion::kSlides) {
        state.accel = plus(state.accel, plus(times(2.0 * state.ds, cross(state.w, z)),
                                             times(state.dds, z)));
      }
      state.E = spin(state.omega, state.alpha);
      if (link.has_b) state.accel = plus(state.accel, apply(state.E, state.b));
    }
  }

  static void body_forces(const StateTree& tree, const Memory& at) {
    for (int k = 0; k < tree.links; ++k) {
      State& state = at.state[k];
      const int body = tree.link[k].body;
      state.force = zero3<double>();
      state.moment = zero3<double>();
      if (body < 0) continue;
      const double* p = tree.phi + 10 * body;
      const D3 h = load3(p + 1);
      state.force = plus(times(p[0], state.accel), apply(state.E, h));
      state.moment =
          plus(plus(inertia(p + 4, state.alpha), cross(state.omega, inertia(p + 4, state.omega))),
               cross(h, state.accel));
    }
  }

  // Forces to the parents; the joints' efforts to the coordinates.
  static void back(const StateTree& tree, const Memory& at, double* tau) {
    for (int i = 0; i < tree.coordinates; ++i) tau[i] = 0.0;
    for (int k = tree.links - 1; k >= 0; --k) {
      const StateLink& link = tree.link[k];
      State& state = at.state[k];
      if (link.has_b) state.moment = plus(state.moment, cross(state.b, state.force));
      const D3 z = load3(link.z);
      const double effort =
          link.motion == StateMotion::kTurns ? dot(z, state.moment) : dot(z, state.force);
      for (int e = link.first_share; e < link.end_share; ++e)
        tau[tree.share[e].coordinate] += tree.share[e].coefficient * effort;
      if (link.parent < 0) continue;
      State& above = at.state[link.parent];
      const D3 force = apply(state.R, state.force);
      above.force = plus(above.force, force);
      above.moment = plus(above.moment, apply(state.R, state.moment));
      if (link.has_a) above.moment = plus(above.moment, cross(load3(link.a), force));
    }
  }

  // Mass, first moment and inertia of everything that a link carries, about its own origin.
  static void composites(const StateTree& tree, const Memory& at) {
    for (int k = 0; k < tree.links; ++k) {
      Composite& c = at.body[k];
      const int body = tree.link[k].body;
      if (body < 0) {
        c = {0.0, zero3<double>(), {0.0, 0.0, 0.0, 0.0, 0.0, 0.0}};
        continue;
      }
      const double* p = tree.phi + 10 * body;
      c = {p[0], load3(p + 1), {p[4], p[5], p[6], p[7], p[8], p[9]}};
    }
    for (int k = tree.links - 1; k >= 0; --k) {
      const StateLink& link = tree.link[k];
      if (link.parent < 0) continue;
      Composite c = at.body[k];
      if (link.has_b) shift(at.state[k].b, c);
      turn(at.state[k].R, c);
      if (link.has_a) shift(load3(link.a), c);
      Composite& above = at.body[link.parent];
      above.m += c.m;
      above.h = plus(above.h, c.h);
      for (int e = 0; e < 6; ++e) above.L[e] += c.L[e];
    }
  }

  // About a point from which the old origin lies at p.
  static void shift(const D3& p, Composite& c) {
    // L' = L + 2 (h.p) 1 - h p' - p h' + m ((p.p) 1 - p p') = L + (s.p) 1 - sym, s = 2 h + m p
    const D3 s = plus(times(2.0, c.h), times(c.m, p));
    const double all = dot(s, p);
    c.L[0] += all - s.x * p.x;
    c.L[2] += all - s.y * p.y;
    c.L[5] += all - s.z * p.z;
    c.L[1] -= 0.5 * (s.x * p.y + s.y * p.x);
    c.L[3] -= 0.5 * (s.x * p.z + s.z * p.x);
    c.L[4] -= 0.5 * (s.y * p.z + s.z * p.y);
    c.h = plus(c.h, times(c.m, p));
  }

  // R L R'.
  static void turn(const M3& R, Composite& c) {
    const double* L = c.L;
    const double* m = R.m;
    D3 rows[3];
    for (int r = 0; r < 3; ++r) {
      const D3 row = {m[3 * r], m[3 * r + 1], m[3 * r + 2]};
      rows[r] = {row.x * L[0] + row.y * L[1] + row.z * L[3],
                 row.x * L[1] + row.y * L[2] + row.z * L[4],
                 row.x * L[3] + row.y * L[4] + row.z * L[5]};
    }
    const D3 x = {m[0], m[1], m[2]};
    const D3 y = {m[3], m[4], m[5]};
    const D3 z = {m[6], m[7], m[8]};
    const double turned[6] = {dot(rows[0], x), dot(rows[0], y), dot(rows[1], y),
                              dot(rows[0], z), dot(rows[1], z), dot(rows[2], z)};
    for (int e = 0; e < 6; ++e) c.L[e] = turned[e];
    c.h = apply(R, c.h);
  }

  // Efforts of all joints above for a unit acceleration of each: lane j is link j's.
  static void joint_space(const StateTree& tree, const Memory& at, int group) {
    Column* F = at.column;  // force a, moment b
    for (int k = 0; k < tree.links; ++k) F[k] = {zero3<P>(), zero3<P>()};
    const long stride = static_cast<long>(lanes_for(tree.links));
    for (int k = tree.links - 1; k >= 0; --k) {
      const StateLink& link = tree.link[k];
      const D3 z = load3(link.z);
      const D3 b = at.state[k].b;
      const int lane = k - group * kLanes;
      if (lane >= 0 && lane < kLanes && link.motion != StateMotion::kNone) {
        const Composite& c = at.body[k];
        const bool turns = link.motion == StateMotion::kTurns;
        const D3 v = turns ? cross(z, b) : z;
        D3 force = times(c.m, v);
        D3 moment = cross(c.h, v);
        if (turns) {
          force = plus(force, cross(z, c.h));
          moment = plus(moment, inertia(c.L, z));
        }
        F[k].a.x.v[lane] = force.x;
        F[k].a.y.v[lane] = force.y;
        F[k].a.z.v[lane] = force.z;
        F[k].b.x.v[lane] = moment.x;
        F[k].b.y.v[lane] = moment.y;
        F[k].b.z.v[lane] = moment.z;
      }
      P3 moment = F[k].b;
      if (link.has_b) moment = plus(moment, cross(b, F[k].a));
      const P effort =
          link.motion == StateMotion::kTurns ? dot(z, moment) : dot(z, F[k].a);
      *reinterpret_cast<Unaligned*>(at.joint + k * stride + group * kLanes) = effort.v;
      if (link.parent < 0) continue;
      Column& above = F[link.parent];
      const P3 force = apply(at.state[k].R, F[k].a);
      above.a = plus(above.a, force);
      above.b = plus(above.b, apply(at.state[k].R, moment));
      if (link.has_a) above.b = plus(above.b, cross(load3(link.a), force));
    }
  }

  // M from the joints' own, which is filled for rows above or at their columns.
  static void mass_of(const StateTree& tree, const Memory& at, double* M) {
    composites(tree, at);
    const int n = tree.coordinates;
    for (int group = 0; group * kLanes < tree.links; ++group) joint_space(tree, at, group);
    const long stride = static_cast<long>(lanes_for(tree.links));
    for (int e = 0; e < n * n; ++e) M[e] = 0.0;
    for (int j = 0; j < tree.links; ++j) {
      const StateLink& of_j = tree.link[j];
      for (int k = j; k >= 0; k = tree.link[k].parent) {  // rows above the column
        const StateLink& of_k = tree.link[k];
        const double value = at.joint[k * stride + j];
        for (int e = of_j.first_share; e < of_j.end_share; ++e) {
          for (int f = of_k.first_share; f < of_k.end_share; ++f) {
            const double entry =
                tree.share[e].coefficient * tree.share[f].coefficient * value;
            M[tree.share[e].coordinate * n + tree.share[f].coordinate] += entry;
            if (k != j) M[tree.share[f].coordinate * n + tree.share[e].coordinate] += entry;
          }
        }
      }
    }
  }

  // ---- inverse dynamics alone: three coordinates of a vector are lanes of one register ----------

  typedef double Quad __attribute__((vector_size(32)));
  typedef double LooseQuad __attribute__((vector_size(32), aligned(8), may_alias));

  struct Fast {
    Quad columns[3];  // of R_parent_link
    Quad b, omega, alpha, accel, force, moment;
  };

  static Quad quad(const double* from) { return *reinterpret_cast<const LooseQuad*>(from); }
  template <int kLane>
  static Quad spread(const Quad& a) {
    return __builtin_shufflevector(a, a, kLane, kLane, kLane, kLane);
  }
  static Quad turned(const Quad& a) { return __builtin_shufflevector(a, a, 1, 2, 0, 3); }
  static Quad cross(const Quad& a, const Quad& b) { return turned(a * turned(b) - turned(a) * b); }
  // x[0] a[0] + x[1] a[1] + x[2] a[2]
  static Quad combined(const Quad* a, const Quad& x) {
    return a[0] * spread<0>(x) + a[1] * spread<1>(x) + a[2] * spread<2>(x);
  }
  static double dot(const Quad& a, const Quad& b) {
    const Quad c = a * b;
    return c[0] + c[1] + c[2];
  }

  // Motion of one link and the force that its body needs.
  static void fast_forward(const StateTree& tree, int k, double c, double s, double ds, double dds,
                           Fast* fast) {
    const StateLink& link = tree.link[k];
    const double* at = tree.quads + 4L * kLinkQuads * k;
    Fast& f = fast[k];
    Quad rows[3];
    const bool turns = link.motion == StateMotion::kTurns;
#pragma GCC unroll 3
    for (int r = 0; r < 3; ++r) {
      rows[r] = quad(at + 4 * r);
      f.columns[r] = quad(at + 4 * (9 + r));
      if (!turns) continue;
      rows[r] += c * quad(at + 4 * (3 + r)) + s * quad(at + 4 * (6 + r));
      f.columns[r] += c * quad(at + 4 * (12 + r)) + s * quad(at + 4 * (15 + r));
    }
    const Quad a = quad(at + 4 * 18);
    const Quad z = quad(at + 4 * 20);
    f.b = quad(at + 4 * 19);
    Quad omega{};
    Quad alpha{};
    Quad accel = {-tree.gravity[0], -tree.gravity[1], -tree.gravity[2], 0.0};
    if (link.parent >= 0) {
      const Fast& above = fast[link.parent];
      omega = combined(rows, above.omega);
      alpha = combined(rows, above.alpha);
      accel = above.accel;
      if (link.has_a) accel += cross(above.alpha, a) + cross(above.omega, cross(above.omega, a));
    }
    accel = combined(rows, accel);
    if (turns) {
      alpha += ds * cross(omega, z) + dds * z;
      omega += ds * z;
    } else if (link.motion == StateMotion::kSlides) {
      accel += (2.0 * ds) * cross(omega, z) + dds * z;
      f.b += s * z;
    }
    if (link.has_b) accel += cross(alpha, f.b) + cross(omega, cross(omega, f.b));
    f.omega = omega;
    f.alpha = alpha;
    f.accel = accel;
    f.force = Quad{};
    f.moment = Quad{};
    if (link.body < 0) return;
    const double* body = tree.quads + 4L * (kLinkQuads * tree.links + kBodyQuads * link.body);
    const Quad h = quad(body);
    const Quad L[3] = {quad(body + 4), quad(body + 8), quad(body + 12)};
    f.force = body[16] * accel + cross(alpha, h) + cross(omega, cross(omega, h));
    f.moment = combined(L, alpha) + cross(omega, combined(L, omega)) + cross(h, accel);
  }

  __attribute__((flatten)) static void inverse_dynamics(const StateTree& tree, const double* q,
                                                        const double* dq, const double* ddq,
                                                        double* tau, double* workspace) {
    const Memory at = divide(tree, workspace);
    angles(tree, q, at);
    const double* sine = at.angle + lanes_for(tree.links);
    const double* cosine = sine + lanes_for(tree.links);
    Fast* fast = reinterpret_cast<Fast*>(at.tangent);  // which is wider, and not in use
    for (int k = 0; k < tree.links; ++k) {
      const StateLink& link = tree.link[k];
      const bool slides = link.motion == StateMotion::kSlides;
      fast_forward(tree, k, cosine[k], slides ? at.angle[k] : sine[k], rate_of(tree, link, dq),
                   rate_of(tree, link, ddq), fast);
    }
    for (int i = 0; i < tree.coordinates; ++i) tau[i] = 0.0;
    for (int k = tree.links - 1; k >= 0; --k) {
      const StateLink& link = tree.link[k];
      Fast& f = fast[k];
      const double* constants = tree.quads + 4L * kLinkQuads * k;
      if (link.has_b) f.moment += cross(f.b, f.force);
      const Quad z = quad(constants + 4 * 20);
      const double effort =
          link.motion == StateMotion::kTurns ? dot(z, f.moment) : dot(z, f.force);
      for (int e = link.first_share; e < link.end_share; ++e)
        tau[tree.share[e].coordinate] += tree.share[e].coefficient * effort;
      if (link.parent < 0) continue;
      Fast& above = fast[link.parent];
      const Quad force = combined(f.columns, f.force);
      above.force += force;
      above.moment += combined(f.columns, f.moment);
      if (link.has_a) above.moment += cross(quad(constants + 4 * 18), force);
    }
  }

  __attribute__((flatten)) static void mass_matrix(const StateTree& tree, const double* q,
                                                   double* M, double* workspace) {
    const Memory at = divide(tree, workspace);
    rotations(tree, q, at);
    mass_of(tree, at, M);
  }

  __attribute__((flatten)) static void equation(const StateTree& tree, const double* q,
                                                const double* dq, double* M, double* h,
                                                double* workspace) {
    const Memory at = divide(tree, workspace);
    rotations(tree, q, at);
    velocities(tree, dq, nullptr, tree.gravity, at);
    body_forces(tree, at);
    back(tree, at, h);
    mass_of(tree, at, M);
  }

  // Jacobian columns of the coordinates of a group, in lanes.
  static void jacobians(const StateTree& tree, const Memory& at, int group) {
    for (int k = 0; k < tree.links; ++k) {
      const StateLink& link = tree.link[k];
      const State& state = at.state[k];
      P3 w = zero3<P>();
      P3 v = zero3<P>();
      if (link.parent >= 0) {
        const Column& above = at.column[link.parent];
        w = apply_transposed(state.R, above.a);
        P3 middle = above.b;
        if (link.has_a) middle = plus(middle, cross(above.a, load3(link.a)));
        v = apply_transposed(state.R, middle);
      }
      const D3 z = load3(link.z);
      const P own = shares(tree, link, group);
      if (link.motion == StateMotion::kTurns) w = plus(w, times(own, z));
      if (link.motion == StateMotion::kSlides) v = plus(v, times(own, z));
      if (link.has_b) v = plus(v, cross(w, state.b));
      at.column[k] = {w, v};
    }
  }

  // Coefficients of the link's variable, one coordinate a lane.
  static P shares(const StateTree& tree, const StateLink& link, int group) {
    P own(0.0);
    for (int e = link.first_share; e < link.end_share; ++e) {
      const int lane = tree.share[e].coordinate - group * kLanes;
      if (lane >= 0 && lane < kLanes) own.v[lane] = tree.share[e].coefficient;
    }
    return own;
  }

  __attribute__((flatten)) static void regressor(const StateTree& tree, const double* q,
                                                 const double* dq, const double* ddq, double* Y,
                                                 double* workspace) {
    const Memory at = divide(tree, workspace);
    const int n = tree.coordinates;
    rotations(tree, q, at);
    velocities(tree, dq, ddq, tree.gravity, at);
    for (int group = 0; group * kLanes < n; ++group) {
      jacobians(tree, at, group);
      const int count = n - group * kLanes < kLanes ? n - group * kLanes : kLanes;
      for (int k = 0; k < tree.links; ++k) {
        const int body = tree.link[k].body;
        if (body < 0) continue;
        double* to = Y + 10L * body * n + group * kLanes;
        // A whole pack may be written where what it writes too much is still to come: columns
        // follow each other in memory and in time.
        const long left = 10L * (tree.bodies - body) * n;
        entries(at.state[k], at.column[k], [&](int c, const P& y) {
          if (count == kLanes || (n <= kLanes && left - c * n >= kLanes)) {
            *reinterpret_cast<Unaligned*>(to + c * n) = y.v;
          } else {
            for (int l = 0; l < count; ++l) to[c * n + l] = y.v[l];
          }
        });
      }
    }
  }

  // See regressor_entries() of recursion.hpp.
  template <typename Put>
  static void entries(const State& b, const Column& c, const Put& put) {
    const P3& w = c.a;
    const P3& v = c.b;
    const D3 products = {b.omega.y * b.omega.z, b.omega.x * b.omega.z, b.omega.x * b.omega.y};
    const D3 squares = {b.omega.x * b.omega.x, b.omega.y * b.omega.y, b.omega.z * b.omega.z};
    const D3 differences = {squares.y - squares.z, squares.z - squares.x, squares.x - squares.y};
    const P3 turned = cross(b.accel, w);
    put(0, dot(v, b.accel));
    put(1, dot(v, b.E.x) + turned.x);
    put(2, dot(v, b.E.y) + turned.y);
    put(3, dot(v, b.E.z) + turned.z);
    put(4, w.x * b.alpha.x + w.y * products.y - w.z * products.z);
    put(5, w.y * b.E.y.z - w.x * b.E.x.z + w.z * differences.z);
    put(6, w.y * b.alpha.y + w.z * products.z - w.x * products.x);
    put(7, w.x * b.E.x.y - w.z * b.E.z.y + w.y * differences.y);
    put(8, w.z * b.E.z.x - w.y * b.E.y.x + w.x * differences.x);
    put(9, w.z * b.alpha.z + w.x * products.x - w.y * products.y);
  }

  // Tangents of the recursion along the coordinates of a group: of q (then `of_q`) or of dq.
  template <bool kOfPosition>
  static void tangents(const StateTree& tree, const Memory& at, int group, double* slopes) {
    for (int k = 0; k < tree.links; ++k) {
      const StateLink& link = tree.link[k];
      const State& state = at.state[k];
      Tangent& t = at.tangent[k];
      t.ds = shares(tree, link, group);
      const P& own = t.ds;
      P3 w = zero3<P>();
      P3 alpha = zero3<P>();
      P3 accel = zero3<P>();
      if (link.parent >= 0) {
        const Tangent& above = at.tangent[link.parent];
        w = apply_transposed(state.R, above.omega);
        alpha = apply_transposed(state.R, above.alpha);
        P3 middle = above.accel;
        if (link.has_a) middle = plus(middle, apply(above.E, load3(link.a)));
        accel = apply_transposed(state.R, middle);
      }
      const D3 z = load3(link.z);
      const bool turns = link.motion == StateMotion::kTurns;
      const bool slides = link.motion == StateMotion::kSlides;
      if (turns && kOfPosition) {  // d/ds (R' x) = (R' x) x z
        w = plus(w, times(own, cross(state.w, z)));
        alpha = plus(alpha, times(own, cross(state.before_alpha, z)));
        accel = plus(accel, times(own, cross(state.before_accel, z)));
      }
      t.omega = w;
      if (turns) {
        alpha = plus(alpha, times(state.ds, cross(w, z)));
        if (!kOfPosition) {
          alpha = plus(alpha, times(own, cross(state.w, z)));
          t.omega = plus(w, times(own, z));
        }
      }
      t.alpha = alpha;
      t.E = spin_tangent(state.omega, t.omega, t.alpha);
      if (slides) {
        accel = plus(accel, times(2.0 * state.ds, cross(w, z)));
        if (kOfPosition) accel = plus(accel, times(own, apply(state.E, z)));
        if (!kOfPosition) accel = plus(accel, times(own, times(2.0, cross(state.w, z))));
      }
      if (link.has_b) accel = plus(accel, apply(t.E, state.b));
      t.accel = accel;
      t.force = zero3<P>();
      t.moment = zero3<P>();
      if (link.body < 0) continue;
      const double* p = tree.phi + 10 * link.body;
      const D3 h = load3(p + 1);
      t.force = plus(times(p[0], t.accel), apply(t.E, h));
      t.moment = plus(plus(inertia(p + 4, t.alpha), cross(h, t.accel)),
                      plus(cross(t.omega, inertia(p + 4, state.omega)),
                           cross(state.omega, inertia(p + 4, t.omega))));
    }
    const int n = tree.coordinates;
    const int count = n - group * kLanes < kLanes ? n - group * kLanes : kLanes;
    for (int k = tree.links - 1; k >= 0; --k) {
      const StateLink& link = tree.link[k];
      const State& state = at.state[k];
      Tangent& t = at.tangent[k];
      const D3 z = load3(link.z);
      if (link.has_b) t.moment = plus(t.moment, cross(state.b, t.force));
      if (kOfPosition && link.motion == StateMotion::kSlides)
        t.moment = plus(t.moment, times(t.ds, cross(z, state.force)));
      const P effort = link.motion == StateMotion::kTurns ? dot(z, t.moment) : dot(z, t.force);
      for (int e = link.first_share; e < link.end_share; ++e) {
        double* row = slopes + group * kLanes * n + tree.share[e].coordinate;
        for (int l = 0; l < count; ++l)
          row[l * n] += tree.share[e].coefficient * effort.v[l];
      }
      if (link.parent < 0) continue;
      Tangent& above = at.tangent[link.parent];
      P3 force = t.force;
      P3 moment = t.moment;
      if (kOfPosition && link.motion == StateMotion::kTurns) {  // d/ds (R x) = R (z x x)
        force = plus(force, times(t.ds, cross(z, state.force)));
        moment = plus(moment, times(t.ds, cross(z, state.moment)));
      }
      force = apply(state.R, force);
      above.force = plus(above.force, force);
      above.moment = plus(above.moment, apply(state.R, moment));
      if (link.has_a) above.moment = plus(above.moment, cross(load3(link.a), force));
    }
  }

  __attribute__((flatten)) static void slopes(const StateTree& tree, const double* q,
                                              const double* dq, const double* ddq, double* tau,
                                              double* by_q, double* by_dq, double* M,
                                              double* workspace) {
    const Memory at = divide(tree, workspace);
    const int n = tree.coordinates;
    rotations(tree, q, at);
    velocities(tree, dq, ddq, tree.gravity, at);
    body_forces(tree, at);
    back(tree, at, tau);  // forces now are those of all that a link carries, about its joint
    for (int e = 0; e < n * n; ++e) by_q[e] = 0.0;
    for (int e = 0; e < n * n; ++e) by_dq[e] = 0.0;
    for (int group = 0; group * kLanes < n; ++group) {
      tangents<true>(tree, at, group, by_q);
      tangents<false>(tree, at, group, by_dq);
    }
    mass_of(tree, at, M);
  }

  // M = L D L', L below the diagonal and 1 / D on it.
  static bool factor(int n, double* M) {
    for (int j = 0; j < n; ++j) {
      double* column = M + j * n;
      const double d = column[j];
      if (!(d > 0.0)) return false;
      const double inverse = 1.0 / d;
      for (int k = j + 1; k < n; ++k) {
        const double share = column[k] * inverse;
        double* next = M + k * n;
        for (int i = k; i < n; ++i) next[i] -= share * column[i];
      }
      column[j] = inverse;
      for (int i = j + 1; i < n; ++i) column[i] *= inverse;
    }
    return true;
  }

  static void solve(int n, const double* L, int columns, double* X) {
    for (int c = 0; c < columns; ++c) {
      double* x = X + c * n;
      for (int j = 0; j < n; ++j)
        for (int i = j + 1; i < n; ++i) x[i] -= L[j * n + i] * x[j];
      for (int j = 0; j < n; ++j) x[j] *= L[j * n + j];
      for (int j = n - 1; j >= 0; --j) {
        double sum = x[j];
        for (int i = j + 1; i < n; ++i) sum -= L[j * n + i] * x[i];
        x[j] = sum;
      }
    }
  }

  __attribute__((flatten)) static bool forward_dynamics(const StateTree& tree, const double* q,
                                                        const double* dq, const double* tau,
                                                        double* ddq, double* M,
                                                        double* workspace) {
    equation(tree, q, dq, M, ddq, workspace);
    const int n = tree.coordinates;
    for (int i = 0; i < n; ++i) ddq[i] = tau[i] - ddq[i];
    if (!factor(n, M)) return false;
    solve(n, M, 1, ddq);
    return true;
  }

  static StateKernels kernels() {
    StateKernels out;
    out.workspace = &workspace;
    out.inverse_dynamics = &inverse_dynamics;
    out.mass_matrix = &mass_matrix;
    out.equation = &equation;
    out.regressor = &regressor;
    out.slopes = &slopes;
    out.forward_dynamics = &forward_dynamics;
    out.factor = &factor;
    out.solve = &solve;
    return out;
  }
};

}  // namespace veridyn
