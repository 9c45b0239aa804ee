#include "app/provenance.hpp"

#include "app/version.hpp"

namespace imslam::app {

system::RunProvenance provenance_of(const Settings& settings,
                                    const datasets::Sequence& sequence,
                                    const CommonOptions& common) {
  system::RunProvenance result;
  result.version = version_text();
  result.git_hash = git_hash();
  result.command_line = common.command_line;
  result.seed = static_cast<std::uint64_t>(settings.slam().system.seed);
  result.config_yaml = settings.config().to_yaml();
  result.input_files = sequence.input_files();
  return result;
}

}  // namespace imslam::app
