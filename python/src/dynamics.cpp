#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <memory>

#include "bindings.hpp"
#include "model_handle.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/simulation/joint_torques.hpp"

namespace veridyn::python {
namespace {

constexpr Eigen::Index kBlock = 512;  // rows of one call: what is copied stays in the cache

using Array = py::array_t<double, py::array::forcecast>;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Columns = Eigen::Map<const MatrixXd, 0, Eigen::OuterStride<>>;

// How a matrix lies in memory.
enum class Layout { kColumns, kRows };

// (rows x n) numbers of Python's, read where they are: no copy for either layout without gaps.
struct Samples {
  Array array;
  Eigen::Index rows = 0, columns = 0;
  bool single = false;  // (n): one state
  Layout layout = Layout::kRows;

  Samples(const char* where, const char* name, const Array& given, const Model& arm)
      : array(given) {
    single = given.ndim() == 1;
    require(given.ndim() == 1 || given.ndim() == 2, where, ": ", name, " has ", given.ndim(),
            " dimensions, expected (n) or (N, n).");
    rows = single ? 1 : given.shape(0);
    columns = given.shape(single ? 0 : 1);
    require(columns == arm.joints(), where, ": ", name, " has ", columns,
            " columns, but arm '", arm.name(), "' has ", arm.joints(), " joints.");
    if (!single && (given.flags() & py::array::f_style) != 0 && rows > 1) {
      layout = Layout::kColumns;
    } else if ((given.flags() & py::array::c_style) == 0) {
      array = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(given);
    }
  }

  // Rows first .. first + count - 1, column by column; `copy` is where they go if they are not.
  Columns block(Eigen::Index first, Eigen::Index count, MatrixXd& copy) const {
    const double* data = array.data();
    if (layout == Layout::kColumns)
      return Columns(data + first, count, columns, Eigen::OuterStride<>(rows));
    copy.resize(count, columns);
    copy = Eigen::Map<const RowMajor>(data + first * columns, count, columns);
    return Columns(copy.data(), count, columns, Eigen::OuterStride<>(count));
  }
};

// q, dq and ddq of one call.
struct States {
  Samples q, dq, ddq;

  States(const char* where, const Array& q_, const Array& dq_, const Array& ddq_, const Model& arm)
      : q(where, "q", q_, arm), dq(where, "dq", dq_, arm), ddq(where, "ddq", ddq_, arm) {
    require(dq.rows == q.rows && ddq.rows == q.rows, where, ": q has ", q.rows, " rows, dq ",
            dq.rows, " and ddq ", ddq.rows, ", expected the same number.");
  }

  // No block of any of them is copied.
  bool columns_only() const {
    return q.layout == Layout::kColumns && dq.layout == Layout::kColumns &&
           ddq.layout == Layout::kColumns;
  }

