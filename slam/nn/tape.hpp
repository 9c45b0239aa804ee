#pragma once

#include <new>
#include <type_traits>
#include <utility>
#include <vector>

#include "slam/nn/kernels/workspace.hpp"
#include "slam/nn/parameter.hpp"
#include "slam/nn/tensor.hpp"

namespace imslam::nn {

/// A name for one value on the tape. Cheap to copy; meaningless on another tape and after reset().
struct Var {
  int id = -1;
  explicit operator bool() const { return id >= 0; }  ///< false: "none", for optional inputs
};

enum class Mode {
  kTraining,   ///< records how to go back
  kInference,  ///< only values: no closures, no gradients, dropout off, statistics frozen
};

/// Records values in the order they are computed, so that backward() is one walk from end to start.
///
///   forward    y_k = f_k(earlier y)              an entry reads earlier ones only: no graph search
///   backward   dL/dy_j += (df_k/dy_j)^T dL/dy_k  for k from the last to the first
///
/// Everything (values, closures, gradients) lives in two arenas that reset() rewinds: the first
/// frame allocates, the next ones do not. Gradients of parameters stay on the tape, see Parameter.
/// One thread per tape. Parameters must outlive the tape's use and must not change between the two
/// passes.
template <typename S>
class Tape {
 public:
  explicit Tape(Mode mode = Mode::kTraining) : mode_(mode) {}
  Tape(const Tape&) = delete;  // pull-backs run on the tape that recorded them
  Tape& operator=(const Tape&) = delete;

  Mode mode() const { return mode_; }
  bool training() const { return mode_ == Mode::kTraining; }

  /// Forgets all values and gradients, keeps the memory.
  void reset();

  // Leaves. Numbers are copied, except those of parameters and borrowed ones.
  Var constant(const Shape& shape, const S* numbers);
  Var constant(const Tensor<S>& numbers) { return constant(numbers.shape(), numbers.data()); }
  /// A value of another tape that stays where it is, as a constant: valid until that is reset.
  Var borrow(const Tape& owner, Var v);
  Var input(const Tensor<S>& numbers);  ///< a constant whose gradient is wanted
  Var parameter(const Parameter<S>& parameter);

  // What was computed.
  Shape shape(Var v) const { return entry(v).shape; }
  S* data(Var v) { return entry(v).value; }
  const S* data(Var v) const { return entry(v).value; }
  ArrayMap<S> array(Var v) { return {entry(v).value, entry(v).shape.size()}; }
  MatrixMap<S> matrix(Var v) {  ///< rows() x channels()
    return {entry(v).value, entry(v).shape.rows(), entry(v).shape.channels()};
  }
  Tensor<S> copy(Var v) const;
  /// The only number of a value of size 1, e.g. a loss.
  S number(Var v) const;

  /// Sends `seed` = dL/d(output) back to everything that the output depends on. Gradients add up
  /// over calls until clear_gradients() or reset().
  void backward(Var output, const Tensor<S>& seed);
  void backward(Var loss);  ///< the same with seed 1; loss has one number
  void clear_gradients();

  bool wants_gradient(Var v) const { return v && entry(v).tracked; }
  S* gradient_data(Var v);  ///< zeros if nothing has arrived
  ArrayMap<S> gradient(Var v) { return {gradient_data(v), entry(v).shape.size()}; }
  MatrixMap<S> gradient_matrix(Var v) {
    return {gradient_data(v), entry(v).shape.rows(), entry(v).shape.channels()};
  }
  /// Adds the gradients of this tape to those of a list of parameters.
  void add_gradients_to(const ParameterList<S>& parameters, Gradients<S>& sums);

  // For operations.

  /// A new value; its numbers are for the caller to fill.
  Var make(const Shape& shape);
  /// Another shape for the same numbers.
  Var alias(Var v, const Shape& shape);

  /// Notes how the gradient of y goes back to its inputs ("none" inputs are allowed).
  /// pull_back(tape) reads gradient(y) and adds to the gradients of the inputs. It is kept in the
  /// arena and never destroyed, so it captures only plain values and pointers into the arena (see
  /// keep()).
  template <typename PullBack>
  Var record(Var y, std::initializer_list<Var> inputs, const PullBack& pull_back) {
    return record(y, inputs.begin(), inputs.size(), pull_back);
  }
  template <typename PullBack>
  Var record(Var y, const Var* inputs, std::size_t count, const PullBack& pull_back) {
    static_assert(std::is_trivially_destructible_v<PullBack>);
    bool tracked = false;
    for (std::size_t i = 0; i < count; ++i) tracked = tracked || wants_gradient(inputs[i]);
    if (!tracked || !training()) return y;
    expects(open_scratches_ == 0,
            "Tape::record: a Scratch is open, its end would free the closure");
    Entry& noted = entry(y);
    noted.tracked = true;
    noted.closure = new (values_.allocate(sizeof(PullBack))) PullBack(pull_back);
    noted.pull_back = [](const void* closure, Tape& tape) {
      (*static_cast<const PullBack*>(closure))(tape);
    };
    return y;
  }

