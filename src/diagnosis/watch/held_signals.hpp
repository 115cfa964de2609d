#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/model/model.hpp"
#include "diagnosis/watch/watch_numbers.hpp"

namespace veridyn::watching {

/// A recorded row: positions, velocities and torques of all joints, one after the other (3 n).
struct Row {
  double t = 0.0;  ///< [s]
  VectorXd x;
};

/// Signals that repeat a value from row to row. Either they are refreshed more slowly than the rows come, and
/// are interpolated; or their joint rests; or their sensor or drive stopped.
class HeldSignals {
 public:
  HeldSignals(const Model& arm, const WatchNumbers& numbers) : numbers_(numbers), arm_(arm) {}

  /// A signal that stays the same to the last digit while its joint moves, longer than ever before: its sensor
  /// or drive does not answer, or it is saturated.
  struct Stopped {
    double since = 0.0;  ///< [s]
    std::string why;
  };
  /// Compares the next row with those before. Where a signal has a new value, its earlier rows that wait are interpolated.
  /// @param path     (3 n) a measure of the joint's motion that the signal does not enter, for q and tau.
  /// @param fastest  (n) [rad/s], [m/s] of the joints so far.
  /// @param sound    time of the last usable row [s]; nothing where it is not usable.
  std::optional<Stopped> compare(const Row& row, const VectorXd& path, const VectorXd& fastest, std::optional<double> sound);

  /// Queues a row until no held signal can get a new value any more, numbers.held at most.
  void wait(const Row& row) { waiting_.push_back(row); }
  /// The next row that is known, or nothing.
  std::optional<Row> next();
  void drop_waiting() { waiting_.clear(); }

  /// Shifts all stored times after the recording's clock was set back by so many seconds.
  void set_back(double by) { since_.array() -= by; }

  /// [s] between new values of the slowest of the first `signals` entries of these rows. What stays for > longest [s], or
  /// changes in its last digits only, does not count: a joint rests, or is slow.
  static double refresh_time(const std::deque<Row>& rows, Eigen::Index signals, double longest);

 private:
  void interpolate(Eigen::Index signal, const Row& row);

  const WatchNumbers& numbers_;
  const Model& arm_;
  /// (3 n) present value, since when [s], path then, longest such time before [s]
  VectorXd value_, since_, from_, longest_;
  std::vector<char> never_changed_, stopped_;
  double latest_ = 0.0;  // [s]
  std::deque<Row> waiting_;
};

}  // namespace veridyn::watching
