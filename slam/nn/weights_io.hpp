#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "slam/nn/model_card.hpp"
#include "slam/nn/parameter.hpp"
#include "slam/nn/training/optimizer.hpp"
#include "slam/nn/weights_header.hpp"

namespace imslam::nn {

/// A weight file in memory, checked as a whole when it is made: the header (weights_header.hpp),
/// every number finite, the sha256 of the data where the metadata states one.
///
/// All errors are InputError(kModel) and name the file. Memory: the file, once; what the header
/// claims is held against the size of the file before anything is made for it.
class WeightsFile {
 public:
  static WeightsFile read(const std::filesystem::path& file);
  /// `name` stands in error messages.
  static WeightsFile parse(std::string name, std::string bytes);

  const std::string& name() const { return name_; }
  const std::vector<TensorEntry>& tensors() const { return header_.tensors; }
  const Metadata& metadata() const { return header_.metadata; }
  ModelCard card() const { return card_of(header_.metadata); }
  std::string data_sha256() const;

  const TensorEntry* find(std::string_view tensor) const;  ///< null if there is none
  /// Fills `numbers`, converting from the type in the file. Throws if the tensor is missing or of
  /// another shape.
  template <typename S>
  void read_into(const std::string& tensor, Tensor<S>& numbers) const;
  std::int64_t integer(const std::string& tensor) const;  ///< a tensor [1] of type I64

 private:
  std::string_view data() const { return std::string_view(bytes_).substr(data_start_); }

  std::string name_;
  std::string bytes_;
  std::size_t data_start_ = 0;
  WeightsHeader header_;
};

/// Collects tensors and writes them in the order of their names: equal contents, equal bytes.
class WeightsWriter {
 public:
  /// kF32 or kF16. Throws InputError(kModel) if a number is not finite, or too large for F16.
  void add(const std::string& name,
           const Tensor<float>& numbers,
           NumberType type = NumberType::kF32);
  void add(const std::string& name, const Tensor<double>& numbers);  ///< as F64
  void add(const std::string& name, std::int64_t number);            ///< as I64 [1]

  /// The whole file; the sha256 of the data is put into the metadata.
  std::string bytes(Metadata metadata) const;
  /// All or nothing: see write_file_atomic.
  void write(const std::filesystem::path& file, const Metadata& metadata) const;

 private:
  struct Piece {
    NumberType type;
    Shape shape;
    std::string bytes;
  };
  void add_piece(const std::string& name, Piece piece);

  std::map<std::string, Piece> pieces_;
};

/// All parameters under their names, with the card.
void save_parameters(const std::filesystem::path& file,
                     const ParameterList<float>& parameters,
                     const ModelCard& card,
                     NumberType type = NumberType::kF32);

/// Fills the parameters. Names every missing tensor, every one too many and every wrong shape in
/// the error, and then has changed nothing. `prefix` restricts to the tensors whose names start
/// with it.
void load_parameters(const WeightsFile& file,
                     const ParameterList<float>& parameters,
                     const std::string& prefix = "");

// The memory of an optimiser within a checkpoint, all names behind `prefix`.

template <typename S>
void add_state(WeightsWriter& writer, const std::string& prefix, const OptimizerState<S>& state);
template <typename S>
OptimizerState<S> state_of(const WeightsFile& file, const std::string& prefix);

}  // namespace imslam::nn
