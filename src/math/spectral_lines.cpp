#include "math/spectral_lines.hpp"

#include <Eigen/Core>

#include <cmath>

namespace veridyn {

std::vector<double> line_amplitudes(const std::vector<double>& places, const std::vector<double>& values,
                                    double first, double step, size_t count) {
  const auto n = static_cast<Eigen::Index>(places.size());
  const Eigen::Map<const Eigen::ArrayXd> s(places.data(), n), r(values.data(), n);
  // The terms of each frequency are those of the previous one, rotated by exp(-i step s).
  const Eigen::ArrayXd turn_re = (step * s).cos();
  const Eigen::ArrayXd turn_im = -(step * s).sin();
  Eigen::ArrayXd re = r * (first * s).cos();
  Eigen::ArrayXd im = -r * (first * s).sin();
  Eigen::ArrayXd turned(n);
  std::vector<double> out;
  for (size_t k = 0; k < count; ++k) {
    out.push_back(2.0 * std::hypot(re.sum(), im.sum()) / static_cast<double>(n));
    turned = re * turn_re - im * turn_im;
    im = re * turn_im + im * turn_re;
    re.swap(turned);
  }
  return out;
}

}  // namespace veridyn
