#include "math/decompositions.hpp"

namespace Eigen {

template class FullPivLU<MatrixXd>;
template class PartialPivLU<MatrixXd>;
template class LDLT<MatrixXd>;
template class LLT<MatrixXd>;
template class LLT<Matrix4d>;
template LLT<Matrix4d>& LLT<Matrix4d>::compute(const EigenBase<Matrix4d>&);
template LLT<MatrixXd>& LLT<MatrixXd>::compute(const EigenBase<MatrixXd>&);
template LDLT<MatrixXd>& LDLT<MatrixXd>::compute(const EigenBase<MatrixXd>&);
template PartialPivLU<MatrixXd>& PartialPivLU<MatrixXd>::compute(const EigenBase<MatrixXd>&);
template void LLT<MatrixXd>::_solve_impl_transposed<true>(const VectorXd&, VectorXd&) const;
template void LLT<MatrixXd>::_solve_impl_transposed<true>(const MatrixXd&, MatrixXd&) const;
template void LDLT<MatrixXd>::_solve_impl_transposed<true>(const VectorXd&, VectorXd&) const;
template void LDLT<MatrixXd>::_solve_impl_transposed<true>(const MatrixXd&, MatrixXd&) const;

#if EIGEN_VERSION_AT_LEAST(3, 4, 0) && !EIGEN_VERSION_AT_LEAST(3, 4, 90)
namespace internal {

template Index llt_inplace<double, Lower>::blocked(MatrixXd&);
template Index llt_inplace<double, Lower>::unblocked(MatrixXd&);
template bool ldlt_inplace<Lower>::unblocked(MatrixXd&, Transpositions<Dynamic>&, VectorXd&, SignMatrix&);

}  // namespace internal
#endif

}  // namespace Eigen
