#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

// Eigen's decompositions of the sizes used here are compiled once, in decompositions_*.cpp. A file that
// includes these declarations calls them and does not compile its own copy, which would cost 3 to 40 s each
// time. The precompiled headers of the library and the tests include this file; results do not depend on it.
namespace Eigen {

extern template class BDCSVD<MatrixXd>;
extern template class JacobiSVD<MatrixXd>;
extern template class ColPivHouseholderQR<MatrixXd>;
extern template class CompleteOrthogonalDecomposition<MatrixXd>;
extern template class HouseholderQR<MatrixXd>;
extern template class FullPivLU<MatrixXd>;
extern template class PartialPivLU<MatrixXd>;
extern template class LDLT<MatrixXd>;
extern template class LLT<MatrixXd>;
extern template class SelfAdjointEigenSolver<MatrixXd>;
extern template class SelfAdjointEigenSolver<Matrix3d>;
extern template class SelfAdjointEigenSolver<Matrix4d>;
extern template class LLT<Matrix4d>;

// Member templates are not part of a class's explicit instantiation; those for the usual arguments
// are declared here.
extern template SelfAdjointEigenSolver<MatrixXd>& SelfAdjointEigenSolver<MatrixXd>::compute(const EigenBase<MatrixXd>&, int);
extern template SelfAdjointEigenSolver<Matrix3d>& SelfAdjointEigenSolver<Matrix3d>::compute(const EigenBase<Matrix3d>&, int);
extern template SelfAdjointEigenSolver<Matrix4d>& SelfAdjointEigenSolver<Matrix4d>::compute(const EigenBase<Matrix4d>&, int);
extern template LLT<Matrix4d>& LLT<Matrix4d>::compute(const EigenBase<Matrix4d>&);
extern template LLT<MatrixXd>& LLT<MatrixXd>::compute(const EigenBase<MatrixXd>&);
extern template LDLT<MatrixXd>& LDLT<MatrixXd>::compute(const EigenBase<MatrixXd>&);
extern template PartialPivLU<MatrixXd>& PartialPivLU<MatrixXd>::compute(const EigenBase<MatrixXd>&);
extern template void LLT<MatrixXd>::_solve_impl_transposed<true>(const VectorXd&, VectorXd&) const;
extern template void LLT<MatrixXd>::_solve_impl_transposed<true>(const MatrixXd&, MatrixXd&) const;
extern template void LDLT<MatrixXd>::_solve_impl_transposed<true>(const VectorXd&, VectorXd&) const;
extern template void LDLT<MatrixXd>::_solve_impl_transposed<true>(const MatrixXd&, MatrixXd&) const;
extern template void ColPivHouseholderQR<MatrixXd>::_solve_impl(const VectorXd&, VectorXd&) const;
extern template void ColPivHouseholderQR<MatrixXd>::_solve_impl(const MatrixXd&, MatrixXd&) const;
extern template void CompleteOrthogonalDecomposition<MatrixXd>::_solve_impl(const VectorXd&, VectorXd&) const;
extern template void CompleteOrthogonalDecomposition<MatrixXd>::_solve_impl(const MatrixXd&, MatrixXd&) const;
extern template void HouseholderQR<MatrixXd>::_solve_impl(const VectorXd&, VectorXd&) const;
extern template void HouseholderQR<MatrixXd>::_solve_impl(const MatrixXd&, MatrixXd&) const;
extern template void SVDBase<JacobiSVD<MatrixXd>>::_solve_impl(const VectorXd&, VectorXd&) const;
extern template void SVDBase<BDCSVD<MatrixXd>>::_solve_impl(const VectorXd&, VectorXd&) const;
extern template void HouseholderSequence<MatrixXd, VectorXd>::evalTo(MatrixXd&) const;


#if EIGEN_VERSION_AT_LEAST(3, 4, 0) && !EIGEN_VERSION_AT_LEAST(3, 4, 90)
// Internal parts of decompositions and products that expressions would otherwise instantiate, with
// Eigen 3.4's names.
namespace internal {

using Gebp = gebp_traits<double, double>;
template <int Order>
using ConstBlas = const_blas_data_mapper<double, Index, Order>;

extern template struct gebp_kernel<double, double, Index, blas_data_mapper<double, Index, ColMajor, Unaligned, 1>, Gebp::mr, Gebp::nr, false, false>;
extern template struct gemm_pack_lhs<double, Index, ConstBlas<ColMajor>, Gebp::mr, Gebp::LhsProgress, Gebp::LhsPacket4Packing, ColMajor, false, false>;
extern template struct gemm_pack_lhs<double, Index, ConstBlas<RowMajor>, Gebp::mr, Gebp::LhsProgress, Gebp::LhsPacket4Packing, RowMajor, false, false>;
extern template struct gemm_pack_rhs<double, Index, ConstBlas<ColMajor>, Gebp::nr, ColMajor, false, false>;
extern template struct gemm_pack_rhs<double, Index, ConstBlas<RowMajor>, Gebp::nr, RowMajor, false, false>;
extern template struct general_matrix_vector_product<Index, double, ConstBlas<ColMajor>, ColMajor, false, double, ConstBlas<RowMajor>, false, 0>;
extern template struct general_matrix_vector_product<Index, double, ConstBlas<ColMajor>, ColMajor, false, double, ConstBlas<ColMajor>, false, 0>;
extern template struct general_matrix_vector_product<Index, double, ConstBlas<RowMajor>, RowMajor, false, double, ConstBlas<ColMajor>, false, 0>;
extern template struct general_matrix_vector_product<Index, double, ConstBlas<RowMajor>, RowMajor, false, double, ConstBlas<RowMajor>, false, 1>;
extern template struct selfadjoint_matrix_vector_product<double, Index, ColMajor, Lower, false, false, 0>;
extern template struct triangular_solve_vector<double, double, Index, OnTheLeft, Lower, false, ColMajor>;
extern template struct triangular_solve_vector<double, double, Index, OnTheLeft, Upper, false, ColMajor>;
extern template struct triangular_solve_vector<double, double, Index, OnTheLeft, Upper, false, RowMajor>;
extern template struct triangular_solve_vector<double, double, Index, OnTheLeft, Lower, false, RowMajor>;
extern template void evaluateProductBlockingSizesHeuristic<double, double, 1, Index>(Index&, Index&, Index&, Index);
extern template void evaluateProductBlockingSizesHeuristic<double, double, 4, Index>(Index&, Index&, Index&, Index);
extern template void generic_product_impl<MatrixXd, MatrixXd, DenseShape, DenseShape, GemmProduct>::scaleAndAddTo(MatrixXd&, const MatrixXd&, const MatrixXd&, const double&);
extern template void generic_product_impl<Transpose<const MatrixXd>, MatrixXd, DenseShape, DenseShape, GemmProduct>::scaleAndAddTo(MatrixXd&, const Transpose<const MatrixXd>&, const MatrixXd&, const double&);
extern template void generic_product_impl<MatrixXd, Transpose<const MatrixXd>, DenseShape, DenseShape, GemmProduct>::scaleAndAddTo(MatrixXd&, const MatrixXd&, const Transpose<const MatrixXd>&, const double&);

extern template void tridiagonalization_inplace(MatrixXd&, VectorXd&);
extern template ComputationInfo computeFromTridiagonal_impl(VectorXd&, VectorXd&, Index, bool, MatrixXd&);
extern template Index llt_inplace<double, Lower>::blocked(MatrixXd&);
extern template Index llt_inplace<double, Lower>::unblocked(MatrixXd&);
extern template bool ldlt_inplace<Lower>::unblocked(MatrixXd&, Transpositions<Dynamic>&, VectorXd&, SignMatrix&);

}  // namespace internal
#endif

}  // namespace Eigen
