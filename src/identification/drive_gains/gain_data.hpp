#pragma once

#include <map>
#include <string>
#include <vector>

#include "identification/drive_gains/gain_problem.hpp"
#include "veridyn/identification/compressed_recording.hpp"
#include "veridyn/identification/drive_gains.hpp"

namespace veridyn {

/// Recordings of currents, compressed once, from which equations for any division into loaded and
/// unloaded ones are made.
///
/// Columns are standard parameters of the arm, those of effects that drift from day to day apart
/// for every recording, and the ten of each load, on a frame of its own.
class GainData {
 public:
  /// @param load_of  index into loads for every recording: one that it carries or might carry.
  GainData(const Model& arm, const std::vector<std::string>& recordings,
           const std::vector<KnownMass>& loads, const std::vector<int>& load_of,
           const PreprocessingOptions& preprocessing, int threads);

  /// One factor for every cluster and joint, the load's columns only where a recording is loaded.
  std::vector<std::vector<SquareRootInformation>> clusters(const std::vector<bool>& loaded) const;

  /// Names of columns to solve for: as many as motions of any kind can tell apart, and known.
  struct Columns {
    std::vector<std::string> unknown;
    std::vector<std::string> alone;  ///< Those that stand for themselves only
    std::map<std::string, double> known;
  };
  Columns columns(const std::vector<bool>& loaded) const;

  size_t recording_count() const { return recordings_.size(); }
  int load_of(size_t recording) const { return load_of_[recording]; }

  /// Of all recordings, one after the other.
  int cluster_count() const;
  size_t recording_of_cluster(size_t cluster) const;

  /// A load's ten columns, in the order of InertialParameters.
  static std::vector<std::string> load_columns(int load);

  /// (n) largest torque of one kilogram on the load's frame where the arm rests.
  VectorXd weight_torque(int load) const;

 private:
  std::string column_name(const StandardParameter& parameter, size_t recording) const;

  std::vector<Model> arms_;  ///< for every recording, with its load
  std::vector<std::vector<StandardParameter>> parameters_;
  std::vector<int> load_of_;
  std::vector<KnownMass> loads_;
  std::vector<CompressedRecording> recordings_;
};

/// The equation of one joint.
GainEquation gain_equation(const SquareRootInformation& factor, const GainData::Columns& columns);

}  // namespace veridyn
