#include "slam/nn/model_card.hpp"

#include <array>

namespace imslam::nn {
namespace {

struct Field {
  const char* key;
  const char* title;
  std::string ModelCard::*text;
};

constexpr std::array<Field, 8> kFields{{
    {"card.what", "What", &ModelCard::what},
    {"card.data", "Training data", &ModelCard::data},
    {"card.command", "Command", &ModelCard::command},
    {"card.seed", "Seed", &ModelCard::seed},
    {"card.metrics", "Metrics", &ModelCard::metrics},
    {"card.limits", "Limits", &ModelCard::limits},
    {"card.parent", "Fine-tuned from (sha256)", &ModelCard::parent},
    {kHashKey, "Tensors (sha256)", &ModelCard::sha256},
}};

}  // namespace

void put_card(const ModelCard& card, Metadata& metadata) {
  for (const Field& field : kFields) {
    if (!(card.*field.text).empty()) metadata[field.key] = card.*field.text;
  }
}

ModelCard card_of(const Metadata& metadata) {
  ModelCard card;
  for (const Field& field : kFields) {
    const auto found = metadata.find(field.key);
    if (found != metadata.end()) card.*field.text = found->second;
  }
  return card;
}

std::string card_markdown(const ModelCard& card) {
  std::string text = "# Model card\n";
  for (const Field& field : kFields) {
    const std::string& said = card.*field.text;
    text +=
        std::string("\n**") + field.title + ":** " + (said.empty() ? "not stated" : said) + "\n";
  }
  return text;
}

}  // namespace imslam::nn
