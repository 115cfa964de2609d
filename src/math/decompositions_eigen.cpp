#include "math/decompositions.hpp"

namespace Eigen {

template class SelfAdjointEigenSolver<MatrixXd>;
template class SelfAdjointEigenSolver<Matrix3d>;
template class SelfAdjointEigenSolver<Matrix4d>;
template SelfAdjointEigenSolver<Matrix3d>& SelfAdjointEigenSolver<Matrix3d>::compute(const EigenBase<Matrix3d>&, int);
template SelfAdjointEigenSolver<Matrix4d>& SelfAdjointEigenSolver<Matrix4d>::compute(const EigenBase<Matrix4d>&, int);
template SelfAdjointEigenSolver<MatrixXd>& SelfAdjointEigenSolver<MatrixXd>::compute(const EigenBase<MatrixXd>&, int);

#if EIGEN_VERSION_AT_LEAST(3, 4, 0) && !EIGEN_VERSION_AT_LEAST(3, 4, 90)
namespace internal {

template void tridiagonalization_inplace(MatrixXd&, VectorXd&);
template ComputationInfo computeFromTridiagonal_impl(VectorXd&, VectorXd&, Index, bool, MatrixXd&);

}  // namespace internal
#endif

}  // namespace Eigen
