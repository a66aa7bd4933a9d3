#include "host/report/page/page.h"

#include <limits>

#include <gtest/gtest.h>

namespace stof::host {
namespace {

TEST(Base64, EncodesTheExamplesOfRfc4648) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foob"), "Zm9vYg==");
  EXPECT_EQ(base64("fooba"), "Zm9vYmE=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64("\xff\xfe\xfd"), "//79");
}

TEST(Escaped, LeavesNothingThatAPageWouldRead) {
  EXPECT_EQ(escaped("<a href=\"x\">&</a>"), "&lt;a href=&quot;x&quot;&gt;&amp;&lt;/a&gt;");
}

TEST(Number, IsADashWhereThereIsNone) {
  EXPECT_EQ(number(2.345, 1), "2.3");
  EXPECT_EQ(percent(0.1234), "12.3");
  EXPECT_EQ(number(-0.01, 1), "0.0");
  EXPECT_EQ(number(-0.06, 1), "-0.1");
  EXPECT_EQ(percent(std::nullopt), "–");
  EXPECT_EQ(number(std::numeric_limits<double>::quiet_NaN(), 1), "–");
}

TEST(VerdictOf, NeedsAllForYesAndNoneForNo) {
  EXPECT_EQ(verdict_of(3, 3), Verdict::kYes);
  EXPECT_EQ(verdict_of(1, 3), Verdict::kPartly);
  EXPECT_EQ(verdict_of(0, 3), Verdict::kNo);
  EXPECT_EQ(verdict_of(0, 0), Verdict::kNotMeasured);
}

TEST(Page, ListsEveryClaimAtItsTopWithALinkToItsSection) {
  Page page;
  page.begin_section("one", "First");
  page.claim({.chapter = "A is <B", .measured = "7", .rule = "r", .verdict = Verdict::kPartly});
  page.begin_section("two", "Second");
  page.paragraph("text");
  const std::string html = page.html("Title", {"lead"});
  const std::size_t list = html.find("id=\"claims\"");
  const std::size_t section = html.find("<section id=\"one\"");
  ASSERT_LT(list, section);
  const std::string top = html.substr(list, section - list);
  EXPECT_NE(top.find("A is &lt;B"), std::string::npos);
  EXPECT_NE(top.find("href=\"#one\""), std::string::npos);
  EXPECT_NE(top.find("partly"), std::string::npos);
  EXPECT_EQ(page.verdicts(), "partly        A is <B\n");
  // The rule stands for itself: "[no] yes: in every case" reads as two verdicts.
  EXPECT_NE(html.substr(section).find("partly</span></dd><dt>Rule</dt><dd class=\"rule\">r</dd>"),
            std::string::npos);
}

TEST(Page, LeavesOutTablesAndGroupsWithoutContent) {
  Page page;
  page.begin_section("one", "First");
  page.table({.caption = "c", .header = {"a", "b"}, .text_columns = 1, .rows = {}});
  page.table(
      {.caption = "c", .header = {"a", "b"}, .text_columns = 1, .rows = {{"only a heading"}}});
  page.figures({}, Width::kSmall);
  const std::string html = page.html("Title", {});
  EXPECT_EQ(html.find("<table"), std::string::npos);
  EXPECT_EQ(html.find("class=\"figures"), std::string::npos);
}

TEST(Page, ShowsARowOfOneCellAsAHeadingOfTheTable) {
  Page page;
  page.begin_section("one", "First");
  page.table({.caption = "", .header = {"a", "b"}, .text_columns = 1, .rows = {{"g"}, {"x", "1"}}});
  const std::string html = page.html("Title", {});
  EXPECT_NE(html.find("colspan=\"2\">g<"), std::string::npos);
  EXPECT_NE(html.find("<td class=\"n\">1</td>"), std::string::npos);
}

}  // namespace
}  // namespace stof::host
