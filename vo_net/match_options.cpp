#include "vo_net/match_options.hpp"

#include "vo_net/options_check.hpp"

namespace imslam::vo {

nn::Window MatchNetworkOptions::coarse_window(MatchKind kind) const {
  if (kind == MatchKind::kFlow) return nn::Window::square(flow_range);
  return {-stereo_range_left, stereo_range_right, -stereo_range_vertical, stereo_range_vertical, 1};
}

void MatchNetworkOptions::describe(Config& config) {
  config.field("half_channels", half_channels, "of the encoder and its features at 1/2");
  config.field("quarter_channels", quarter_channels, "of the encoder and its features at 1/4");
  config.field("eighth_channels", eighth_channels, "of the encoder and its features at 1/8");
  config.field("sixteenth_channels", sixteenth_channels, "of the encoder at 1/16");
  config.field("sixteenth_features", sixteenth_features, "of the features at 1/16");
  config.field("decoder_channels", decoder_channels, "of the coarse decoder's first two layers");
  config.field("decoder_features", decoder_features, "of the coarse decoder's third layer");
  config.field("head_channels", head_channels, "of the head's hidden layers");
  config.field("flow_range", flow_range, "search to each side [16 px]");
  config.field("stereo_range_left", stereo_range_left, "search along the row [16 px]");
  config.field("stereo_range_right", stereo_range_right, "search beyond infinity [16 px]");
  config.field("stereo_range_vertical", stereo_range_vertical, "search up and down [16 px]");
  config.field("fine_radius", fine_radius, "of the windows at 1/8, 1/4, 1/2 [cells]");
  config.section("normalisation", normalisation);
}

void MatchNetworkOptions::validate() const {
  const auto channels = [](const char* key, int value) {
    require(value >= 1 && value <= 4096, key, value, "1 .. 4096");
  };
  channels("half_channels", half_channels);
  channels("quarter_channels", quarter_channels);
  channels("eighth_channels", eighth_channels);
  channels("sixteenth_channels", sixteenth_channels);
  channels("sixteenth_features", sixteenth_features);
  channels("decoder_channels", decoder_channels);
  channels("decoder_features", decoder_features);
  channels("head_channels", head_channels);
  const auto range = [](const char* key, int value, int low) {
    require(value >= low && value <= 64, key, value, std::to_string(low) + " .. 64");
  };
  range("flow_range", flow_range, 1);
  range("stereo_range_left", stereo_range_left, 1);
  range("stereo_range_right", stereo_range_right, 0);
  range("stereo_range_vertical", stereo_range_vertical, 0);
  range("fine_radius", fine_radius, 1);
  normalisation.validate();
}

}  // namespace imslam::vo
