#include "slam/learner/linear_solve.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

namespace imslam::learner {
namespace {

MatrixProduct product(const Matrix& H) {
  return [H](const Vector& x) -> Vector { return H * x; };
}

const Matrix kPositive = (Matrix(3, 3) << 4.0, 1.0, 0.0, 1.0, 3.0, -1.0, 0.0, -1.0, 2.0).finished();
const Matrix kSingular = (Matrix(3, 3) << 1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 2.0).finished();
const Vector kRight = (Vector(3) << 1.0, -2.0, 0.5).finished();

TEST(LinearSolve, AllMethodsAgreeOnAPositiveMatrix) {
  const Vector expected = kPositive.inverse() * kRight;
  for (const LinearSolution& solution :
       {conjugate_gradient(product(kPositive), kRight, {}),
        gradient_descent(product(kPositive), kRight, {}), least_norm(kPositive, kRight, 1e-10)}) {
    EXPECT_TRUE(solution.report.converged) << solution.report.reason;
    EXPECT_LT((solution.q - expected).norm(), 1e-8);
    EXPECT_LT(solution.report.residual, 1e-10);
  }
}

TEST(LinearSolve, ASingularSystemWithASolutionGivesTheShortest) {
  const Vector right = (Vector(3) << 1.0, 1.0, 3.0).finished();
  const Vector shortest = (Vector(3) << 0.5, 0.5, 1.5).finished();
  const LinearSolution direct = least_norm(kSingular, right, 1e-10);
  EXPECT_LT((direct.q - shortest).norm(), 1e-12);
  EXPECT_NE(direct.report.reason.find("singular"), std::string::npos);
  EXPECT_LT((conjugate_gradient(product(kSingular), right, {}).q - shortest).norm(), 1e-9);
}

TEST(LinearSolve, ASingularSystemWithoutSolutionFailsAloud) {
  for (const LinearSolution& solution :
       {conjugate_gradient(product(kSingular), kRight, {}),
        gradient_descent(product(kSingular), kRight, {}), least_norm(kSingular, kRight, 1e-10)}) {
    EXPECT_FALSE(solution.report.converged);
    EXPECT_FALSE(solution.report.reason.empty());
    EXPECT_GT(solution.report.residual, 0.1);
  }
}

TEST(LinearSolve, ConjugateGradientNoticesASaddle) {
  const Matrix saddle = Vector((Vector(3) << 1.0, -1.0, 2.0).finished()).asDiagonal();
  const LinearSolution solution = conjugate_gradient(product(saddle), kRight, {});
  EXPECT_FALSE(solution.report.converged);
  EXPECT_NE(solution.report.reason.find("not positive"), std::string::npos);
}

TEST(LinearSolve, ARightSideOfZerosHasTheAnswerZero) {
  for (const LinearSolution& solution :
       {conjugate_gradient(product(kPositive), Vector::Zero(3), {}),
        gradient_descent(product(kPositive), Vector::Zero(3), {}),
        least_norm(kPositive, Vector::Zero(3), 1e-10)}) {
    EXPECT_TRUE(solution.report.converged);
    EXPECT_EQ(solution.q, Vector(Vector::Zero(3)));
  }
}

}  // namespace
}  // namespace imslam::learner
