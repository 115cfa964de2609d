#include <algorithm>
#include <utility>

#include "regressor/column_source.hpp"

namespace veridyn {
namespace {

class SomeColumns final : public ColumnSource {
 public:
  SomeColumns(std::unique_ptr<ColumnSource> from, std::vector<int> kept)
      : from_(std::move(from)), kept_(std::move(kept)) {}

  int count() const override { return static_cast<int>(kept_.size()); }
  bool has_memory() const override { return from_->has_memory(); }
  std::vector<int> columns(int joint) const override {
    std::vector<int> out;
    for (const auto& [own, theirs] : places(joint)) {
      static_cast<void>(theirs);
      out.push_back(own);
    }
    return out;
  }
  void evaluate(const MotionSamples& motion, std::vector<MatrixXd>& Y) const override {
    std::vector<MatrixXd> all;
    from_->evaluate(motion, all);
    Y.resize(all.size());
    for (size_t i = 0; i < all.size(); ++i) {
      const auto of_joint = places(static_cast<int>(i));
      Y[i].resize(motion.rows(), static_cast<Eigen::Index>(of_joint.size()));
      for (size_t k = 0; k < of_joint.size(); ++k)
        Y[i].col(k) = all[i].col(of_joint[k].second);
    }
  }
  void add_gradient(const MotionSamples& motion, const std::vector<MatrixXd>& weights,
                    MatrixXd& slopes) const override {
    std::vector<MatrixXd> all;
    for (size_t i = 0; i < weights.size(); ++i) {
      const int joint = static_cast<int>(i);
      const auto width = static_cast<Eigen::Index>(from_->columns(joint).size());
      all.push_back(MatrixXd::Zero(motion.rows(), width));
      const auto of_joint = places(joint);
      for (size_t k = 0; k < of_joint.size(); ++k)
        all[i].col(of_joint[k].second) = weights[i].col(k);
    }
    from_->add_gradient(motion, all, slopes);
  }

 private:
  // Pairs of a column's index here and its index among the source's columns of the joint.
  std::vector<std::pair<int, int>> places(int joint) const {
    const std::vector<int> theirs = from_->columns(joint);
    std::vector<std::pair<int, int>> out;
    for (size_t k = 0; k < kept_.size(); ++k) {
      const auto at = std::find(theirs.begin(), theirs.end(), kept_[k]);
      if (at != theirs.end()) out.emplace_back(static_cast<int>(k), at - theirs.begin());
    }
    return out;
  }

  std::unique_ptr<ColumnSource> from_;
  std::vector<int> kept_;
};

}  // namespace

std::unique_ptr<ColumnSource> some_columns(std::unique_ptr<ColumnSource> from,
                                           std::vector<int> kept) {
  return std::make_unique<SomeColumns>(std::move(from), std::move(kept));
}

}  // namespace veridyn
