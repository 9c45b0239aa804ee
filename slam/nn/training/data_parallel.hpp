#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "slam/nn/tape.hpp"

namespace imslam::nn {

/// Losses and gradients of a batch, sample by sample on several tapes side by side.
///
///   loss = 1/n sum_i l_i        gradient = 1/n sum_i dl_i/dw       i in order, whatever the
///   threads
///
/// Each sample has a tape of its own, so nothing is shared while they run; the sums and the
/// observations of batch norms are taken afterwards in the order of the samples. Hence equal bytes
/// for any number of threads and of tapes. The tapes keep their memory from batch to batch.
template <typename S>
class DataParallel {
 public:
  /// The loss of one sample, one number, on a fresh tape. Called from several threads at once: it
  /// reads the network and the data and writes nothing but the tape.
  using SampleLoss = std::function<Var(Tape<S>& tape, std::size_t sample)>;

  /// At most `tapes` samples run at a time; each tape holds the values of one.
  explicit DataParallel(ParameterList<S> parameters, int tapes = 4);

  /// Overwrites `gradients` (made by zero_gradients) and returns the mean loss.
  double run(std::size_t samples, const SampleLoss& loss, Gradients<S>& gradients);

 private:
  ParameterList<S> parameters_;
  std::vector<std::unique_ptr<Tape<S>>> tapes_;
  std::vector<double> losses_;
};

}  // namespace imslam::nn
