#include "math/decompositions.hpp"

namespace Eigen {

template class SelfAdjointEigenSolver<MatrixXd>;
template class SelfAdjointEigenSolver<Matrix3d>;
template class SelfAdjointEigenSolver<Matrix4d>;

}  // namespace Eigen
