#pragma once

#include <filesystem>
#include <string>
#include <utility>

namespace imslam::system {

/// Keeps other processes out of a folder while it lives, and however the process ends no longer.
class FolderLock {
 public:
  /// Makes `folder` if it is not there. Throws InputError(kOutput) if it cannot, or if another
  /// process holds it.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_ = -1;
};

/// Where a run writes. No other process gets the same place while this object lives.
///
/// A run that replaces an earlier one writes beside it and takes its place only in publish(): until
/// then, and whenever something fails, the earlier one stays as it was.
class RunFolder {
 public:
  RunFolder(RunFolder&& other) noexcept;
  RunFolder& operator=(RunFolder&&) = delete;
  ~RunFolder();

  /// Where to write now. Its last component is that of the final place.
  const std::filesystem::path& path() const { return path_; }

  /// Puts a complete run into its final place; path() from then on. Throws InputError(kOutput),
  /// which names where the run is.
  void publish();

 private:
  friend RunFolder make_run_folder(const std::filesystem::path& runs_root,
                                   const std::string& dataset,
                                   const std::filesystem::path& out,
                                   bool force);
  static RunFolder take(const std::filesystem::path& out, bool force);
  RunFolder(std::filesystem::path path, int lock) : path_(std::move(path)), lock_(lock) {}

  std::filesystem::path path_;
  std::filesystem::path replaced_;  ///< the earlier run; empty: none
  int lock_ = -1;                   ///< descriptor of the locked folder
};

/// Makes `runs_root`/<time>_<dataset>/ (local time, a number added if it exists), or takes `out` as
/// it is given. An existing non-empty `out` is refused unless it holds an earlier run and `force`,
/// and so is one that another run is writing to. Throws InputError(kOutput).
RunFolder make_run_folder(const std::filesystem::path& runs_root,
                          const std::string& dataset,
                          const std::filesystem::path& out = {},
                          bool force = false);

/// Points `folder`'s sibling `latest` to it; quietly does nothing where links are not possible.
void update_latest_link(const std::filesystem::path& folder);

/// Letters, digits, '-', '_' and '.' of `name`; everything else becomes '_'.
std::string safe_name(const std::string& name);

}  // namespace imslam::system
