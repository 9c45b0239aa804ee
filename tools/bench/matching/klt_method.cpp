#include "tools/bench/matching/method.hpp"
#include "vo_net/klt_matcher.hpp"
#include "vo_net/patch_aligner.hpp"
#include "vo_net/stereo_matcher.hpp"

namespace imslam::bench {
namespace {

using vo::Alignment;
using vo::ImagePyramid;

class KltMethod final : public Method {
 public:
  std::vector<std::string> names(vo::MatchKind) const override { return {kKltName}; }

  std::vector<Answer> match(vo::MatchKind kind,
                            const GrayImage& image0,
                            const GrayImage& image1,
                            const std::vector<Eigen::Vector2d>& points) const override {
    const vo::KltOptions options = vo::KltOptions().for_width(image0.width);
    ImagePyramid from;
    ImagePyramid to;
    from.build(image0, options.levels, options.smoothing);
    to.build(image1, options.levels, options.smoothing);
    const vo::StereoMatcher stereo(options, from, to);
    Answer answer{kKltName, {}};
    for (const Eigen::Vector2d& point : points) {
      answer.matches.push_back(kind == vo::MatchKind::kFlow ? follow(options, from, to, point)
                                                            : search(stereo, point));
    }
    return {answer};
  }

 private:
  static PointMatch found(const Eigen::Vector2d& displacement, double variance) {
    PointMatch match;
    match.answered = match.accepted = true;
    match.score = -variance;
    match.displacement = displacement;
    return match;
  }

  static PointMatch follow(const vo::KltOptions& options,
                           const ImagePyramid& from,
                           const ImagePyramid& to,
                           const Eigen::Vector2d& point) {
    vo::AlignOptions align;
    align.window = options.window;
    align.smoothing = options.smoothing;
    const Alignment forth = align_patch(from, point, to, point, options.levels - 1, align, false);
    if (!forth.found || forth.correlation < options.min_correlation) return {};
    const Alignment back = align_patch(to, forth.position, from, point, 0, align, false);
    if (!back.found || (back.position - point).norm() > options.max_round_trip) return {};
    return found(forth.position - point, forth.covariance.trace());
  }

  static PointMatch search(const vo::StereoMatcher& stereo, const Eigen::Vector2d& point) {
    const std::optional<vo::Disparity> disparity = stereo.search(point);
    if (!disparity) return {};
    return found({-disparity->value, disparity->row_error}, disparity->variance);
  }
};

}  // namespace

std::unique_ptr<Method> make_klt() { return std::make_unique<KltMethod>(); }

}  // namespace imslam::bench
