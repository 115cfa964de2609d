#include "math/decompositions.hpp"

namespace Eigen {
#if EIGEN_VERSION_AT_LEAST(3, 4, 0) && !EIGEN_VERSION_AT_LEAST(3, 4, 90)
namespace internal {

template struct gemm_pack_lhs<double, Index, ConstBlas<ColMajor>, Gebp::mr, Gebp::LhsProgress, Gebp::LhsPacket4Packing, ColMajor, false, false>;
template struct gemm_pack_lhs<double, Index, ConstBlas<RowMajor>, Gebp::mr, Gebp::LhsProgress, Gebp::LhsPacket4Packing, RowMajor, false, false>;
template struct gemm_pack_rhs<double, Index, ConstBlas<ColMajor>, Gebp::nr, ColMajor, false, false>;
template struct gemm_pack_rhs<double, Index, ConstBlas<RowMajor>, Gebp::nr, RowMajor, false, false>;
template struct general_matrix_vector_product<Index, double, ConstBlas<ColMajor>, ColMajor, false, double, ConstBlas<RowMajor>, false, 0>;
template struct general_matrix_vector_product<Index, double, ConstBlas<ColMajor>, ColMajor, false, double, ConstBlas<ColMajor>, false, 0>;
template struct general_matrix_vector_product<Index, double, ConstBlas<RowMajor>, RowMajor, false, double, ConstBlas<ColMajor>, false, 0>;
template struct general_matrix_vector_product<Index, double, ConstBlas<RowMajor>, RowMajor, false, double, ConstBlas<RowMajor>, false, 1>;
template struct selfadjoint_matrix_vector_product<double, Index, ColMajor, Lower, false, false, 0>;
template struct triangular_solve_vector<double, double, Index, OnTheLeft, Lower, false, ColMajor>;
template struct triangular_solve_vector<double, double, Index, OnTheLeft, Upper, false, ColMajor>;
template struct triangular_solve_vector<double, double, Index, OnTheLeft, Upper, false, RowMajor>;
template struct triangular_solve_vector<double, double, Index, OnTheLeft, Lower, false, RowMajor>;
template void evaluateProductBlockingSizesHeuristic<double, double, 1, Index>(Index&, Index&, Index&, Index);
template void evaluateProductBlockingSizesHeuristic<double, double, 4, Index>(Index&, Index&, Index&, Index);
template void generic_product_impl<MatrixXd, MatrixXd, DenseShape, DenseShape, GemmProduct>::scaleAndAddTo(MatrixXd&, const MatrixXd&, const MatrixXd&, const double&);
template void generic_product_impl<Transpose<const MatrixXd>, MatrixXd, DenseShape, DenseShape, GemmProduct>::scaleAndAddTo(MatrixXd&, const Transpose<const MatrixXd>&, const MatrixXd&, const double&);
template void generic_product_impl<MatrixXd, Transpose<const MatrixXd>, DenseShape, DenseShape, GemmProduct>::scaleAndAddTo(MatrixXd&, const MatrixXd&, const Transpose<const MatrixXd>&, const double&);

}  // namespace internal
#endif
}  // namespace Eigen
