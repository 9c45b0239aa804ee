#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "app/command.hpp"
#include "slam/base/file.hpp"
#include "slam/nn/weights_io.hpp"

namespace imslam::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kModelExamples =
    "Examples:\n"
    "  imslam model info vo_net.safetensors             model card and tensors\n"
    "  imslam model info vo_net.safetensors --json\n"
    "  imslam model verify vo_net.safetensors           exit code 5 if anything is wrong with it";

struct ModelArguments {
  std::string file;
  bool json = false;
};

std::int64_t number_count(const nn::WeightsFile& file) {
  std::int64_t sum = 0;
  for (const nn::TensorEntry& tensor : file.tensors()) sum += tensor.shape.size();
  return sum;
}

Json shape_list(const nn::Shape& shape) {
  Json list = Json::array();
  for (int axis = 0; axis < shape.rank(); ++axis) list.push_back(shape[axis]);
  return list;
}

void print_json(const nn::WeightsFile& file) {
  Json tensors = Json::array();
  for (const nn::TensorEntry& tensor : file.tensors()) {
    tensors.push_back({{"name", tensor.name},
                       {"dtype", nn::name_of(tensor.type)},
                       {"shape", shape_list(tensor.shape)},
                       {"bytes", tensor.end - tensor.begin}});
  }
  const Json json{{"file", file.name()},
                  {"numbers", number_count(file)},
                  {"data_sha256", file.data_sha256()},
                  {"metadata", file.metadata()},
                  {"tensors", tensors}};
  fmt::print("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace));
}

void print_text(const nn::WeightsFile& file) {
  fmt::print("{}\n# Tensors\n\n", nn::card_markdown(file.card()));
  std::size_t widest = 0;
  for (const nn::TensorEntry& tensor : file.tensors()) {
    widest = std::max(widest, tensor.name.size());
  }
  for (const nn::TensorEntry& tensor : file.tensors()) {
    fmt::print("  {:<{}}  {:<4} {}\n", tensor.name, widest, nn::name_of(tensor.type),
               tensor.shape.text());
  }
  fmt::print("\n{} tensors, {} numbers\n", file.tensors().size(), number_count(file));
}

ExitCode info(const ModelArguments& arguments) {
  const auto file = nn::WeightsFile::read(arguments.file);
  if (arguments.json) {
    print_json(file);
  } else {
    print_text(file);
  }
  return ExitCode::kOk;
}

/// Reading checks everything; without a hash in the metadata there is nothing to hold the data
/// against.
ExitCode verify(const ModelArguments& arguments) {
  const auto file = nn::WeightsFile::read(arguments.file);
  if (file.card().sha256.empty()) {
    throw InputError(file.name() + ": well formed, but states no sha256 (metadata '" +
                         nn::kHashKey + "'): whether the numbers are the right ones is unknown; " +
                         "write the file with this program",
                     ExitCode::kModel);
  }
  fmt::print("{}: ok, {} tensors, {} numbers, sha256 {}\n", file.name(), file.tensors().size(),
             number_count(file), file.data_sha256());
  return ExitCode::kOk;
}

}  // namespace

void add_model_command(CLI::App& app, Action& action) {
  auto* command = app.add_subcommand("model", "Show or check a weight file");
  command->footer(kModelExamples);
  command->require_subcommand(1);
  auto arguments = std::make_shared<ModelArguments>();

  auto* show = command->add_subcommand("info", "Print the model card and the tensors");
  show->add_option("file", arguments->file, "Weight file (.safetensors)")->required();
  show->add_flag("--json", arguments->json, "Print as JSON");
  show->callback([&action, arguments] { action = [arguments] { return info(*arguments); }; });

  auto* check = command->add_subcommand("verify", "Check layout, numbers and sha256");
  check->add_option("file", arguments->file, "Weight file (.safetensors)")->required();
  check->callback([&action, arguments] { action = [arguments] { return verify(*arguments); }; });
}

}  // namespace imslam::app
