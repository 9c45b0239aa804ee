// imslam_report_demo FOLDER [room|bare|street]: a report of a synthetic run, to look at.
#include <cstdio>
#include <string>

#include "slam/report/report.hpp"
#include "synthetic_run.hpp"

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  const std::string kind = argc > 2 ? argv[2] : "room";
  imslam::report::testing::SyntheticRun options;
  if (kind == "bare") options.truth = options.map = false;
  if (kind == "street") options.length_scale = 60.0;
  imslam::report::testing::write_synthetic_run(argv[1], options);
  imslam::report::write_report(argv[1]);
  std::printf("%s/report.html\n", argv[1]);
  return 0;
}
