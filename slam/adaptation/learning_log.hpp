#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace imslam::adaptation {

/// The curves of a fine-tuning, one entry per look at the networks; NaN: not known.
struct LearningLog {
  std::vector<double> epoch;                          ///< 0: the given networks
  std::map<std::string, std::vector<double>> curves;  ///< by EpochScores::columns(), and
                                                      ///< "held_out_loss"
};

/// Reads log.csv of learner::run_training(). Throws InputError "file:line: ..." if it is no such
/// file.
LearningLog read_learning_log(const std::filesystem::path& file, int steps_per_epoch);

}  // namespace imslam::adaptation
