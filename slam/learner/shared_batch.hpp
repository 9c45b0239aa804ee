#pragma once

#include "slam/base/process_group.hpp"
#include "slam/learner/training_record.hpp"
#include "slam/nn/training/data_parallel.hpp"
#include "slam/nn/training/gradients.hpp"

namespace imslam::learner {

/// A batch that several processes share out among themselves: `parts` parts of equal size, part p
/// belongs to rank p % size.
///
///   gradient = 1/parts sum_p gradient_p,  p in order       loss likewise
///
/// on all ranks: equal bytes for any number of them, of threads and of tapes. Collective.
/// `loss` is only called for slots of parts that are this rank's own.
double shared_batch(ProcessGroup& group,
                    nn::DataParallel<float>& batch,
                    std::size_t samples,
                    std::size_t parts,
                    const nn::DataParallel<float>::SampleLoss& loss,
                    nn::Gradients<float>& gradients);

/// What came of the samples of all ranks. Collective.
BatchTally shared_tally(ProcessGroup& group, const BatchTally& own);

}  // namespace imslam::learner
