#pragma once

#include <string>

#include "slam/nn/weights_header.hpp"

namespace imslam::nn {

/// What one should know before using a weight file; travels in its metadata.
struct ModelCard {
  std::string what;     ///< the network and its task
  std::string data;     ///< what it was trained on
  std::string command;  ///< that makes it again
  std::string seed;
  std::string metrics;  ///< measured how, on what
  std::string limits;   ///< where it should not be trusted
  std::string parent;   ///< sha256 of the tensors of the file that it was fine-tuned from, or empty
  std::string sha256;   ///< of the tensor bytes: filled by the writer, checked by the reader
};

/// Under keys "card.what", ...; empty fields are left out.
void put_card(const ModelCard& card, Metadata& metadata);
ModelCard card_of(const Metadata& metadata);

/// For people.
std::string card_markdown(const ModelCard& card);

inline constexpr const char* kHashKey = "card.sha256";

}  // namespace imslam::nn
