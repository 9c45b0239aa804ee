#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "slam/base/error.hpp"
#include "slam/base/file.hpp"
#include "slam/plugins/routing/solution.hpp"

namespace imslam::routing {
namespace {

constexpr double kPicture = 800.0;  ///< pixels of the field's larger side
constexpr double kMargin = 24.0;
constexpr double kCaption = 28.0;

/// From the field to the picture, y upwards.
class Frame {
 public:
  explicit Frame(const std::vector<Point>& points) : low_(points.front()), high_(low_) {
    for (const Point& p : points) {
      low_ = {std::min(low_.x, p.x), std::min(low_.y, p.y)};
      high_ = {std::max(high_.x, p.x), std::max(high_.y, p.y)};
    }
    scale_ = kPicture / std::max({high_.x - low_.x, high_.y - low_.y, 1e-300});
  }
  double width() const { return (high_.x - low_.x) * scale_ + 2.0 * kMargin; }
  double height() const { return (high_.y - low_.y) * scale_ + 2.0 * kMargin + kCaption; }
  Point on_picture(const Point& p) const {
    return {(p.x - low_.x) * scale_ + kMargin, (high_.y - p.y) * scale_ + kMargin + kCaption};
  }

 private:
  Point low_;
  Point high_;
  double scale_ = 1.0;
};

/// Hues a golden angle apart: neighbours in number are not alike in colour.
std::string colour(std::size_t agent) {
  const double hue = std::fmod(137.508 * static_cast<double>(agent), 360.0);
  return fmt::format("hsl({:.0f},70%,{}%)", hue, agent % 2 == 0 ? 42 : 55);
}

const Point& point_of(const Instance& instance, int city) {
  return instance.points[static_cast<std::size_t>(city)];
}

std::string tour_line(const Instance& instance,
                      const Frame& frame,
                      const Solution& solution,
                      std::size_t agent) {
  std::string line;
  const auto add = [&](int city) {
    const Point p = frame.on_picture(point_of(instance, city));
    line += fmt::format("{:.1f},{:.1f} ", p.x, p.y);
  };
  add(instance.depot);
  for (const int city : solution.tours[agent]) add(city);
  const bool longest = solution.lengths[agent] >= solution.longest();
  return fmt::format(
      "<polygon points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" "
      "stroke-linejoin=\"round\"><title>agent {}: {} cities, length {:.6g}</title></polygon>\n",
      line, colour(agent), longest ? 2.6 : 1.5, agent, solution.tours[agent].size(),
      solution.lengths[agent]);
}

}  // namespace

std::string tours_json(const Instance& instance, const Solution& solution) {
  nlohmann::ordered_json json;
  json["instance"] = instance.name;
  json["cities"] = instance.city_count();
  json["depot"] = instance.depot;
  json["agents"] = solution.tours.size();
  json["longest"] = solution.longest();
  json["total"] = solution.total();
  json["lengths"] = solution.lengths;
  json["tours"] = solution.tours;
  return json.dump() + "\n";
}

std::string tours_csv(const Instance& instance, const Solution& solution) {
  const bool plane = !instance.points.empty();
  std::string text = plane ? "agent,stop,city,x,y,length\n" : "agent,stop,city,length\n";
  for (std::size_t agent = 0; agent < solution.tours.size(); ++agent) {
    double length = 0.0;
    int stop = 0;
    int last = instance.depot;
    const auto row = [&](int city) {
      length += instance.distance(last, city);
      last = city;
      text += fmt::format("{},{},{},", agent, stop++, city);
      if (plane) {
        const Point& p = point_of(instance, city);
        text += fmt::format("{:.10g},{:.10g},", p.x, p.y);
      }
      text += fmt::format("{:.10g}\n", length);
    };
    row(instance.depot);
    for (const int city : solution.tours[agent]) row(city);
    if (!solution.tours[agent].empty()) row(instance.depot);
  }
  return text;
}

std::string tours_svg(const Instance& instance, const Solution& solution) {
  if (instance.points.empty()) return "";
  const Frame frame(instance.points);
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" "
      "font-family=\"sans-serif\" font-size=\"15\">\n"
      "<rect width=\"{0:.0f}\" height=\"{1:.0f}\" fill=\"white\"/>\n"
      "<text x=\"{2:.0f}\" y=\"26\">{3} cities, {4} agents: longest tour {5:.6g}, all "
      "{6:.6g}</text>\n",
      frame.width(), frame.height(), kMargin, instance.city_count(), solution.tours.size(),
      solution.longest(), solution.total());
  for (std::size_t agent = 0; agent < solution.tours.size(); ++agent) {
    if (!solution.tours[agent].empty()) svg += tour_line(instance, frame, solution, agent);
  }
  const double radius = instance.city_count() > 2000 ? 1.0 : 2.2;
  for (const Point& city : instance.points) {
    const Point p = frame.on_picture(city);
    svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\"/>\n", p.x, p.y, radius);
  }
  const Point depot = frame.on_picture(point_of(instance, instance.depot));
  svg += fmt::format(
      "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"12\" height=\"12\" fill=\"red\" "
      "stroke=\"black\"/>\n",
      depot.x - 6.0, depot.y - 6.0);
  return svg + "</svg>\n";
}

Solution read_tours_json(const std::string& name, const std::string& text) {
  try {
    const nlohmann::json json = nlohmann::json::parse(text);
    Solution solution;
    solution.tours = json.at("tours").get<std::vector<std::vector<int>>>();
    solution.lengths = json.at("lengths").get<std::vector<double>>();
    if (solution.tours.size() == solution.lengths.size()) return solution;
  } catch (const nlohmann::json::exception& error) {
    throw InputError(
        fmt::format("{}: expected JSON with tours and lengths: {}", name, error.what()));
  }
  throw InputError(name + ": as many lengths as tours were expected");
}

void write_solution(const std::filesystem::path& folder,
                    const Instance& instance,
                    const Solution& solution) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    throw InputError(folder.string() + ": cannot be made: " + error.message(), ExitCode::kOutput);
  }
  write_file_atomic(folder / "tours.json", tours_json(instance, solution));
  write_file_atomic(folder / "tours.csv", tours_csv(instance, solution));
  const std::string svg = tours_svg(instance, solution);
  if (!svg.empty()) write_file_atomic(folder / "tours.svg", svg);
}

}  // namespace imslam::routing
