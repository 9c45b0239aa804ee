#include "vo_net/disparity_offset.hpp"

#include <algorithm>
#include <cmath>

#include "vo_net/options_check.hpp"

namespace imslam::vo {
namespace {

constexpr std::size_t kMaxBlocks = 1000;  // memory does not grow with the sequence
constexpr double kMinInformation = 1e-9;  // [1/px^2] a frame at rest says nothing
constexpr int kRounds = 20;

struct Reading {
  double value;
  double variance;
  double shared;  // standard deviation of the error that all readings share
};

/// Weighted mean of the readings.
struct Mean {
  double value = 0.0;
  double variance = 0.0;
};

double huber_weight(double normalised, double width) {
  const double size = std::abs(normalised);
  return size <= width ? 1.0 : width / size;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<double> weights_around_median(const std::vector<Reading>& readings, double width) {
  std::vector<double> values;
  for (const Reading& r : readings) values.push_back(r.value);
  const double center = median(values);
  for (double& v : values) v = std::abs(v - center);
  const double scale = std::max(1.4826 * median(values), 1e-9);  // of a normal distribution
  std::vector<double> weights;
  for (const Reading& r : readings) {
    weights.push_back(huber_weight((r.value - center) / scale, width));
  }
  return weights;
}

/// Variance between readings beyond their own, by the method of moments on weighted deviations.
double between_variance(const std::vector<Reading>& readings, const std::vector<double>& weights) {
  double sum = 0.0;
  double squares = 0.0;
  double mean = 0.0;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const double w = weights[i] / readings[i].variance;
    sum += w;
    squares += w * w;
    mean += w * readings[i].value;
  }
  mean /= sum;
  double q = 0.0;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    q += std::pow(weights[i] * (readings[i].value - mean), 2) / readings[i].variance;
  }
  const double denominator = sum - squares / sum;
  const double freedom = static_cast<double>(readings.size()) - 1.0;
  return denominator > 0.0 ? std::max(0.0, (q - freedom) / denominator) : 0.0;
}

Mean mean_of(const std::vector<Reading>& readings,
             const std::vector<double>& weights,
             double tau2) {
  double sum = 0.0;
  double shared = 0.0;
  double information = 0.0;
  Mean mean;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const Reading& r = readings[i];
    const double own = weights[i] / (r.variance + tau2);
    const double w = weights[i] / (r.variance + tau2 + r.shared * r.shared);
    information += own;
    sum += w;
    shared += w * r.shared;
    mean.value += w * r.value;
  }
  mean.value /= sum;
  mean.variance = 1.0 / information + std::pow(shared / sum, 2);
  return mean;
}

/// What one normal prior leaves of what was measured, and how well it foretold that.
struct Posterior {
  double value;
  double variance;
  double log_evidence;
};

Posterior with_normal(const Mean& measured, double prior, double sigma) {
  const double total = measured.variance + sigma * sigma;
  const double difference = measured.value - prior;
  return {prior + difference * sigma * sigma / total, measured.variance * sigma * sigma / total,
          -0.5 * (difference * difference / total + std::log(total))};
}

/// What the mixture of priors leaves of it: mean and variance.
Mean with_prior(const Mean& measured, const DisparityOffsetOptions& options) {
  const Posterior exact = with_normal(measured, options.prior, options.exact_sigma);
  const Posterior other = with_normal(measured, options.prior, options.prior_sigma);
  const double odds = std::exp(std::min(other.log_evidence - exact.log_evidence, 700.0));
  const double share = options.exact / (options.exact + (1.0 - options.exact) * odds);
  Mean left;
  left.value = share * exact.value + (1.0 - share) * other.value;
  left.variance = share * exact.variance + (1.0 - share) * other.variance +
                  share * (1.0 - share) * std::pow(exact.value - other.value, 2);
  return left;
}

}  // namespace

