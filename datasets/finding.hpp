#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "slam/base/error.hpp"

namespace imslam::datasets {

enum class Severity { kInfo, kWarning, kError };

/// One thing that `imslam check` has to say about a recording.
struct Finding {
  Severity severity = Severity::kInfo;
  std::string file;      ///< empty: about the sequence as a whole
  std::size_t line = 0;  ///< from 1; 0: about the whole file
  std::string what;
  std::string remedy;             ///< empty where there is nothing to do
  ExitCode code = ExitCode::kOk;  ///< for errors: kData or kCalibration
};

/// "error: file:line: what; remedy".
std::string to_text(const Finding& finding);

/// Collects findings in the order in which they are made.
class Findings {
 public:
  /// From now on warnings and errors that name no file are about this one.
  void about(const std::string& file) { file_ = file; }

  void info(const std::string& what, const std::string& file = "");
  void warn(const std::string& what,
            const std::string& remedy,
            const std::string& file = "",
            std::size_t line = 0);
  void fail(ExitCode code,
            const std::string& what,
            const std::string& remedy,
            const std::string& file = "",
            std::size_t line = 0);
  /// Takes an InputError's "file:line:column: what; remedy" apart.
  void fail(const InputError& error);
  void add(Finding finding) { all_.push_back(std::move(finding)); }

  const std::vector<Finding>& all() const { return all_; }

 private:
  std::string file_;
  std::vector<Finding> all_;
};

}  // namespace imslam::datasets
