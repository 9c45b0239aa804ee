#include "slam/evaluation/evaluate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "slam/base/error.hpp"
#include "slam/evaluation/rigid_matrix.hpp"
#include "tests/slam/evaluation/paths.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::evaluation {
namespace {

using testing::disturbed;
using testing::expect_near;
using testing::moved;
using testing::some_motion;
using testing::winding_path;

bool mentions(const Evaluation& evaluation, const std::string& words) {
  return std::any_of(evaluation.warnings.begin(), evaluation.warnings.end(),
                     [&](const std::string& w) { return w.find(words) != std::string::npos; });
}

Eigen::Matrix4d yaw_motion() {
  return rigid(Eigen::AngleAxisd(1.9, Eigen::Vector3d::UnitZ()).toRotationMatrix(), {50, -70, 3});
}

void expect_same_figures(const Evaluation& a, const Evaluation& b, double tolerance) {
  const auto near = [&](double x, double y) { EXPECT_NEAR(x, y, tolerance * std::abs(y)); };
  near(*a.ate_se3_rmse_m, *b.ate_se3_rmse_m);
  near(*a.ate_posyaw_rmse_m, *b.ate_posyaw_rmse_m);
  near(*a.ate_sim3_rmse_m, *b.ate_sim3_rmse_m);
  near(*a.scale, *b.scale);
  near(*a.rpe_1m_rmse_m, *b.rpe_1m_rmse_m);
  near(a.rpe_frame_rmse_m, b.rpe_frame_rmse_m);
  near(a.rpe_frame_rmse_deg, b.rpe_frame_rmse_deg);
  near(a.rotation_end_deg, b.rotation_end_deg);
  near(*a.end_error_percent, *b.end_error_percent);
  near(a.path_length_m, b.path_length_m);
  EXPECT_EQ(a.matched, b.matched);
}

// K5: neither the choice of the worlds nor of the clock's zero may matter.
TEST(Evaluate, DoesNotChangeWithHeadingAndOriginOfEitherWorld) {
  const PosePath reference = winding_path(400);
  const PosePath estimate = disturbed(reference);
  expect_same_figures(
      evaluate(moved(reference, rigid_inverse(yaw_motion())), moved(estimate, yaw_motion())),
      evaluate(reference, estimate), 1e-9);
}

TEST(Evaluate, DoesNotChangeWithACommonShiftInTime) {
  PosePath reference = winding_path(400);
  PosePath estimate = disturbed(reference);
  const Evaluation before = evaluate(reference, estimate);
  for (PosePath* path : {&reference, &estimate}) {
    for (double& stamp : path->stamps_s) stamp += 4096.0;
  }
  expect_same_figures(evaluate(reference, estimate), before, 1e-12);
}

TEST(Evaluate, SeesOneConstantStepAtTheEnd) {
  const PosePath reference = winding_path(200);
  PosePath estimate = moved(reference, some_motion());
  estimate.poses.back() =
      estimate.poses.back() *
      rigid(Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitX()).toRotationMatrix(), {0.3, 0.4, 0});
  const Evaluation evaluation = evaluate(reference, estimate);
  EXPECT_NEAR(evaluation.rotation_end_deg, 0.02 * kDegreesPerRadian, 1e-9);
  EXPECT_NEAR(*evaluation.end_error_percent, 50.0 / evaluation.path_length_m, 1e-9);
  EXPECT_NEAR(evaluation.rpe_frame_rmse_m, 0.5 / std::sqrt(199.0), 1e-9);
}

TEST(Evaluate, GivesOneErrorPerPoseInTheReferencesWorld) {
  const PosePath reference = winding_path(200);
  const Evaluation evaluation = evaluate(reference, moved(disturbed(reference), some_motion()));
  const PoseErrors& poses = evaluation.poses;
  ASSERT_EQ(poses.times_s.size(), 200U);
  double sum = 0.0;
  for (std::size_t i = 0; i < 200; ++i) {
    EXPECT_EQ(poses.times_s[i], reference.stamps_s[i]);
    EXPECT_NEAR((poses.reference_m[i] - poses.estimate_m[i]).norm(), poses.position_m[i], 1e-12);
    EXPECT_LT(poses.rotation_rad[i], 0.1);
    sum += poses.position_m[i] * poses.position_m[i];
  }
  EXPECT_NEAR(std::sqrt(sum / 200.0), *evaluation.ate_se3_rmse_m, 1e-12);
  expect_near(evaluation.se3.matrix() * some_motion(), Eigen::Matrix4d::Identity(), 0.05);
}

