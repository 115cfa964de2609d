#include "math/decompositions.hpp"

namespace Eigen {

template class FullPivLU<MatrixXd>;
template class PartialPivLU<MatrixXd>;
template class LDLT<MatrixXd>;
template class LLT<MatrixXd>;

}  // namespace Eigen
