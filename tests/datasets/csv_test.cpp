#include "datasets/csv.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/datasets/expect_error.hpp"
#include "tests/support/temp_dir.hpp"

namespace imslam::datasets {
namespace {

using imslam::testing::expect_input_error;
using imslam::testing::TempDir;
using Kind = CsvColumn::Kind;

CsvReader reader_of(const std::string& text, bool allow_more = false) {
  return {
      LineReader("t.csv", text), {{"time [ns]", Kind::kTime}, {"x [m]", Kind::kReal}}, allow_more};
}

std::vector<std::pair<std::int64_t, double>> rows_of(const std::string& text) {
  CsvReader csv = reader_of(text);
  std::vector<std::pair<std::int64_t, double>> rows;
  while (csv.next()) rows.emplace_back(csv.time_ns(0), csv.real(1));
  return rows;
}

TEST(LineReader, StripsMarkAndCarriageReturnsAndCountsLines) {
  LineReader lines("t",
                   "\xEF\xBB\xBF"
                   "a\r\n\r\nb");
  ASSERT_TRUE(lines.next());
  EXPECT_EQ(lines.line(), "a");
  EXPECT_TRUE(lines.terminated());
  ASSERT_TRUE(lines.next());
  EXPECT_EQ(lines.line(), "");
  ASSERT_TRUE(lines.next());
  EXPECT_EQ(lines.line(), "b");
  EXPECT_FALSE(lines.terminated());
  EXPECT_EQ(lines.where(4), "t:3:4");
  EXPECT_FALSE(lines.next());
  EXPECT_FALSE(lines.next());
}

TEST(LineReader, TakesALineOfExactlyTheLimitAndRefusesALongerOne) {
  const std::string longest(LineReader::kMaxLineBytes, 'x');
  LineReader fits("t", longest + "\nend");
  ASSERT_TRUE(fits.next());
  EXPECT_EQ(fits.line().size(), longest.size());
  ASSERT_TRUE(fits.next());
  EXPECT_EQ(fits.line(), "end");
  LineReader too_long("t", longest + "xx\n");
  expect_input_error([&] { too_long.next(); }, ExitCode::kData, {"t:1", "longer than 65536 bytes"});
}

TEST(LineReader, RefusesWhatIsNoRegularFile) {
  const TempDir dir;
  expect_input_error([] { LineReader("/dev/zero"); }, ExitCode::kData, {"not a regular file"});
  expect_input_error([&] { LineReader(dir.path()); }, ExitCode::kData, {"not a regular file"});
  expect_input_error([&] { LineReader(dir.path() / "no.csv"); }, ExitCode::kData,
                     {"no.csv", "cannot be opened"});
}

TEST(CsvReader, AcceptsTheDocumentedVariantsOfOneTable) {
  const std::vector<std::pair<std::int64_t, double>> expected = {{1, 0.5}, {2, -1e-3}};
  for (const std::string text : {
           "#t,x\n1,0.5\n2,-1e-3\n",
           "1,0.5\n2,-1e-3",                 // no header, no final newline
           "timestamp,x\n1,0.5\n2,-1e-3\n",  // header without #
           "\"timestamp\",\"x\"\n1,0.5\n2,-1e-3\n",
           "#t,x\r\n1,0.5\r\n2,-1e-3\r\n",                 // CRLF
           "\xEF\xBB\xBF#t,x\n1,0.5\n2,-1e-3\n",           // byte order mark
           "#t,x\n1,0.5,\n2,-1e-3,\n",                     // trailing comma
           "#t,x\n 1 ,\t0.5 \n2, -1e-3\n",                 // blanks
           "\n\n#t,x\n\n1,0.5\n\n# comment\n2,-1e-3\n\n",  // empty lines, comments
           "#t,x\n1,+0.5\n2,-0.001\n3,",                   // last line cut off
           "#t,x\n1,0.5\n2,-1e-3\n3,-",
           "#t,x\n1,0.5\n2,-1e-3\n17",
       }) {
    EXPECT_EQ(rows_of(text), expected) << text;
  }
}

TEST(CsvReader, SaysWhenTheFileEndsInsideARow) {
  CsvReader csv = reader_of("1,0.5\n2");
  EXPECT_TRUE(csv.next());
  EXPECT_FALSE(csv.next());
  EXPECT_TRUE(csv.cut_off());
}

TEST(CsvReader, NamesPlaceExpectationAndRemedyOfWhatItRefuses) {
  const struct {
    std::string text;
    std::vector<std::string> words;
  } cases[] = {
      {"1,0.5\n2\n3,1\n", {"t.csv:2:1", "expected 2 columns", "found 1", "remove the line"}},
      {"1,0.5\n2,1,3\n", {"t.csv:2:1", "found 3", "point, not a comma"}},
      {"1,0,5\n", {"t.csv:1:1", "found 3", "point, not a comma"}},
      {"1;0,5\n", {"t.csv:1:1", "semicolons"}},
      {"1 0.5\n", {"t.csv:1:1", "by commas, not blanks"}},
      {"1,0.5\nabc,1\n", {"t.csv:2:1", "time [ns]", "whole number", "\"abc\""}},
      {"1,0.5\n  12, 3x\n", {"t.csv:2:7", "x [m]", "a number", "\"3x\""}},
      {"1.5,0.5\n", {"t.csv:1:1", "whole number of nanoseconds", "\"1.5\""}},
      {"9000000000000000000,1\n", {"t.csv:1:1"}},
      {"99999999999999999999,1\n", {"t.csv:1:1"}},
      {"1,\n", {"t.csv:1:3", "x [m]"}},
      {std::string("1,\0\x01\n", 5), {"t.csv:1:3", "\"??\""}},
  };
  for (const auto& each : cases) {
    CsvReader csv = reader_of(each.text);
    expect_input_error(
        [&] {
          while (csv.next()) {
          }
        },
        ExitCode::kData, each.words);
  }
}

TEST(CsvReader, GoesOnBehindALineThatItRefused) {
  CsvReader csv = reader_of("1,0.5\nx,y\n3,2\n");
  EXPECT_TRUE(csv.next());
  EXPECT_THROW(csv.next(), InputError);
  ASSERT_TRUE(csv.next());
  EXPECT_EQ(csv.time_ns(0), 3);
}

TEST(CsvReader, AllowsMoreColumnsOnlyIfAsked) {
  CsvReader csv = reader_of("1,0.5,7,8\n", true);
  ASSERT_TRUE(csv.next());
  EXPECT_EQ(csv.real(1), 0.5);
}

TEST(CsvReader, ReadsNotANumberAsAValue) {
  CsvReader csv = reader_of("1,nan\n2,-inf\n");
  ASSERT_TRUE(csv.next());
  EXPECT_TRUE(std::isnan(csv.real(1)));
  ASSERT_TRUE(csv.next());
  EXPECT_TRUE(std::isinf(csv.real(1)));
}

}  // namespace
}  // namespace imslam::datasets