TEST(Evaluate, LeavesOutWhatAShortPathDoesNotDetermine) {
  const PosePath reference = winding_path(400);
  const Evaluation evaluation = evaluate(reference, disturbed(reference));
  EXPECT_FALSE(evaluation.t_rel_percent.has_value());  // under 100 m
  EXPECT_FALSE(evaluation.r_rel_deg_per_100m.has_value());
  EXPECT_EQ(evaluation.sub_trajectories.by_length.size(), 5U);
  const PosePath tiny = winding_path(5);  // under 1 m
  EXPECT_FALSE(evaluate(tiny, disturbed(tiny)).rpe_1m_rmse_m.has_value());
}

TEST(Evaluate, OfAStraightLineGivesWhatItCanAndTheReason) {
  PosePath line = winding_path(100);
  for (std::size_t i = 0; i < 100; ++i) {
    line.poses[i] = rigid(Eigen::Matrix3d::Identity(), {0.1 * double(i), 0, 0});
  }
  const Evaluation evaluation = evaluate(line, line);
  EXPECT_FALSE(evaluation.ate_se3_rmse_m.has_value());
  EXPECT_FALSE(evaluation.scale.has_value());
  EXPECT_TRUE(mentions(evaluation, "Degenerate covariance rank"));
  EXPECT_EQ(evaluation.poses.position_m.size(), 100U);
  EXPECT_NEAR(*evaluation.end_error_percent, 0.0, 1e-12);
}

TEST(Evaluate, OfABodyAtRestHasNoEndErrorPercent) {
  PosePath still = winding_path(20);
  for (auto& pose : still.poses) pose = some_motion();
  const Evaluation evaluation = evaluate(still, still);
  EXPECT_FALSE(evaluation.end_error_percent.has_value());
  EXPECT_EQ(evaluation.rpe_frame_rmse_m, 0.0);
}

TEST(Evaluate, InterpolationPaysWhereStampsDiffer) {
  const PosePath reference = winding_path(800, 0.02);
  PosePath estimate;
  estimate.source = "estimate";
  for (std::size_t i = 0; i + 2 < 800; i += 3) {  // exact poses, halfway between the reference's
    const PosePath fine = winding_path(2 * i + 2, 0.01);
    estimate.stamps_s.push_back(fine.stamps_s.back());
    estimate.poses.push_back(fine.poses.back());
  }
  EvaluationOptions options;
  options.association.max_difference_s = 0.0101;
  const Evaluation nearest = evaluate(reference, estimate, options);
  ASSERT_TRUE(nearest.interpolated.has_value());
  EXPECT_LT(*nearest.interpolated->ate_se3_rmse_m, 0.1 * *nearest.ate_se3_rmse_m);
  options.association.interpolate = true;
  const Evaluation interpolated = evaluate(reference, estimate, options);
  EXPECT_FALSE(interpolated.interpolated.has_value());
  EXPECT_DOUBLE_EQ(*interpolated.ate_se3_rmse_m, *nearest.interpolated->ate_se3_rmse_m);
}

TEST(Evaluate, SaysNothingOfInterpolationWhereItMakesNoDifference) {
  const PosePath reference = winding_path(200);
  EXPECT_FALSE(evaluate(reference, disturbed(reference)).interpolated.has_value());
}

