#include "slam/report/html_text.hpp"

#include <gtest/gtest.h>

#include "slam/base/error.hpp"

namespace imslam::report {
namespace {

TEST(HtmlText, EscapesEverythingThatCouldBecomeMarkup) {
  EXPECT_EQ(escape_html("<script>alert(\"1\")&'"), "&lt;script&gt;alert(&quot;1&quot;)&amp;&#39;");
}

TEST(HtmlText, KeepsLinesTabsAndUtf8) {
  EXPECT_EQ(escape_html("a\tb\r\nGr\xC3\xBC\xC3\x9F \xE2\x82\xAC \xF0\x9F\x98\x80"),
            "a\tb\nGr\xC3\xBC\xC3\x9F \xE2\x82\xAC \xF0\x9F\x98\x80");
}

TEST(HtmlText, ReplacesControlCharactersAndBrokenUtf8) {
  const std::string replaced = "\xEF\xBF\xBD";
  EXPECT_EQ(escape_html(std::string_view("\0x\x1B", 3)), replaced + "x" + replaced);
  EXPECT_EQ(escape_html("\xFF"), replaced);
  EXPECT_EQ(escape_html("\xC0\xBC"), replaced + replaced) << "overlong '<'";
  EXPECT_EQ(escape_html("\xED\xA0\x80"), replaced + replaced + replaced) << "surrogate";
  EXPECT_EQ(escape_html("\xE2\x82"), replaced + replaced) << "cut off";
}

TEST(HtmlText, DataCannotEndItsScript) {
  EXPECT_EQ(escape_json_for_script("[\"</script><!--&\"]"),
            "[\"\\u003c/script\\u003e\\u003c!--\\u0026\"]");
}

TEST(HtmlText, Base64MatchesTheVectorsOfRfc4648) {
  const std::string text = "foobar";
  const char* expected[] = {"", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"};
  for (std::size_t size = 0; size <= text.size(); ++size) {
    EXPECT_EQ(base64(text.data(), size), expected[size]);
  }
}

TEST(HtmlText, PolicyHashIsThatOfTheSpecification) {
  // Content Security Policy Level 3, section 2.3.1: the hash of alert('Hello, world.');
  EXPECT_EQ(csp_hash("alert('Hello, world.');"),
            "'sha256-qznLcsROx4GACP2dm0UCKCzCG+HiZ1guq6ZZDob/Tng='");
}

TEST(HtmlText, TemplateIsFilledOnce) {
  EXPECT_EQ(fill_template("{{a}}-{{b}}", {{"a", "{{b}}"}, {"b", "x"}}), "{{b}}-x");
  EXPECT_THROW(fill_template("{{unknown}}", {}), ContractError);
  EXPECT_THROW(fill_template("{{open", {}), ContractError);
}

}  // namespace
}  // namespace imslam::report
