#include "math/decompositions.hpp"

namespace Eigen {

template class BDCSVD<MatrixXd>;
template class JacobiSVD<MatrixXd>;
template void SVDBase<JacobiSVD<MatrixXd>>::_solve_impl(const VectorXd&, VectorXd&) const;
template void SVDBase<BDCSVD<MatrixXd>>::_solve_impl(const VectorXd&, VectorXd&) const;

}  // namespace Eigen
