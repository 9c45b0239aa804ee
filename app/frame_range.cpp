#include "app/frame_range.hpp"

#include <fmt/format.h>

#include "slam/base/error.hpp"
#include "slam/base/text.hpp"

namespace imslam::app {

void parse_frames(const std::string& text, system::RunRequest& request) {
  if (text.empty()) return;
  const auto parts = split(text, ':');
  const auto number = [&](std::string_view part) -> std::size_t {
    if (trim(part).empty()) return 0;
    const auto value = parse_int64(part);
    if (!value || *value < 0) {
      throw InputError(fmt::format("--frames: expected A:B with whole numbers, got '{}'", text),
                       ExitCode::kUsage);
    }
    return static_cast<std::size_t>(*value);
  };
  if (parts.size() != 2) number("?");
  request.first_frame = number(parts[0]);
  request.last_frame = number(parts[1]);
  if (request.last_frame == 0 && !trim(parts[1]).empty()) {
    throw InputError(fmt::format("--frames {}: no frame lies before frame 0", text),
                     ExitCode::kUsage);
  }
}

}  // namespace imslam::app
