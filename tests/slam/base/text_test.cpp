#include "slam/base/text.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imslam {
namespace {

TEST(ParseDouble, AcceptsNumbersAndNothingElse) {
  EXPECT_EQ(parse_double("1.5"), 1.5);
  EXPECT_EQ(parse_double("  -2e-3\r"), -2e-3);
  EXPECT_EQ(parse_double("+7"), 7.0);
  EXPECT_TRUE(std::isnan(parse_double("nan").value()));
  EXPECT_TRUE(std::isinf(parse_double("-inf").value()));
  for (const char* wrong :
       {"", " ", "1,5", "1.5x", "x", "1 2", "--1", "+-1", "+ 1", "1e999", "0x10"}) {
    EXPECT_FALSE(parse_double(wrong).has_value()) << wrong;
  }
}

TEST(ParseInt64, KeepsAllDigitsAndRefusesOverflow) {
  EXPECT_EQ(parse_int64("1403636584743560123"), 1403636584743560123);
  EXPECT_EQ(parse_int64("-9223372036854775808"), INT64_MIN);
  for (const char* wrong : {"9223372036854775808", "1.0", "1e3", "", "12a"}) {
    EXPECT_FALSE(parse_int64(wrong).has_value()) << wrong;
  }
}

TEST(Trim, RemovesBlanksAtBothEnds) {
  EXPECT_EQ(trim(" \t a b \r\n"), "a b");
  EXPECT_EQ(trim(" \t "), "");
  EXPECT_EQ(trim(""), "");
}

TEST(Split, KeepsEmptyParts) {
  EXPECT_EQ(split("a,,b,", ','), (std::vector<std::string_view>{"a", "", "b", ""}));
  EXPECT_EQ(split("", ',').size(), 1U);
}

TEST(SplitBlanks, DropsEmptyParts) {
  EXPECT_EQ(split_blanks("  a \t b\r"), (std::vector<std::string_view>{"a", "b"}));
  EXPECT_TRUE(split_blanks(" \t ").empty());
}

TEST(NearestName, FindsTyposButNoStrangers) {
  const std::vector<std::string> names = {"pgo.huber", "pgo.rounds", "vo.points"};
  EXPECT_EQ(nearest_name("pgo.hubre", names), "pgo.huber");
  EXPECT_EQ(nearest_name("pgo.round", names), "pgo.rounds");
  EXPECT_EQ(nearest_name("vo.points", names), "vo.points");
  EXPECT_FALSE(nearest_name("zzzzzzzz", names).has_value());
  EXPECT_FALSE(nearest_name("x", {}).has_value());
}

}  // namespace
}  // namespace imslam
