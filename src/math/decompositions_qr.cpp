#include "math/decompositions.hpp"

namespace Eigen {

template class ColPivHouseholderQR<MatrixXd>;
template class CompleteOrthogonalDecomposition<MatrixXd>;
template class HouseholderQR<MatrixXd>;

}  // namespace Eigen
