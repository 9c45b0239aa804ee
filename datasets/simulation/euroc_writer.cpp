#include "datasets/simulation/euroc_writer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "datasets/simulation/sensor_files.hpp"
#include "slam/base/error.hpp"
#include "slam/base/parallel.hpp"

namespace imslam::simulation {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<unsigned char>;

[[noreturn]] void cannot_write(const fs::path& file) {
  throw InputError(file.string() + ": cannot be written; check space and rights",
                   ExitCode::kOutput);
}

fs::path made(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) cannot_write(folder);
  return folder;
}

Bytes png(const cv::Mat& image) {
  Bytes bytes;
  // What OpenCV does unless told otherwise suits noise best: differences along the row, runs and
  // Huffman codes only. The fastest ordinary level takes three times as long for no smaller file.
  cv::imencode(".png", image, bytes);
  return bytes;
}

Bytes encode_grey(const GrayImage& image) {
  // The header needs a mutable pointer; imencode only reads.
  return png(
      cv::Mat(image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.pixels.data())));
}

void write_bytes(const fs::path& file, const Bytes& bytes) {
  std::ofstream stream(file, std::ios::binary);
  stream.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  stream.close();
  if (!stream) cannot_write(file);
}

std::string comma_separated(std::int64_t time_ns, const std::vector<Eigen::Vector3d>& columns) {
  std::string text = std::to_string(time_ns);
  for (const Eigen::Vector3d& column : columns) {
    text += fmt::format(",{},{},{}", column.x(), column.y(), column.z());
  }
  return text;
}

}  // namespace

CsvWriter::CsvWriter(const fs::path& file, const std::string& header) : file_(file), stream_(file) {
  if (!stream_) cannot_write(file_);
  line(header);
}

void CsvWriter::line(const std::string& text) {
  stream_ << text << '\n';
  if (!stream_) cannot_write(file_);
}

void CsvWriter::close() {
  stream_.close();
  if (!stream_) cannot_write(file_);
}

EurocWriter::EurocWriter(const fs::path& root, const Simulator& simulator)
    : mav_(root / "mav0"),
      left_(made(mav_ / "cam0" / "data").parent_path() / "data.csv", "#timestamp [ns],filename"),
      right_(made(mav_ / "cam1" / "data").parent_path() / "data.csv", "#timestamp [ns],filename"),
      imu_(made(mav_ / "imu0") / "data.csv",
           "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
           "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]"),
      truth_(made(mav_ / "state_groundtruth_estimate0") / "data.csv",
             "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],"
             "q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z [],"
             "v_RS_R_x [m s^-1],v_RS_R_y [m s^-1],v_RS_R_z [m s^-1],"
             "b_w_RS_S_x [rad s^-1],b_w_RS_S_y [rad s^-1],b_w_RS_S_z [rad s^-1],"
             "b_a_RS_S_x [m s^-2],b_a_RS_S_y [m s^-2],b_a_RS_S_z [m s^-2]") {
  const StereoRig& rig = simulator.rig();
  const double rate = simulator.options().frame_rate_hz;
  const auto write = [](const fs::path& file, const std::string& text) {
    write_bytes(file, Bytes(text.begin(), text.end()));
  };
  write(mav_ / "cam0" / "sensor.yaml", camera_file(rig.left, rig.T_body_left, rate, "left"));
  write(mav_ / "cam1" / "sensor.yaml", camera_file(rig.right, rig.T_body_right, rate, "right"));
  write(mav_ / "imu0" / "sensor.yaml", imu_file(simulator.imu_errors().data_sheet));
  write(mav_ / "state_groundtruth_estimate0" / "sensor.yaml", truth_file());
  if (simulator.options().truth_depth) made(mav_ / "depth0" / "data");
  if (simulator.options().truth_flow) made(mav_ / "flow0" / "data");
}

void EurocWriter::add_imu(const SimulatedImuSample& sample) {
  const ImuSample& reading = sample.reading;
  imu_.line(
      comma_separated(reading.time_ns, {reading.angular_velocity, reading.linear_acceleration}));
  const lie::SE3d& pose = sample.truth.T_world_body;
  const auto& q = pose.rotation().quaternion();
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  truth_.line(
      comma_separated(reading.time_ns, {pose.translation()}) +
      fmt::format(",{},{},{},{}", sign * q.w(), sign * q.x(), sign * q.y(), sign * q.z()) +
      comma_separated(0, {sample.truth.v_world, sample.bias.gyro, sample.bias.accel}).substr(1));
}

void EurocWriter::add_frames(const std::vector<SimulatedFrame>& frames) {
  struct Job {
    fs::path file;
    std::function<Bytes()> encode;
  };
  std::vector<Job> jobs;
  for (const SimulatedFrame& frame : frames) {
    const std::string stamp = std::to_string(frame.time_ns);
    const std::string name = stamp + ".png";
    const auto add = [&](const char* folder, const std::function<Bytes()>& encode) {
      jobs.push_back({mav_ / folder / "data" / name, encode});
    };
    if (!frame.left.empty()) {
      left_.line(stamp + "," + name);
      add("cam0", [&frame] { return encode_grey(frame.left); });
    }
    if (!frame.right.empty()) {
      right_.line(stamp + "," + name);
      add("cam1", [&frame] { return encode_grey(frame.right); });
    }
    if (!frame.depth.empty()) add("depth0", [&frame] { return encode_depth(frame); });
    if (!frame.flow.empty()) add("flow0", [&frame] { return encode_flow(frame); });
  }
  parallel_for(jobs.size(), [&](std::size_t i) { write_bytes(jobs[i].file, jobs[i].encode()); });
}

void EurocWriter::close() {
  for (CsvWriter* file : {&left_, &right_, &imu_, &truth_}) file->close();
}

Bytes encode_depth(const SimulatedFrame& frame) {
  static_assert(sizeof(float) == 4);
  cv::Mat image(frame.height, frame.width, CV_8UC4);
  expects(frame.depth.size() * sizeof(float) == image.total() * image.elemSize(),
          "encode_depth: one depth per pixel");
  std::memcpy(image.data, frame.depth.data(), frame.depth.size() * sizeof(float));
  return png(image);
}

Bytes encode_flow(const SimulatedFrame& frame) {
  cv::Mat image(frame.height, frame.width, CV_16UC3);
  expects(frame.flow_valid.size() == image.total(), "encode_flow: one displacement per pixel");
  const auto coded = [](float displacement) {
    const float value = std::round(displacement * 64.0F) + 32768.0F;
    return static_cast<std::uint16_t>(std::clamp(value, 0.0F, 65535.0F));
  };
  auto* out = image.ptr<std::uint16_t>();
  for (std::size_t i = 0; i < frame.flow_valid.size(); ++i) {
    out[3 * i] = frame.flow_valid[i] != 0 ? 1 : 0;
    out[3 * i + 1] = coded(frame.flow[2 * i + 1]);
    out[3 * i + 2] = coded(frame.flow[2 * i]);
  }
  return png(image);
}

}  // namespace imslam::simulation