TEST(Evaluate, NoticesPosesOfAnotherFrameOfTheSameBody) {
  const Eigen::Matrix4d T_body_camera =
      rigid((Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished(), {0.05, 0.02, -0.01});
  const PosePath reference = winding_path(200);
  PosePath estimate = disturbed(reference);
  for (auto& pose : estimate.poses) pose = pose * T_body_camera;
  EXPECT_TRUE(mentions(evaluate(reference, estimate), "the frames differ"));

  EvaluationOptions options;
  options.T_body_eval = rigid_inverse(T_body_camera);
  const Evaluation corrected = evaluate(reference, estimate, options);
  EXPECT_FALSE(mentions(corrected, "frames differ"));
  const Evaluation plain = evaluate(reference, disturbed(reference));
  EXPECT_NEAR(*corrected.ate_se3_rmse_m, *plain.ate_se3_rmse_m, 1e-12);
}

/// A turn about the direction of a short, nearly straight path is one that its positions leave
/// open.
TEST(Evaluate, DoesNotTakeAnOpenAlignmentForAnotherFrame) {
  PosePath reference;
  reference.source = "reference";
  for (int i = 0; i < 12; ++i) {
    Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
    pose.topRightCorner<3, 1>() << 0.01 * i, 4e-4 * i * (11 - i) / 30.0, 0.0;
    reference.stamps_s.push_back(0.05 * i);
    reference.poses.push_back(pose);
  }
  PosePath estimate = reference;
  estimate.source = "estimate";
  for (int i = 0; i < 12; ++i) {  // a bow upwards instead of sideways, and lower
    auto place = estimate.poses[static_cast<std::size_t>(i)].topRightCorner<3, 1>();
    place.z() = 0.3 * place.y();
    place.y() = 0.0;
  }
  const Evaluation evaluation = evaluate(reference, estimate);
  EXPECT_LT(evaluation.se3.R(1, 1), 0.8);  // the alignment does turn it
  EXPECT_FALSE(mentions(evaluation, "the frames differ"));
}

TEST(Evaluate, NoticesDifferentLabelsOfFrames) {
  PosePath reference = winding_path(50);
  PosePath estimate = disturbed(reference);
  reference.frame = "body";
  estimate.frame = "left";
  EXPECT_TRUE(mentions(evaluate(reference, estimate), "poses of 'body'"));
}

TEST(Evaluate, NoticesWorldsWithDifferentVerticals) {
  const PosePath reference = winding_path(200);
  const Eigen::Matrix4d tip =
      rigid(Eigen::AngleAxisd(kPi / 2, Eigen::Vector3d::UnitX()).toRotationMatrix(), {0, 0, 0});
  EXPECT_TRUE(mentions(evaluate(reference, moved(disturbed(reference), tip)), "verticals"));
  EvaluationOptions options;
  options.up_estimate = -Eigen::Vector3d::UnitY();
  EXPECT_FALSE(mentions(evaluate(reference, moved(disturbed(reference), tip), options), "vertica"));
}

TEST(Evaluate, IsSilentWhenAllIsWell) {
  const PosePath reference = winding_path(200);
  EXPECT_TRUE(evaluate(reference, disturbed(reference)).warnings.empty());
}

// M17: each ends in a refusal with its reason, never in a number that is none.
struct BadInput {
  const char* name;
  std::function<void(PosePath&)> damage;
  const char* reason;
};

TEST(Evaluate, RefusesWhatIsNoTrajectory) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const BadInput cases[] = {
      {"NaN position", [&](PosePath& p) { p.poses[3](0, 3) = nan; }, "pose 4: not finite"},
      {"infinite rotation",
       [&](PosePath& p) { p.poses[0](1, 1) = std::numeric_limits<double>::infinity(); },
       "pose 1: not finite"},
      {"zero rotation", [](PosePath& p) { p.poses[5].topLeftCorner<3, 3>().setZero(); },
       "pose 6: the rotation matrix is not orthonormal"},
      {"reflection", [](PosePath& p) { p.poses[5].topLeftCorner<3, 3>() *= -1.0; },
       "not orthonormal"},
      {"scaled rotation", [](PosePath& p) { p.poses[5].topLeftCorner<3, 3>() *= 1.1; },
       "not orthonormal"},
      {"NaN stamp", [&](PosePath& p) { p.stamps_s[2] = nan; }, "pose 3: the stamp is not finite"},
      {"no poses", [](PosePath& p) { p = PosePath{}; }, "holds no poses"},
      {"no overlap",
       [](PosePath& p) {
         for (double& s : p.stamps_s) s += 1e4;
       },
       "found no matching timestamps"},
      {"one pose",
       [](PosePath& p) {
         p.poses.resize(1);
         p.stamps_s.resize(1);
       },
       "only one pose matches"},
  };
  for (const BadInput& bad : cases) {
    const PosePath good = winding_path(20);
    PosePath damaged = good;
    bad.damage(damaged);
    try {
      evaluate(good, damaged);
      ADD_FAILURE() << "accepted: " << bad.name;
    } catch (const InputError& error) {
      EXPECT_EQ(error.code(), ExitCode::kEvaluation) << bad.name;
      EXPECT_NE(std::string(error.what()).find(bad.reason), std::string::npos)
          << bad.name << ": " << error.what();
    }
  }
}

TEST(Evaluate, OfTwoPosesHasRelativeFiguresOnly) {
  const PosePath two = winding_path(2);
  const Evaluation evaluation = evaluate(two, two);
  EXPECT_EQ(evaluation.matched, 2U);
  EXPECT_FALSE(evaluation.ate_se3_rmse_m.has_value());
  EXPECT_TRUE(mentions(evaluation, "Degenerate"));
}

TEST(ToPosePath, KeepsStampsAndPoses) {
  Trajectory trajectory;
  trajectory.frame = "left";
  trajectory.add(1'400'000'000'050'000'000, lie::SE3d::exp(lie::SE3d::Tangent::Constant(0.3)));
  const PosePath path = to_pose_path(trajectory);
  EXPECT_EQ(path.stamps_s, std::vector<double>{1400000000.05});
  EXPECT_EQ(path.frame, "left");
  expect_near(path.poses[0], trajectory.poses[0].matrix(), 0.0);
}

}  // namespace
}  // namespace imslam::evaluation
