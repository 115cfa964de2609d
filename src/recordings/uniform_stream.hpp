#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "veridyn/model/joint_sensors.hpp"
#include "veridyn/recordings/preprocessing.hpp"

namespace veridyn {

/// Resamples raw rows on a uniform grid; holds only a sliding part of the recording.
class UniformStream {
 public:
  using Source = std::function<Recording(int rows)>;  ///< the next rows, empty at the end

  /// @throws InvalidInput  wrong number of joints, no torques, fewer than two usable rows.
  UniformStream(const Model& arm, std::string name, Source source,
                const PreprocessingOptions& options);

  /// Reads until `rows` samples are held, after dropping `discard` of them, or until the recording ends.
  /// Returns the number of held samples.
  Eigen::Index hold(Eigen::Index rows, Eigen::Index discard);

  bool ended() const { return ended_; }
  bool has_velocity() const { return has_velocity_; }
  double dt() const { return dt_; }  ///< [s]
  double start() const { return t_first_; }  ///< [s] time of grid index 0
  long rows_read() const { return rows_read_; }

  /// Held samples (rows x 3 n): q, dq (if recorded, else 2 n columns), tau; and a flag for the validity of
  /// each.
  using Samples = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
  Samples samples() const { return {samples_.data(), held(), width_}; }
  const std::vector<char>& sound() const { return sound_; }

  /// Index on the grid of the first held sample.
  long first_index() const { return first_index_; }

  /// Sensor errors; offsets and gains of the samples are corrected, delays are not.
  const JointSensors& sensors() const { return sensors_; }

  /// Time of row options.first_row of the file; valid once that row has been read.
  double first_wanted_time() const { return t_wanted_first_; }
  double last_wanted_time() const { return t_wanted_last_; }

 private:
  struct Row {
    double t;
    std::vector<double> values;
  };
  void read_piece();  ///< the next rows of the source
  void emit_until(const Row& row);  ///< adds samples of the grid up to this row
  double longest_bridge() const;  ///< [s] largest distance between rows that is not a gap
  bool is_usable(const Recording& piece, Eigen::Index row) const;  ///< all values are finite and plausible
  void make_row(const Recording& piece, Eigen::Index row, Row& out) const;
  void count_numbers(const Recording& piece, Eigen::Index row);
  std::string missing_numbers() const;  ///< columns without which no row is usable
  Eigen::Index held() const { return static_cast<Eigen::Index>(sound_.size()); }
  void check(const Recording& piece) const;

  const Model& arm_;
  JointSensors sensors_;
  std::string name_;
  Source source_;
  PreprocessingOptions options_;
  bool started_ = false;
  bool ended_ = false;
  bool has_velocity_ = false;
  double dt_ = 0.0;
  double step_ = 0.0;  ///< median step of the file [s]
  double t_first_ = 0.0;
  double t_wanted_first_ = 1e300;  ///< very large until the first selected row has been read
  double t_wanted_last_ = 1e300;
  long next_index_ = 0;
  long first_index_ = 0;
  long rows_read_ = 0;
  std::map<std::string, long> numbers_;  ///< usable numbers of each column before the first usable row
  Row row_{0.0, {}}, previous_{0.0, {}};
  double most_held_ = 0.0;  ///< largest number of held samples
  Eigen::Index width_ = 0;
  std::vector<double> samples_;  ///< row by row
  std::vector<char> sound_;
};

}  // namespace veridyn
