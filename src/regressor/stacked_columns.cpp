#include "regressor/stacked_columns.hpp"

#include <cmath>
#include <numeric>
#include <utility>

namespace veridyn {

StackedColumns::StackedColumns(int joints, std::vector<std::shared_ptr<const ColumnSource>> sources)
    : sources_(std::move(sources)), places_(static_cast<size_t>(joints)) {
  for (const auto& source : sources_) {
    columns_.emplace_back();
    for (int i = 0; i < joints; ++i) {
      columns_.back().push_back(source->columns(i));
      for (int& c : columns_.back().back()) c += count_;
    }
    count_ += source->count();
  }
  std::vector<int> all(count_);
  std::iota(all.begin(), all.end(), 0);
  choose(all);
}

void StackedColumns::choose(const std::vector<int>& columns) {
  std::vector<int> place(count_, -1);
  for (size_t c = 0; c < columns.size(); ++c)
    place[columns[c]] = static_cast<int>(c);
  chosen_ = static_cast<int>(columns.size());
  for (size_t i = 0; i < places_.size(); ++i) {
    places_[i].clear();
    for (size_t s = 0; s < sources_.size(); ++s) {
      const std::vector<int>& of_joint = columns_[s][i];
      for (size_t c = 0; c < of_joint.size(); ++c) {
        const int column = place[of_joint[c]];
        if (column >= 0) places_[i].push_back({s, static_cast<int>(c), column});
      }
    }
  }
}

std::vector<std::vector<MatrixXd>> StackedColumns::evaluate(const MotionSamples& motion) const {
  std::vector<std::vector<MatrixXd>> Y(sources_.size());
  for (size_t s = 0; s < sources_.size(); ++s) sources_[s]->evaluate(motion, Y[s]);
  return Y;
}

MatrixXd StackedColumns::rows_of(size_t joint, const std::vector<std::vector<MatrixXd>>& Y,
                                 Eigen::Index rows) const {
  const std::vector<Place>& places = places_[joint];
  MatrixXd W(rows, static_cast<Eigen::Index>(places.size()));
  for (size_t k = 0; k < places.size(); ++k) {
    W.col(k) = Y[places[k].source][joint].col(places[k].local);
  }
  return W;
}

MatrixXd StackedColumns::stacked(const MotionSamples& motion) const {
  const auto Y = evaluate(motion);
  const auto joints = static_cast<Eigen::Index>(places_.size());
  MatrixXd W = MatrixXd::Zero(motion.rows() * joints, count_);
  for (size_t s = 0; s < sources_.size(); ++s) {
    for (size_t i = 0; i < places_.size(); ++i) {
      for (size_t c = 0; c < columns_[s][i].size(); ++c) {
        W.col(columns_[s][i][c])
            .segment(static_cast<Eigen::Index>(i) * motion.rows(), motion.rows()) =
            Y[s][i].col(c);
      }
    }
  }
  return W;
}

MatrixXd StackedColumns::gram(const MotionSamples& motion, const VectorXd& row_weights) const {
  const std::vector<MatrixXd> grams = joint_grams(motion);
  MatrixXd G = MatrixXd::Zero(chosen_, chosen_);
  for (size_t i = 0; i < grams.size(); ++i)
    G += std::pow(row_weights[static_cast<Eigen::Index>(i)], 2) * grams[i];
  return G;
}

std::vector<MatrixXd> StackedColumns::joint_grams(const MotionSamples& motion) const {
  const auto Y = evaluate(motion);
  std::vector<MatrixXd> out(places_.size(), MatrixXd::Zero(chosen_, chosen_));
  for (size_t i = 0; i < places_.size(); ++i) {
    const MatrixXd W = rows_of(i, Y, motion.rows());
    const MatrixXd part = W.transpose() * W;
    for (Eigen::Index c = 0; c < part.cols(); ++c) {
      for (Eigen::Index r = 0; r < part.rows(); ++r) {
        out[i](places_[i][r].column,
               places_[i][c].column) = part(r, c);
      }
    }
  }
  return out;
}

MatrixXd StackedColumns::gradient(const MotionSamples& motion, const VectorXd& row_weights,
                                  const MatrixXd& by_gram) const {
  std::vector<MatrixXd> by_grams;
  for (const double weight : row_weights) by_grams.push_back(weight * weight * by_gram);
  return gradient(motion, by_grams);
}

MatrixXd StackedColumns::gradient(const MotionSamples& motion,
                                  const std::vector<MatrixXd>& by_gram) const {
  const auto Y = evaluate(motion);
  std::vector<std::vector<MatrixXd>> weights(sources_.size());
  for (size_t s = 0; s < sources_.size(); ++s) {
    for (size_t i = 0; i < places_.size(); ++i) {
      weights[s].push_back(MatrixXd::Zero(motion.rows(), Y[s][i].cols()));
    }
  }
  for (size_t i = 0; i < places_.size(); ++i) {
    const std::vector<Place>& places = places_[i];
    const auto count = static_cast<Eigen::Index>(places.size());
    MatrixXd part(count, count);
    for (Eigen::Index c = 0; c < count; ++c) {
      for (Eigen::Index r = 0; r < count; ++r) {
        part(r, c) = by_gram[i](places[r].column,
                                places[c].column);
      }
    }
    const MatrixXd by_row = 2.0 * (rows_of(i, Y, motion.rows()) * part);
    for (size_t k = 0; k < places.size(); ++k) {
      weights[places[k].source][i].col(places[k].local) = by_row.col(k);
    }
  }
  MatrixXd slopes = MatrixXd::Zero(motion.rows(), 3 * motion.joints());
  for (size_t s = 0; s < sources_.size(); ++s)
    sources_[s]->add_gradient(motion, weights[s], slopes);
  return slopes;
}

}  // namespace veridyn
