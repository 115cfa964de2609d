#include "math/decompositions.hpp"

namespace Eigen {

template class BDCSVD<MatrixXd>;
template class JacobiSVD<MatrixXd>;

}  // namespace Eigen
