#pragma once

#include <filesystem>
#include <string>

#include "slam/adaptation/finetune.hpp"

namespace imslam::adaptation {

/// How a fine-tuning was asked for, for its metrics.
struct FinetuneProvenance {
  std::string dataset;
  std::string data_sha256;
  std::string version;  ///< of the program
  std::string command;  ///< as typed
};

/// Writes `folder`/metrics.json, report.html and learning.svg of a finished fine-tuning:
///
///   results   {zero_shot, batch_adapted, online_adapted}: EpochScores, null what is not known;
///             means over the sequences
///   sequences [{name, frames, zero_shot, batch_adapted, device {fingerprint, before, after}}]
///   guard     {on, gained, verdict, text, loss_before, loss_after}
///   epochs    {wanted, done}; steps, skipped_steps, left_out
///   curves    {epoch, held_out_loss, ...}: log.csv by columns
///   agreement [{error, name, looks, rank_correlation, verdict, text, ...}]
///   models    [model cards of `weights`, with name and file]
///
/// Every file is written all or not. Throws InputError(kOutput).
void record_finetune(const std::filesystem::path& folder,
                     const FinetuneOutcome& outcome,
                     const AdaptationOptions& options,
                     const FinetuneProvenance& provenance);

/// What became of the given weights, in one sentence.
std::string guard_text(const FinetuneOutcome& outcome);

}  // namespace imslam::adaptation
