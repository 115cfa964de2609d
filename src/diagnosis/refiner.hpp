#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "inquiry.hpp"

namespace veridyn {

/// The shape constants of accepted hypotheses (a presliding distance, a Stribeck velocity), refined
/// by variable projection: the recordings are streamed again with a few values around the present
/// ones, and every constant descends to the least weighted residual.
class Refiner {
 public:
  using Shapes = std::map<std::string, double>;  ///< constants of one hypothesis by name

  /// @param known  constants to begin with, one entry for each accepted; empty: those asked.
  Refiner(const Identification& start, const Inquiry& asked, const Selection& selection,
          bool changes, const std::vector<std::string>& train, const IdentificationOptions& how,
          const std::vector<Shapes>& known);

  const std::vector<Shapes>& shapes() const { return shapes_; }

  /// Whether there is a constant to refine.
  bool anything() const;

  /// Three rounds, from wide steps to small ones.
  void descend();

  /// The arm with the accepted hypotheses at their present constants.
  AugmentedModel model() const;

  /// Where the constants may lie, from one cluster left out each.
  std::vector<ShapeInterval> intervals() const { return intervals_; }

 private:
  struct Variant;
  using Factors = std::array<double, 6>;

  AugmentedModel model_with(std::vector<Variant>& variants) const;
  std::vector<Variant> present() const;
  std::vector<Variant> around(const Factors& factors) const;
  double one_wave(int joint) const;
  void run(const Factors& factors);
  template <typename SetOf>
  void measure_intervals(const NormalBlocks& data, const std::vector<Variant>& variants,
                         const SetOf& set_of, const std::vector<size_t>& pick, const VectorXd& w);

  const Identification& start_;
  const Inquiry& asked_;
  bool changes_;
  const std::vector<std::string>& train_;
  const IdentificationOptions& how_;
  std::optional<Model> arm_;
  std::vector<Hypothesis> chosen_;
  std::vector<Shapes> shapes_;
  std::vector<ShapeInterval> intervals_;
};

}  // namespace veridyn
