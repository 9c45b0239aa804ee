#pragma once

#include <stdexcept>
#include <string>

namespace imslam {

/// What the executable returns to the shell; documented in `imslam --help` and the README.
enum class ExitCode : int {
  kOk = 0,
  kInternal = 1,       ///< a bug: please report
  kUsage = 2,          ///< command line or configuration
  kData = 3,           ///< input data invalid
  kCalibration = 4,    ///< calibration invalid
  kModel = 5,          ///< model file invalid
  kOutput = 6,         ///< output could not be written
  kTrackingLost = 7,   ///< lost or diverged; partial results are written
  kEvaluation = 8,     ///< evaluation impossible: no matches, degenerate
  kResource = 9,       ///< memory or another limit reached
  kWarnings = 10,      ///< `check --strict`: warnings only
  kInterrupted = 130,  ///< stopped by a signal, the state is saved; the shell gets 128 + its number
};

/// The caller broke a contract (wrong shape, out-of-order call). A bug: never caught, only
/// reported.
class ContractError : public std::logic_error {
  using std::logic_error::logic_error;
};

/// A file, config key or command line the user can fix. The message says where, what was
/// expected and what to do: "file:line: expected ...; do ...".
class InputError : public std::runtime_error {
 public:
  explicit InputError(const std::string& message, ExitCode code = ExitCode::kData)
      : std::runtime_error(message), code_(code) {}

  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

/// Always on, also in Release: a wrong shape must not become a wrong trajectory.
inline void expects(bool condition, const char* what) {
  if (!condition) throw ContractError(what);
}

}  // namespace imslam
