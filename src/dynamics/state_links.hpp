#pragma once

// A tree as the kernels of single states read it: constants folded so that a joint costs one
// rotation matrix. Plain numbers only; see regressor_batch_kernels.hpp for why.

namespace veridyn {

enum class StateMotion { kNone, kTurns, kSlides };

/// One link. T_parent_link = A J(s) B of links.hpp, seen from the link: its frame is that behind B.
struct StateLink {
  int parent;     ///< -1: the world
  int body;       ///< -1: none
  int joint;      ///< index among the moving links; -1: it does not move
  StateMotion motion;
  bool has_a;
  bool has_b;
  double still[9];   ///< R_parent_link = still + cosine c + sine s, row by row
  double cosine[9];
  double sine[9];
  double a[3];  ///< from the parent's origin to the joint, in the parent's frame
  double b[3];  ///< from the joint to the link's origin at s = 0, in the link's frame
  double z[3];  ///< the joint's axis, in the link's frame
  double offset;
  int first_share, end_share;
};

struct StateShare {
  int coordinate;
  double coefficient;
};

struct StateTree {
  int coordinates;
  int links;
  int joints;  ///< moving links
  int bodies;
  const StateLink* link;
  const StateShare* share;
  const double* phi;  ///< ten of every body, null where only motion is asked for
  /// The links' constants again, four doubles a vector (the last zero): kLinkQuads of every link,
  /// then kBodyQuads of every body.
  const double* quads;
  double gravity[3];
};

/// Rows of still, cosine and sine, then their columns, then a, b, z.
constexpr int kLinkQuads = 21;
/// First moment, the three columns of the inertia, and the mass in front of a last one.
constexpr int kBodyQuads = 5;

/// Kernels of one state; vectors hold `coordinates` entries, matrices are column-major without gaps.
struct StateKernels {
  /// Doubles of workspace, aligned to 64 bytes.
  unsigned long (*workspace)(const StateTree& tree) = nullptr;
  /// dq and ddq null: rest.
  void (*inverse_dynamics)(const StateTree& tree, const double* q, const double* dq,
                           const double* ddq, double* tau, double* workspace) = nullptr;
  void (*mass_matrix)(const StateTree& tree, const double* q, double* M,
                      double* workspace) = nullptr;
  /// M and tau(q, dq, 0).
  void (*equation)(const StateTree& tree, const double* q, const double* dq, double* M, double* h,
                   double* workspace) = nullptr;
  /// ddq of torques; M is left factored. False if it is not positive definite.
  bool (*forward_dynamics)(const StateTree& tree, const double* q, const double* dq,
                           const double* tau, double* ddq, double* M,
                           double* workspace) = nullptr;
  /// (coordinates x 10 bodies).
  void (*regressor)(const StateTree& tree, const double* q, const double* dq, const double* ddq,
                    double* Y, double* workspace) = nullptr;
  /// tau and its derivatives by q and dq, (coordinates x coordinates) each, and M = dtau/dddq.
  void (*slopes)(const StateTree& tree, const double* q, const double* dq, const double* ddq,
                 double* tau, double* by_q, double* by_dq, double* M, double* workspace) = nullptr;
  /// M = L D L' in place, (n x n); then X = M^-1 X for the columns of X. False if M is not positive
  /// definite.
  bool (*factor)(int n, double* M) = nullptr;
  void (*solve)(int n, const double* L, int columns, double* X) = nullptr;
};

StateKernels state_kernels_baseline();
StateKernels state_kernels_avx2();
StateKernels state_kernels_avx512();

/// The widest that this processor has.
const StateKernels& state_kernels();

}  // namespace veridyn
