#include <algorithm>
#include <cmath>

#include "deviations.hpp"
#include "hinge_bundle.hpp"

// Hinges that close a loop of a HingeBundle.

namespace veridyn::internal {
namespace {

// Deviation of a closing hinge without play, relative to that of a marker's coordinate: 1 % of the variance
// of one marker, so that the loop is closed.
constexpr double kRigid = 0.1;
// Ratio of the variance of a loop's gaps to that explained by the noise, above which the loop has play. Over
// hundreds of frames the ratio of a hinge without play scatters by about a tenth.
constexpr double kPlays = 1.5;

}  // namespace

// Adds closures at every frame except the reference, where the angles are zero and the two lines coincide.
void HingeBundle::add_closures() {
  const std::size_t closing = tree_.closing.size();
  deviation_.assign(closing, noise_);
  play_.assign(closing, 0.0);
  for (std::size_t c = 0; c < closing; ++c) {
    const Hinge& hinge = tree_.closing[c];
    std::vector<int> a = path(hinge.a);
    std::vector<int> b = path(hinge.b);
    while (!a.empty() && !b.empty() && a.front() == b.front()) {
      a.erase(a.begin());
      b.erase(b.begin());
    }
    const int own = static_cast<int>(tree_.hinges.size() + c);
    for (int k = 1; k < frames(); ++k) {
      HingeClosure closure;
      closure.a = free_path(a, k);
      closure.b = free_path(b, k);
      closure.start = start_[own];
      closure.plane = plane_[own];
      closure.half = std::max(bodies_[hinge.b].breadth,
                              hinge.a < 0 ? 0.0 : bodies_[hinge.a].breadth);
      Observation o;
      o.size = 6;
      o.unknowns.push_back(hinge_unknown_[own]);
      for (const int j : a) o.unknowns.push_back(hinge_unknown_[j]);
      for (const int j : b) o.unknowns.push_back(hinge_unknown_[j]);
      o.unknowns.push_back(frame_unknown_[k]);
      const double* deviation = &deviation_[c];
      o.residual = [closure = std::move(closure), deviation](const double* const* x, double* r,
                                                             double* const* J) {
        closure.evaluate(x, *deviation, r, J);
      };
      problem_.add(std::move(o));
      closed_.push_back({static_cast<int>(c), k});
    }
  }
}

// Trace of these rows' part of the hat matrix: the number of unknowns that they determine.
double HingeBundle::closure_leverage(const Observation& o, int frame) const {
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  std::vector<const double*> x;
  std::vector<RowMajor> blocks;
  for (const int u : o.unknowns) {
    x.push_back(problem_.value(u).data());
    blocks.emplace_back(RowMajor::Zero(o.size, problem_.value(u).size()));
  }
  std::vector<double*> into;
  for (RowMajor& block : blocks) into.push_back(block.data());
  VectorXd r(o.size);
  o.residual(x.data(), r.data(), into.data());
  MatrixXd shared = MatrixXd::Zero(o.size, problem_.shared_size());
  for (std::size_t k = 0; k + 1 < o.unknowns.size(); ++k)
    shared.middleCols(problem_.shared_offset(o.unknowns[k]), blocks[k].cols()) = blocks[k];
  return information_->covariance(shared, {{frame_unknown_[frame], blocks.back()}}).trace();
}

// Estimates the play of every closing hinge by comparing the gap of the loop with the noise of its bodies. A
// row's residual e = gap d / (d^2 + v) has the redundancy d^2 / (d^2 + v), with the deviation d of the
// closure and the variance v of the gap without it: e^2 over the redundancy is gap^2 over d^2 + v.
bool HingeBundle::estimate_play(Spread spread) {
  bool changed = false;
  for (std::size_t c = 0; c < deviation_.size(); ++c) {
    double square = 0.0;
    double redundancy = 0.0;
    double rows = 0.0;
    std::vector<double> lengths;
    for (std::size_t k = 0; k < closed_.size(); ++k) {
      if (closed_[k].closing != static_cast<int>(c)) continue;
      const Observation& o = problem_.observations()[seen_.size() + k];
      const VectorXd e = problem_.residual(o);
      square += e.squaredNorm();
      lengths.push_back(e.head<3>().norm());
      lengths.push_back(e.tail<3>().norm());
      redundancy += o.size - closure_leverage(o, closed_[k].frame);
      rows += o.size;
    }
    if (!(redundancy > 0.0)) continue;
    if (spread == Spread::kRobust)
      square = rows * std::pow(robust_deviation_of_lengths(lengths), 2.0);
    const double d = deviation_[c] * deviation_[c];
    const double noise = d * rows / redundancy - d;
    const double play = square / redundancy * (d + noise) - noise;
    const double found = play > (kPlays - 1.0) * noise ? std::sqrt(play) : 0.0;
    changed = changed || found != play_[c];
    play_[c] = found;
  }
  return changed;
}

// Sets each closure's deviation to 0.1 of the noise, plus its play.
void HingeBundle::close_loops() {
  for (std::size_t c = 0; c < deviation_.size(); ++c)
    deviation_[c] = std::hypot(kRigid * noise_, play_[c]);
}

double HingeBundle::play(int hinge) const {
  return closes_loop(hinge) ? play_[hinge - tree_.hinges.size()] : 0.0;
}

}  // namespace veridyn::internal
