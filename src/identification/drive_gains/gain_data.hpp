#pragma once

#include <map>
#include <string>
#include <vector>

#include "identification/drive_gains/gain_problem.hpp"
#include "veridyn/identification/compressed_recording.hpp"
#include "veridyn/identification/drive_gains.hpp"

namespace veridyn {

/// Recordings of currents, compressed once, from which the equations follow for any division into loaded and
/// unloaded recordings.
///
/// Columns: standard parameters of the arm, with a separate set for each recording of the effects that vary
/// from day to day, and ten parameters of each load, on a frame of its own.
class GainData {
 public:
  /// @param load_of  for every recording the index of the load that it carries or may carry.
  GainData(const Model& arm, const std::vector<std::string>& recordings,
           const std::vector<KnownMass>& loads, const std::vector<int>& load_of,
           const PreprocessingOptions& preprocessing, int threads);

  /// One factor for every cluster and joint; the columns of a load are present only in loaded recordings.
  std::vector<std::vector<SquareRootInformation>> clusters(const std::vector<bool>& loaded) const;

  /// Names of the columns to solve for, of those that are identifiable from any motion, and of the known
  /// ones.
  struct Columns {
    std::vector<std::string> unknown;
    std::vector<std::string> alone;  ///< columns that are identifiable alone
    std::map<std::string, double> known;
  };
  Columns columns(const std::vector<bool>& loaded) const;

  size_t recording_count() const { return recordings_.size(); }
  int load_of(size_t recording) const { return load_of_[recording]; }

  /// Number of clusters of all recordings. They are numbered consecutively.
  int cluster_count() const;
  size_t recording_of_cluster(size_t cluster) const;

  /// A load's ten columns, in the order of InertialParameters.
  static std::vector<std::string> load_columns(int load);

  /// (n) largest torque of one kilogram on the load's frame at rest.
  VectorXd weight_torque(int load) const;

 private:
  std::string column_name(const StandardParameter& parameter, size_t recording) const;

  std::vector<Model> arms_;  ///< for every recording, with its load
  std::vector<std::vector<StandardParameter>> parameters_;
  std::vector<int> load_of_;
  std::vector<KnownMass> loads_;
  std::vector<CompressedRecording> recordings_;
};

/// Builds the equation of one joint.
GainEquation gain_equation(const SquareRootInformation& factor, const GainData::Columns& columns);

}  // namespace veridyn