  MotionSamples motion(const std::optional<VectorXd>& time) const {
    MatrixXd copy;
    MotionSamples out;
    out.time = time ? *time : VectorXd(VectorXd::Zero(q.rows));
    require(out.time.size() == q.rows, "joint_torques: time has ", out.time.size(),
            " entries, expected ", q.rows, ".");
    out.q = q.block(0, q.rows, copy);
    out.dq = dq.block(0, q.rows, copy);
    out.ddq = ddq.block(0, q.rows, copy);
    return out;
  }
};

const BatchOf& with_values(const char* where, const SharedModel& arm) {
  const BatchOf& batch = arm.batch();
  require(batch.phi.has_value(), where, ": arm '", arm.name(),
          "' has bodies without mass, com and inertia.");
  return batch;
}

// (N, n) in the layout of the input, (n) of one state.
py::array_t<double> like(const Samples& q, Eigen::Index columns) {
  const auto step = static_cast<py::ssize_t>(sizeof(double));
  if (q.single) return py::array_t<double>(columns);
  if (q.layout == Layout::kRows) return py::array_t<double>({q.rows, columns});
  return py::array_t<double>({q.rows, columns}, {step, step * q.rows});
}

// All rows at once; what comes out belongs to Python as it is.
py::array_t<double> torques_in_place(const BatchOf& batch, const States& x) {
  auto tau = std::make_unique<MatrixXd>();
  {
    const py::gil_scoped_release free;
    MatrixXd none;
    batch.regressor.torques(x.q.block(0, x.q.rows, none), x.dq.block(0, x.q.rows, none),
                            x.ddq.block(0, x.q.rows, none), *batch.phi, *tau);
  }
  const auto step = static_cast<py::ssize_t>(sizeof(double));
  const MatrixXd& values = *tau;
  const py::capsule owner(tau.release(), [](void* kept) { delete static_cast<MatrixXd*>(kept); });
  return py::array_t<double>({values.rows(), values.cols()}, {step, step * values.rows()},
                             values.data(), owner);
}

py::array_t<double> inverse_dynamics_of(const SharedModel& arm, const Array& q, const Array& dq,
                                        const Array& ddq) {
  const States x("inverse_dynamics", q, dq, ddq, arm);
  const BatchOf& batch = with_values("inverse_dynamics", arm);
  if (x.columns_only()) return torques_in_place(batch, x);
  py::array_t<double> out = like(x.q, arm.joints());
  double* tau = out.mutable_data();
  const Eigen::Index n = arm.joints();
  const py::gil_scoped_release free;
  MatrixXd block, a, b, c;
  for (Eigen::Index first = 0; first < x.q.rows; first += kBlock) {
    const Eigen::Index count = std::min(kBlock, x.q.rows - first);
    batch.regressor.torques(x.q.block(first, count, a), x.dq.block(first, count, b),
                            x.ddq.block(first, count, c), *batch.phi, block);
    if (x.q.layout == Layout::kColumns) {
      Eigen::Map<MatrixXd, 0, Eigen::OuterStride<>>(tau + first, count, n,
                                                    Eigen::OuterStride<>(x.q.rows)) = block;
    } else {
      Eigen::Map<RowMajor>(tau + first * n, count, n) = block;
    }
  }
  return out;
}

py::array_t<double> regressor_of(const SharedModel& arm, const Array& q, const Array& dq,
                                 const Array& ddq) {
  const States x("regressor", q, dq, ddq, arm);
  const BatchOf& batch = arm.batch();
  const auto n = static_cast<Eigen::Index>(arm.joints());
  const auto p = static_cast<Eigen::Index>(kBodyParameters * arm.bodies().size());
  py::array_t<double> out = x.q.single ? py::array_t<double>({n, p})
                                       : py::array_t<double>({x.q.rows, n, p});
  double* Y = out.mutable_data();
  const py::gil_scoped_release free;
  std::fill(Y, Y + x.q.rows * n * p, 0.0);
  std::vector<MatrixXd> blocks;
  MatrixXd a, b, c;
  for (Eigen::Index first = 0; first < x.q.rows; first += kBlock) {
    const Eigen::Index count = std::min(kBlock, x.q.rows - first);
    batch.regressor.evaluate(x.q.block(first, count, a), x.dq.block(first, count, b),
                             x.ddq.block(first, count, c), blocks);
    for (int i = 0; i < n; ++i) {
      const std::vector<int>& columns = batch.regressor.columns({i});
      const MatrixXd& own = blocks[i];
      for (Eigen::Index r = 0; r < count; ++r) {
        double* row = Y + ((first + r) * n + i) * p;
        for (size_t k = 0; k < columns.size(); ++k)
          row[columns[k]] = own(r, static_cast<Eigen::Index>(k));
      }
    }
  }
  return out;
}

py::array_t<double> joint_torques_of(const SharedModel& arm, const Array& q, const Array& dq,
                                     const Array& ddq, const std::optional<VectorXd>& time,
                                     int substeps) {
  const States x("joint_torques", q, dq, ddq, arm);
  py::array_t<double> out = like(x.q, arm.joints());
  double* data = out.mutable_data();
  const Eigen::Index n = arm.joints();
  const py::gil_scoped_release free;
  const MatrixXd tau = joint_torques(arm, x.motion(time), substeps);
  if (x.q.layout == Layout::kColumns) {
    Eigen::Map<MatrixXd>(data, x.q.rows, n) = tau;
  } else {
    Eigen::Map<RowMajor>(data, x.q.rows, n) = tau;
  }
  return out;
}

}  // namespace

void bind_dynamics(py::module_& m) {
  m.def("inverse_dynamics", &inverse_dynamics_of, py::arg("model"), py::arg("q"), py::arg("dq"),
        py::arg("ddq"));
  m.def("regressor", &regressor_of, py::arg("model"), py::arg("q"), py::arg("dq"), py::arg("ddq"));
  m.def("joint_torques", &joint_torques_of, py::arg("model"), py::arg("q"), py::arg("dq"),
        py::arg("ddq"), py::arg("time"), py::arg("substeps"));
  m.def("mass_matrix",
        [](const SharedModel& arm, const VectorXd& q) { return mass_matrix(arm, q); },
        py::arg("model"), py::arg("q"));
  m.def("coriolis_matrix",
        [](const SharedModel& arm, const VectorXd& q, const VectorXd& dq) {
          return coriolis_matrix(arm, q, dq);
        },
        py::arg("model"), py::arg("q"), py::arg("dq"));
}

}  // namespace veridyn::python