  /// In a pull-back: add(dX) adds to the gradient of x, if it is wanted.
  template <typename Add>
  void accumulate(Var x, const Add& add) {
    if (wants_gradient(x)) add(gradient(x));
  }
  /// In a pull-back of a function that changes no number: dX += dY. The first to arrive lends its
  /// memory instead of copying, so dY is not for reading afterwards.
  void pass_on(Var y, Var x) {
    if (!wants_gradient(x)) return;
    if (entry(x).gradient == nullptr) {
      entry(x).gradient = gradient_data(y);
    } else {
      gradient(x) += gradient(y);
    }
  }
  /// Like accumulate() for kernels that overwrite all of S* dX: the first one writes in place.
  template <typename Overwrite>
  void accumulate_overwriting(Var x, const Overwrite& overwrite) {
    if (!wants_gradient(x)) return;
    Entry& e = entry(x);
    if (e.gradient == nullptr) {
      e.gradient = gradients_.template allocate_array<S>(e.shape.size());
      overwrite(e.gradient);
      return;
    }
    const Arena::Mark mark = gradients_.mark();
    S* const piece = gradients_.template allocate_array<S>(e.shape.size());
    overwrite(piece);
    gradient(x) += ArrayMap<S>(piece, e.shape.size());
    gradients_.rewind(mark);
  }

  /// `count` plain numbers that live as long as the values, e.g. indices for a pull-back.
  template <typename T>
  T* keep(Index count) {
    static_assert(std::is_trivially_destructible_v<T>);
    expects(open_scratches_ == 0, "Tape::keep: a Scratch is open, its end would free the numbers");
    return values_.template allocate_array<T>(count);
  }

  Workspace* workspace() { return &workspace_; }  ///< scratch of the convolution kernels

  /// A statistic of this sample that apply_observations() will blend into a parameter:
  ///   target <- (1 - rate) target + rate value
  void observe(Parameter<S>& target, Var value, double rate);
  /// Done after backward, tape by tape in order: parameters never change while samples run.
  void apply_observations();

 private:
  template <typename>
  friend class Scratch;

  struct Entry {
    Shape shape;
    S* value = nullptr;
    S* gradient = nullptr;
    bool tracked = false;
    const void* closure = nullptr;
    void (*pull_back)(const void* closure, Tape& tape) = nullptr;
  };
  struct Observation {
    Parameter<S>* target;
    Var value;
    double rate;
  };
  struct KnownParameter {
    const Parameter<S>* parameter;
    Var var;
  };

  Entry& entry(Var v) { return entries_[static_cast<std::size_t>(checked(v))]; }
  const Entry& entry(Var v) const { return entries_[static_cast<std::size_t>(checked(v))]; }
  int checked(Var v) const {
    expects(v.id >= 0 && v.id < static_cast<int>(entries_.size()), "Tape: a value of another tape");
    return v.id;
  }
  Var append(const Shape& shape, S* value, bool tracked);

  Mode mode_;
  std::vector<Entry> entries_;
  std::vector<KnownParameter> parameters_;  ///< sorted by address, so that each is entered once
  std::vector<Observation> observations_;
  Arena values_;
  Arena gradients_;
  Workspace workspace_;
  int open_scratches_ = 0;
};

/// Memory of the tape that is free again at the end of the scope. No value may be made meanwhile.
template <typename S>
class Scratch {
 public:
  explicit Scratch(Tape<S>& tape) : tape_(tape), mark_(tape.values_.mark()) {
    ++tape_.open_scratches_;
  }
  ~Scratch() {
    --tape_.open_scratches_;
    tape_.values_.rewind(mark_);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  template <typename T>
  T* array(Index count) {
    return tape_.values_.template allocate_array<T>(count);
  }
  /// `count` zeros.
  template <typename T>
  T* zeros(Index count) {
    T* const numbers = array<T>(count);
    std::uninitialized_fill_n(numbers, count, T(0));
    return numbers;
  }

 private:
  Tape<S>& tape_;
  Arena::Mark mark_;
};

}  // namespace imslam::nn