RelativeMotion with_disparity_offset(const RelativeMotion& motion, double offset_px) {
  RelativeMotion corrected = motion;
  const double change = offset_px - motion.disparity_offset;
  corrected.T_body0_body1 =
      motion.T_body0_body1 * lie::SE3d::exp(motion.J_disparity_offset * change);
  corrected.disparity_offset = offset_px;
  return corrected;
}

void DisparityOffsetOptions::describe(Config& config) {
  config.field("block", block, "frames averaged before the scatter is judged");
  config.field("prior", prior, "offset to expect [px]");
  config.field("prior_sigma", prior_sigma, "how far from that it may be [px]");
  config.field("exact", exact, "share of cameras whose rectification is exact");
  config.field("exact_sigma", exact_sigma, "to this [px]");
  config.field("systematic", systematic,
               "error that all frames share, of what one point alone would have");
  config.field("kernel_width", kernel_width, "blocks beyond count less [standard deviations]");
}

void DisparityOffsetOptions::validate() const {
  require(block >= 1, "vo.offset.block", block, ">= 1");
  require(std::isfinite(prior), "vo.offset.prior", prior, "finite");
  require(prior_sigma > 0.0, "vo.offset.prior_sigma", prior_sigma, "> 0");
  require(exact >= 0.0 && exact <= 1.0, "vo.offset.exact", exact, "0 .. 1");
  require(exact_sigma > 0.0, "vo.offset.exact_sigma", exact_sigma, "> 0");
  require(systematic >= 0.0 && systematic <= 1.0, "vo.offset.systematic", systematic, "0 .. 1");
  require(kernel_width > 0.0, "vo.offset.kernel_width", kernel_width, "> 0");
}

void DisparityOffsetEstimator::add(const PoseLayerResult& result) {
  if (!result.valid || !(result.offset_information > kMinInformation)) return;
  if (frames_per_block_ == 0) frames_per_block_ = options_.block;
  if (blocks_.empty() || blocks_.back().frames >= frames_per_block_) {
    if (blocks_.size() == kMaxBlocks) merge_pairs();
    blocks_.emplace_back();
  }
  const double h = result.offset_information;
  Block& block = blocks_.back();
  block.information += h;
  block.weighted += h * result.disparity_offset - result.offset_gradient;
  block.points += static_cast<double>(result.inliers);
  ++block.frames;
  ++frames_;
}

void DisparityOffsetEstimator::merge_pairs() {
  std::vector<Block> merged;
  for (std::size_t i = 0; i + 1 < blocks_.size(); i += 2) {
    merged.push_back({blocks_[i].information + blocks_[i + 1].information,
                      blocks_[i].weighted + blocks_[i + 1].weighted,
                      blocks_[i].points + blocks_[i + 1].points,
                      blocks_[i].frames + blocks_[i + 1].frames});
  }
  blocks_ = std::move(merged);
  frames_per_block_ *= 2;
}

DisparityOffsetEstimate DisparityOffsetEstimator::estimate() const {
  DisparityOffsetEstimate estimate;
  estimate.offset_px = options_.prior;
  estimate.sigma_px = options_.prior_sigma;
  estimate.frames = frames_;
  if (blocks_.size() < 2) return estimate;  // scatter cannot be judged

  std::vector<Reading> readings;
  for (const Block& b : blocks_) {
    readings.push_back({b.weighted / b.information, 1.0 / b.information,
                        options_.systematic * std::sqrt(b.points / b.information)});
  }
  std::vector<double> weights = weights_around_median(readings, options_.kernel_width);
  Mean mean;
  for (int round = 0; round < kRounds; ++round) {
    const double tau2 = between_variance(readings, weights);
    mean = mean_of(readings, weights, tau2);
    for (std::size_t i = 0; i < readings.size(); ++i) {
      const double deviation =
          (readings[i].value - mean.value) / std::sqrt(readings[i].variance + tau2);
      weights[i] = huber_weight(deviation, options_.kernel_width);
    }
  }
  mean = with_prior(mean, options_);
  estimate.offset_px = mean.value;
  estimate.sigma_px = std::sqrt(mean.variance);
  estimate.frames = frames_;
  return estimate;
}

}  // namespace imslam::vo
