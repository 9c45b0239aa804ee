#include "slam/base/progress.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <utility>

namespace imslam {
namespace {

constexpr std::chrono::milliseconds kMinimumInterval(100);
constexpr std::size_t kBarWidth = 30;

std::size_t terminal_width() {
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return 80;
  return size.ws_col;
}

std::string clock_text(double seconds) {
  const auto whole = static_cast<long>(seconds + 0.5);
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

}  // namespace

ProgressBar::ProgressBar(std::string label, bool enabled)
    : label_(std::move(label)),
      enabled_(enabled && isatty(STDERR_FILENO) == 1),
      start_(Clock::now()),
      last_print_(start_ - kMinimumInterval) {}

ProgressBar::~ProgressBar() { clear(); }

void ProgressBar::clear() {
  if (printed_) std::fputs("\r\033[K", stderr);
  printed_ = false;
}

void ProgressBar::update(std::size_t done, std::size_t total, const std::string& note) {
  const auto now = Clock::now();
  if (!enabled_ || now - last_print_ < kMinimumInterval) return;
  last_print_ = now;
  printed_ = true;
  const double elapsed_s = std::chrono::duration<double>(now - start_).count();
  const std::string text = line(label_, done, total, elapsed_s, note, terminal_width() - 1);
  std::fprintf(stderr, "\r\033[K%s", text.c_str());
  std::fflush(stderr);
}

std::string ProgressBar::line(const std::string& label,
                              std::size_t done,
                              std::size_t total,
                              double elapsed_s,
                              const std::string& note,
                              std::size_t width) {
  const double rate = elapsed_s > 0 ? static_cast<double>(done) / elapsed_s : 0.0;
  std::string text = label + " ";
  if (total > 0) {
    const std::size_t filled = std::min(kBarWidth, kBarWidth * done / total);
    text += "[" + std::string(filled, '#') + std::string(kBarWidth - filled, '.') + "] ";
    text += fmt::format("{}/{}", done, total);
  } else {
    text += fmt::format("{}", done);
  }
  text += fmt::format("  {:.1f}/s", rate);
  if (total > done && rate > 0) {
    text += "  left " + clock_text(static_cast<double>(total - done) / rate);
  }
  if (!note.empty()) text += "  " + note;
  return text.substr(0, width);
}

}  // namespace imslam
