#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "app/command.hpp"
#include "app/eval_request.hpp"
#include "datasets/trajectory_file.hpp"
#include "slam/base/file.hpp"
#include "slam/base/log.hpp"
#include "slam/base/text.hpp"
#include "slam/evaluation/rigid_matrix.hpp"

namespace imslam::app {
namespace {

constexpr const char* kEvalExamples =
    "Files: TUM (time_s tx ty tz qx qy qz qw), KITTI (3x4 per line), EuRoC (csv, ns); found by\n"
    "themselves. Figures are those of evo and of the KITTI devkit. Exit code 8: impossible.\n"
    "\n"
    "Examples:\n"
    "  imslam eval truth.tum estimate.tum                   all figures in one table\n"
    "  imslam eval truth.tum estimate.tum --metric ape --align se3 --json\n"
    "  imslam eval truth.csv estimate.tum --metric rpe --delta 1 --unit meters --all-pairs\n"
    "  imslam eval poses/00.txt 00.txt --metric kitti       t_rel, r_rel\n"
    "  imslam eval truth.tum est.tum --metric ape --align se3 --save-zip est.zip   (for evo_res)\n"
    "  imslam eval truth.tum camera.tum --T-body-eval \"0.1 0 0 0 0 0 1\"            another frame";

[[noreturn]] void fail_usage(const std::string& message) {
  throw InputError(message, ExitCode::kUsage);
}

/// "tx ty tz qx qy qz qw", or the 12 or 16 numbers of a matrix row by row, in a file or as they
/// are.
Eigen::Matrix4d parse_transform(const std::string& given) {
  std::string text = given;
  std::error_code none;
  if (std::filesystem::is_regular_file(given, none)) text = read_file(given, 1U << 16U);
  for (char& c : text) {
    if (c == ',' || c == '\n' || c == '[' || c == ']' || c == ';') c = ' ';
  }
  std::vector<double> n;
  for (const std::string_view word : split_blanks(text)) {
    const auto number = parse_double(word);
    if (!number) fail_usage("--T-body-eval: '" + std::string(word) + "' is not a number");
    n.push_back(*number);
  }
  if (n.size() == 7) {
    const Eigen::Quaterniond q(n[6], n[3], n[4], n[5]);
    if (!(q.norm() > 1e-6)) fail_usage("--T-body-eval: the quaternion is zero");
    return evaluation::rigid(q.normalized().toRotationMatrix(), {n[0], n[1], n[2]});
  }
  if (n.size() != 12 && n.size() != 16) {
    fail_usage(
        "--T-body-eval: expected 7 numbers (tx ty tz qx qy qz qw) or a matrix of 12 or 16, "
        "found " +
        std::to_string(n.size()));
  }
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  T.topRows<3>() = Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(n.data());
  return T;
}

/// The yaw axis: KITTI worlds are those of the first camera, y down; all others have z up.
Eigen::Vector3d vertical_of(const std::string& name, const PosePath& path) {
  if (name == "x") return Eigen::Vector3d::UnitX();
  if (name == "y") return Eigen::Vector3d::UnitY();
  if (name == "auto" && !path.has_stamps()) return -Eigen::Vector3d::UnitY();
  return Eigen::Vector3d::UnitZ();
}

ExitCode evaluate_files(EvalRequest request) {
  const Paths paths = {datasets::read_trajectory(request.reference),
                       datasets::read_trajectory(request.estimate)};
  if (!request.T_body_eval.empty()) {
    request.options.T_body_eval = parse_transform(request.T_body_eval);
  }
  request.options.up_reference = vertical_of(request.vertical, paths.reference);
  request.options.up_estimate = vertical_of(request.vertical, paths.estimate);
  request.figure.alignment.up_reference = request.options.up_reference;
  request.figure.alignment.up_estimate = request.options.up_estimate;
  request.figure.relative = request.metric == "rpe";
  return report_evaluation(request, paths);
}

}  // namespace

void add_eval_command(CLI::App& app, Action& action) {
  auto* eval = app.add_subcommand("eval", "Compare a trajectory with a reference");
  eval->footer(kEvalExamples);
  auto request = std::make_shared<EvalRequest>();
  eval->add_option("reference", request->reference, "Ground truth")->required();
  eval->add_option("estimate", request->estimate, "Trajectory to be judged")->required();
  add_eval_options(*eval, *request);
  eval->callback([&action, request, eval] {
    action = [request, eval] {
      if (request->metric.empty()) {
        for (const char* name :
             {"--align", "--align-first", "--relation", "--delta", "--unit", "--all-pairs",
              "--delta-tol", "--pairs-from-reference", "--project"}) {
          if (eval->count(name) > 0) log::warn("{} has an effect only with --metric", name);
        }
      }
      return evaluate_files(*request);
    };
  });
}

}  // namespace imslam::app
