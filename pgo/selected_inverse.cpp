#include "pgo/selected_inverse.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "slam/base/error.hpp"

namespace imslam::pgo {
namespace {

/// A pivot of the matrix with unit diagonal is 1 - (multiple correlation)^2; below this the unknown
/// is not determined by the others to working precision.
constexpr double kSmallestPivot = 1e-13;

}  // namespace

std::optional<SelectedInverse> SelectedInverse::factorize(const Eigen::SparseMatrix<double>& H) {
  const Eigen::VectorXd diagonal = H.diagonal();
  if (!diagonal.allFinite() || !(diagonal.size() > 0 && diagonal.minCoeff() > 0.0)) {
    return std::nullopt;
  }
  SelectedInverse result;
  result.scale_ = diagonal.cwiseSqrt().cwiseInverse();
  const Eigen::SparseMatrix<double> scaled =
      result.scale_.asDiagonal() * H * result.scale_.asDiagonal();
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> ldlt(scaled);
  if (ldlt.info() != Eigen::Success) return std::nullopt;
  const Eigen::VectorXd D = ldlt.vectorD();
  if (!D.allFinite() || D.minCoeff() < kSmallestPivot) return std::nullopt;

  result.log_determinant_ = D.array().log().sum() + diagonal.array().log().sum();
  result.position_ = ldlt.permutationP().indices();
  result.invert(ldlt.matrixL().nestedExpression(), D);
  return result;
}

void SelectedInverse::invert(const Eigen::SparseMatrix<double>& L, const Eigen::VectorXd& D) {
  const Eigen::Index size = L.cols();
  lower_ = L.triangularView<Eigen::StrictlyLower>();
  lower_.makeCompressed();
  diagonal_.resize(size);
  const int* starts = lower_.outerIndexPtr();
  const int* rows = lower_.innerIndexPtr();
  double* Z = lower_.valuePtr();  // columns right of j hold Z, column j and left of it still L
  std::vector<int> slot(static_cast<std::size_t>(size), -1);
  std::vector<double> z;
  for (Eigen::Index j = size - 1; j >= 0; --j) {
    const int start = starts[j];
    const int count = starts[j + 1] - start;
    z.assign(static_cast<std::size_t>(count), 0.0);
    for (int a = 0; a < count; ++a) slot[static_cast<std::size_t>(rows[start + a])] = a;
    for (int a = 0; a < count; ++a) {
      const int k = rows[start + a];
      z[static_cast<std::size_t>(a)] -= Z[start + a] * diagonal_[k];
      for (int e = starts[k]; e < starts[k + 1]; ++e) {
        const int b = slot[static_cast<std::size_t>(rows[e])];
        if (b < 0) continue;
        z[static_cast<std::size_t>(b)] -= Z[start + a] * Z[e];
        z[static_cast<std::size_t>(a)] -= Z[start + b] * Z[e];
      }
    }
    diagonal_[j] = 1.0 / D[j];
    for (int a = 0; a < count; ++a) {
      diagonal_[j] -= Z[start + a] * z[static_cast<std::size_t>(a)];
      slot[static_cast<std::size_t>(rows[start + a])] = -1;
    }
    std::copy(z.begin(), z.end(), Z + start);
  }
}

double SelectedInverse::operator()(Eigen::Index row, Eigen::Index column) const {
  const int i = position_[row];
  const int j = position_[column];
  const double scale = scale_[row] * scale_[column];
  if (i == j) return scale * diagonal_[i];
  const int first = std::min(i, j);
  const int* begin = lower_.innerIndexPtr() + lower_.outerIndexPtr()[first];
  const int* end = lower_.innerIndexPtr() + lower_.outerIndexPtr()[first + 1];
  const int* found = std::lower_bound(begin, end, std::max(i, j));
  expects(found != end && *found == std::max(i, j), "selected inverse: entry was not computed");
  return scale * lower_.valuePtr()[found - lower_.innerIndexPtr()];
}

}  // namespace imslam::pgo
