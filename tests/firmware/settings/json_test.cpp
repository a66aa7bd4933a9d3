#include "firmware/settings/text/json.h"

#include <array>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/settings/fields/document.h"

namespace stof::settings {
namespace {

struct Outcome {
  bool accepted = false;
  Settings settings{};
  std::string why{};
};

Outcome read(const std::string& json) {
  // No byte beyond the text may be looked at: no 0 behind it, and the sanitizers watch.
  const std::vector<char> exact(json.begin(), json.end());
  std::array<char, kWhyBytes> space;
  PagedWriter why(space);
  Outcome outcome;
  outcome.accepted = parse(exact, outcome.settings, why);
  outcome.why = std::string(why.text());
  EXPECT_EQ(outcome.why.empty(), outcome.accepted) << json;
  EXPECT_EQ(outcome.why.find('\n'), std::string::npos) << json;
  EXPECT_TRUE(outcome.accepted || outcome.settings == Settings{}) << json;
  return outcome;
}

TEST(Json, TakesObjectsWithWhiteSpaceAnywhere) {
  EXPECT_TRUE(read("{}").accepted);
  EXPECT_TRUE(read(" \t\r\n{ } \n").accepted);
  EXPECT_TRUE(read("{\"depth\":{}}").accepted);
  EXPECT_TRUE(read("{\"depth\":{\"match\":{}},\"name\":\"a\"}").accepted);
  const Outcome spaced = read(
      " { \"depth\" : { \"guided\" :\ttrue , \"match\" : { \"lr\" : 2 } "
      "}\n, \"period_ms\" : 40 } ");
  EXPECT_TRUE(spaced.accepted) << spaced.why;
  EXPECT_TRUE(spaced.settings.depth.guided);
  EXPECT_EQ(spaced.settings.period_ms, 40);
}

TEST(Json, RefusesWhatIsNotJson) {
  const std::vector<std::string> wrong{
      "",
      " ",
      "null",
      "[]",
      "1",
      "\"name\"",
      "{",
      "}",
      "{]",
      "[}",
      "{}}",
      "{}{}",
      "{} {}",
      "{},",
      ",{}",
      "{}x",
      "x{}",
      std::string("{}\0", 3),
      std::string("{}\0{", 4),
      std::string("{\"period_ms\": 40\0}", 18),
      "{,}",
      "{:}",
      "{\"name\"}",
      "{\"name\":}",
      "{\"name\" \"a\"}",
      "{\"name\",\"a\"}",
      "{\"name\"::\"a\"}",
      "{\"name\":\"a\",}",
      "{,\"name\":\"a\"}",
      "{\"name\":\"a\",,\"period_ms\":40}",
      "{\"name\":\"a\" \"period_ms\":40}",
      "{\"name\":\"a\":\"period_ms\":40}",
      "{\"name\":\"a\" 40}",
      "{\"name\" 40 \"a\"}",
      "{\"depth\":{} \"name\":\"a\"}",
      "{\"depth\"{}}",
      "{\"depth\":{\"guided\":true}}}",
      "{\"depth\":{\"guided\":true}",
      "{name:\"a\"}",
      "{'name':\"a\"}",
      "{1:2}",
      "{true:false}",
      "{{}:1}",
      "{\"period_ms\":040}",
      "{\"period_ms\":+40}",
      "{\"period_ms\":-}",
      "{\"period_ms\":4 0}",
      "{\"period_ms\":40.}",
      "{\"period_ms\":.4}",
      "{\"period_ms\":4e}",
      "{\"period_ms\":0x28}",
      "{\"period_ms\":40x}",
      "{\"period_ms\":40\"\"}",
      "{\"period_ms\":\"\"40}",
      "{\"depth\":{\"guided\":True}}",
      "{\"depth\":{\"guided\":truex}}",
      "{\"depth\":{\"guided\":t}}",
      "{\"depth\":{\"guided\":tru}}",
      "{\"name\":\"a}",
      "{\"name\":\"a\nb\"}",
      "{\"name\":\"a\x7f\"}",
      "{\"name\":\"\\u0061\"}",
      "{\"name\":\"\\n\"}",
      "{\"name\":\"\\\"\"}",
      "{\"name\":\"\xc3\"}",
      "{\"name\":\"\xc0\x80\"}",
      "{\"name\":\"\xed\xa0\x80\"}",
      "{\"name\":\"\xf4\x90\x80\x80\"}",
      "{\"nam\\u0065\":\"a\"}",
      "\xef\xbb\xbf{}",
      "{/* */}",
      "{} // end",
  };
  for (const std::string& text : wrong) {
    EXPECT_FALSE(read(text).accepted) << text;
  }
}

TEST(Json, RefusesNamesThatStandTwice) {
  EXPECT_EQ(read("{\"name\":\"a\",\"name\":\"a\"}").why, "name: stands there twice");
  EXPECT_EQ(read("{\"depth\":{\"guided\":true},\"depth\":{\"temporal\":true}}").why,
            "depth: stands there twice");
  EXPECT_EQ(read("{\"depth\":{\"match\":{\"lr\":1},\"guided\":true,\"match\":{}}}").why,
            "depth.match: stands there twice");
  EXPECT_TRUE(
      read("{\"sectors\":{\"pixels\":3},\"streams\":{\"depth\":\"off\"},\"depth\":{}}").accepted);
}

TEST(Json, RefusesObjectsAndArraysInPlaceOfValues) {
  EXPECT_NE(read("{\"name\":{}}").why.find("not an object"), std::string::npos);
  EXPECT_NE(read("{\"name\":[1]}").why.find("not an array"), std::string::npos);
  // Of a field that an earlier version had.
  EXPECT_FALSE(read("{\"depth\":{\"match\":{\"method\":[]}}}").accepted);
}

// Any visitor: one that takes whatever it is shown.
class TakesAll final : public JsonVisitor {
 public:
  bool is_group(std::string_view) noexcept override { return true; }
  bool member(std::string_view, const Value&) noexcept override { return true; }
};

TEST(Json, BoundsWhatIsOpenForAnyVisitor) {
  TakesAll visitor;
  std::array<char, kWhyBytes> space;
  PagedWriter deep(space);
  EXPECT_FALSE(walk_json("{\"a\":{\"a\":{\"a\":{\"a\":{}}}}}", visitor, deep));
  EXPECT_NE(deep.text().size(), 0U);
  std::string many = "{\"a\":1";
  for (int k = 0; k < 1000; ++k) {
    many += ",\"x" + std::to_string(k) + "\":1";
  }
  PagedWriter full(space);
  EXPECT_FALSE(walk_json(many + "}", visitor, full));
  EXPECT_EQ(std::string(full.text()), "more values than there are settings");
  PagedWriter nested(space);
  EXPECT_FALSE(walk_json("{\"a\":[]}", visitor, nested));
  EXPECT_EQ(std::string(nested.text()), "a: takes neither an object nor an array");
}

TEST(Json, RefusesPathsWrittenInOtherWays) {
  EXPECT_FALSE(read("{\"depth.guided\":true}").accepted);
  EXPECT_FALSE(read("{\"depth\":{\"match.lr\":1}}").accepted);
  EXPECT_FALSE(read("{\"\":{\"name\":\"a\"}}").accepted);
  EXPECT_FALSE(read("{\"\":1}").accepted);
  EXPECT_FALSE(read("{\"Name\":\"a\"}").accepted);
  EXPECT_FALSE(read("{\"" + std::string(5000, 'a') + "\":1}").accepted);
}

TEST(Json, RefusesDepthAndLength) {
  std::string deep;
  for (int k = 0; k < 10'000; ++k) {
    deep += "{\"depth\":";
  }
  EXPECT_FALSE(read(deep).accepted);
  EXPECT_FALSE(read(std::string(10'000, '[')).accepted);
  std::string many = "{\"name\":\"a\"";
  for (int k = 0; k < 1000; ++k) {
    many += ",\"x" + std::to_string(k) + "\":1";
  }
  EXPECT_FALSE(read(many + "}").accepted);
  EXPECT_TRUE(read("{}" + std::string(kMostJsonBytes - 2, ' ')).accepted);
  EXPECT_FALSE(read("{}" + std::string(kMostJsonBytes - 1, ' ')).accepted);
}

TEST(Json, OneBadFieldChangesNothing) {
  const Outcome outcome =
      read("{\"name\":\"a\",\"depth\":{\"guided\":true},\"streams\":{\"depth\":\"no\"}}");
  EXPECT_FALSE(outcome.accepted);  // and read() compares
}

TEST(Json, MessagesFitWhateverIsWritten) {
  const Outcome outcome = read("{\"name\":\"" + std::string(2000, 'a') + "\"}");
  EXPECT_LT(outcome.why.size(), kWhyBytes);
  EXPECT_NE(outcome.why.find("..."), std::string::npos);
}

// Cut, doubled, exchanged and changed bytes of a whole document. 1e5 documents where STOF_LONG is
// set.
TEST(Json, MutatedDocumentsAreRefusedOrUnderstood) {
  const int count = std::getenv("STOF_LONG") == nullptr ? 5'000 : 100'000;
  std::array<char, kMostDocumentBytes> space;
  PagedWriter out(space);
  write_document({}, out);
  const std::string whole(out.text());
  const std::string letters = "{}[]:,\"\\ 0123456789-+.eEtfnu\n\x01\x80\xff";
  std::mt19937 random(20'261'121);
  int accepted = 0;
  for (int k = 0; k < count; ++k) {
    std::string text = whole;
    for (std::size_t change = random() % 3; change < 3; ++change) {
      const std::size_t at = random() % (text.size() + 1);
      const std::size_t length = random() % 40;
      switch (random() % 5) {
        case 0:
          text.erase(at, length);
          break;
        case 1:
          text.insert(at, 1, letters[random() % letters.size()]);
          break;
        case 2:
          text.insert(at, text.substr(random() % text.size(), length));
          break;
        case 3:
          text.resize(at);
          break;
        default:
          if (at < text.size()) {
            text[at] = letters[random() % letters.size()];
          }
      }
      text += text.empty() ? " " : "";
    }
    const Outcome outcome = read(text);
    if (outcome.accepted) {
      ++accepted;
      std::array<char, kMostDocumentBytes> again_space;
      PagedWriter again(again_space);
      write_document(outcome.settings, again);
      const Outcome repeated = read(std::string(again.text()));
      ASSERT_TRUE(repeated.accepted) << repeated.why;
      ASSERT_EQ(repeated.settings, outcome.settings) << text;
    }
  }
  EXPECT_GT(accepted, 0);
  EXPECT_LT(accepted, count / 2);
}

}  // namespace
}  // namespace stof::settings
