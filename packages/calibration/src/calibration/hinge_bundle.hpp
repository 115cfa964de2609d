#pragma once

#include <memory>

#include "hinge_path.hpp"
#include "hinges.hpp"
#include "least_squares.hpp"

namespace veridyn::internal {

/// All markers, axes and angles of one tree of hinges, as one least-squares problem.
///
/// The reference is the configuration at one frame, where all angles are zero. A marker at position x there
/// is at frame k at
///
///   G_k exp(xi_1 theta_1k) ... exp(xi_d theta_dk) x
///
/// with the hinges from the root to its body. G_k moves the root, or is the identity if the root rests. A
/// hinge that closes a loop has its own line, which at every frame has to be the same through either of its
/// bodies, within its play.
class HingeBundle {
 public:
  HingeBundle(const MarkerCapture& capture, const std::vector<RigidBody>& bodies,
              const HingeTree& tree, const AxesOptions& options);

  /// True if enough frames show the markers; else reason() states what is missing.
  bool ready() const { return reason_.empty(); }
  const std::string& reason() const { return reason_; }

  /// Minimises the residuals, excludes outliers and estimates the play of loops; call it once if ready().
  void fit();

  const HingeTree& tree() const { return tree_; }
  /// Hinges of the tree, then those that close a loop.
  int hinges() const { return static_cast<int>(tree_.hinges.size() + tree_.closing.size()); }
  const Hinge& hinge(int hinge) const;
  bool closes_loop(int hinge) const { return hinge >= static_cast<int>(tree_.hinges.size()); }
  /// [m] of a hinge that closes a loop: rms gap of the loop beyond the noise; zero if the noise explains all
  /// of it.
  double play(int hinge) const;
  int frames() const { return static_cast<int>(frames_.size()); }
  int outliers() const { return outliers_; }
  double noise() const { return noise_; }  ///< [m] standard deviation of one coordinate
  double correlation() const { return correlation_; }
  double degrees_of_freedom() const { return degrees_of_freedom_; }
  std::vector<double> residuals() const;  ///< [m] one per coordinate of every marker

  /// [m] Line of a hinge at the reference, with shared unknowns displaced by `step` (empty: none).
  Line line(int hinge, const VectorXd& step = {}) const;
  /// (3 x markers) [m] markers of a body of the tree at the reference.
  MatrixXd shape(int body) const;
  /// Hinges from the root to a hinge, without that hinge.
  std::vector<int> path_from_root(int hinge) const;
  /// Hinges from the root to a body (index of the capture).
  std::vector<int> path(int body) const;
  /// (frames) [rad] angles of a hinge, 0 at the reference.
  VectorXd angles(int hinge) const;
  /// Covariance of functions of the lines and of mean angles over some frames.
  /// @param shared        (functions x shared unknowns)
  /// @param mean_angles   (functions x hinges): derivatives by the mean angle over `over`
  MatrixXd covariance(const MatrixXd& shared, const MatrixXd& mean_angles,
                      const std::vector<int>& over) const;
  int shared_size() const { return problem_.shared_size(); }
  /// Index of the first of a hinge's four unknowns among the shared ones.
  int first_unknown(int hinge) const;

 private:
  struct Seen {
    int frame, body, marker;  // used frame; body of the capture; marker of the body
  };
  void choose_frames();
  void set_initial_values();
  void add_markers();
  void add_closures();
  HingePath free_path(const std::vector<int>& hinges, int frame) const;
  Residual residual(const Seen& seen) const;
  void reject_outliers();
  void estimate_uncertainty();
  double closure_leverage(const Observation& o, int frame) const;
  enum class Spread { kRobust, kMeanSquare };  // estimator of the spread of a loop's gaps; kRobust tolerates outliers
  bool estimate_play(Spread spread);
  void close_loops();
  int hinge_of(int body) const;

  const MarkerCapture& capture_;
  const std::vector<RigidBody>& bodies_;
  HingeTree tree_;
  const AxesOptions& options_;
  std::string reason_;
  std::vector<int> frames_;  // frames of the capture; the reference comes first
  std::vector<Line> start_;
  std::vector<Eigen::Matrix<double, 3, 2>> plane_;  // two unit vectors across each initial line
  std::vector<Eigen::Isometry3d> root_start_;       // initial pose of the root, by used frame
  LeastSquares problem_;
  std::vector<int> hinge_unknown_;
  std::vector<int> frame_unknown_;                 // by used frame: its block of unknowns; -1: the reference
  std::vector<std::vector<int>> marker_unknown_;   // block of unknowns of every marker, by body of the tree
  std::vector<Seen> seen_;  // marker and frame of every observation
  struct Closed {
    int closing, frame;
  };
  std::vector<Closed> closed_;     // loop and frame of the observations after those of markers
  std::vector<double> deviation_;  // [m] deviation of the points of a closing hinge, by closing hinge
  std::vector<double> play_;       // [m] rms play, by closing hinge
  std::unique_ptr<Information> information_;
  double noise_ = 0.0, correlation_ = 1.0, degrees_of_freedom_ = 1.0;
  double variance_ = 1.0;  // variance of the residuals, with the factor of correlated frames
  int outliers_ = 0;
};

}  // namespace veridyn::internal
