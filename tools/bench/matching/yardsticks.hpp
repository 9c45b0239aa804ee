#pragma once

#include <filesystem>
#include <vector>

#include "tools/bench/matching/scene.hpp"

namespace imslam::bench {

// Readers of excerpts of public data sets: yardsticks for matchers, never input of the program.
// Each gives at most `frames` scenes, evenly spread over what is there, and throws InputError where
// a file is missing or not what it should be.

/// TartanAir V2, one trajectory, camera "front": disparity and flow. Wang et al., IROS 2020.
///
///   image_{l,r}cam_front/NNNNNN_{l,r}cam_front.png     fx = fy = 320 px, baseline 0.25 m
///   depth_lcam_front/NNNNNN_lcam_front_depth.png       4 x 8 bit, the bytes of one float32 [m] in
///                                                      OpenCV's order of the channels
///   flow_lcam_front/NNNNNN_MMMMMM_flow.png             16 bit, (value - 32768) / 64 px; in
///   OpenCV's
///                                                      order u, v, mask (0: valid)
/// The last image has no successor: its flow is not known. Occlusion: mark_hidden().
std::vector<MatchScene> read_tartanair(const std::filesystem::path& folder, int frames);

/// KITTI 2012 stereo: disparity of the points that both cameras see. Geiger et al., CVPR 2012.
///
///   image_{0,1}/NNNNNN_10.png, disp_noc/NNNNNN_10.png  16 bit, value / 256 px, 0: not known
std::vector<MatchScene> read_kitti2012(const std::filesystem::path& folder, int frames);

/// Middlebury optical flow: flow. Baker et al., IJCV 2011.
///
///   NAME/frame10.png, NAME/frame11.png, NAME/flow10.flo (above 1e9: not known)
/// Occlusion: mark_hidden().
std::vector<MatchScene> read_middlebury(const std::filesystem::path& folder, int frames);

/// A EuRoC folder of `imslam simulate` with truth_depth and truth_flow: disparity and flow of the
/// rectified views. The truth is that of the raw left pixel, carried to the rectified one where the
/// four raw pixels around belong to one surface; elsewhere it is not known. Occlusion:
/// mark_hidden().
std::vector<MatchScene> read_simulated(const std::filesystem::path& folder, int frames);

}  // namespace imslam::bench
