#include "host/lib/json_text.h"

#include <cstddef>
#include <random>
#include <string>

#include <gtest/gtest.h>

namespace stof::lib {
namespace {

constexpr std::string_view kText =
    R"({"name": "a \"b\" }", "depth" :{"lr":2,"match": {"block": "9x9"}}, "on":true, "list": ["x", "y,z", 3]})";

TEST(JsonText, FindsValuesWhereTheyStand) {
  EXPECT_EQ(json_at(kText, "name"), R"("a \"b\" }")");
  EXPECT_EQ(json_at(kText, "depth.lr"), "2");
  EXPECT_EQ(json_string(*json_at(kText, "depth.match.block")), "9x9");
  EXPECT_EQ(json_at(kText, "on"), "true");
  EXPECT_EQ(json_at(R"({"p": {"a": {"p": {"b": 7}}}})", "a.b", "p"), "7");
  for (const char* const path : {"absent", "depth.absent", "name.x", "on.x", "", "depth."}) {
    EXPECT_FALSE(json_at(kText, path)) << path;
  }
}

TEST(JsonText, GoesThroughLists) {
  std::string_view list = *json_at(kText, "list");
  EXPECT_EQ(json_next(list), R"("x")");
  EXPECT_EQ(json_next(list), R"("y,z")");
  EXPECT_EQ(json_next(list), "3");
  EXPECT_FALSE(json_next(list));
  std::string_view empty = "[]";
  EXPECT_FALSE(json_next(empty));
}

// Whatever a sensor sends: the sanitizers watch, and it ends.
TEST(JsonText, AnyBytesMayCome) {
  for (std::size_t cut = 0; cut < kText.size(); ++cut) {
    static_cast<void>(json_at(kText.substr(0, cut), "list"));
    static_cast<void>(json_at(kText.substr(cut), "depth.match.block"));
  }
  constexpr unsigned kSeed = 7;
  std::mt19937 random(kSeed);
  constexpr std::string_view kLetters = R"({}[]",:\ a1)";
  for (int round = 0; round < 20'000; ++round) {
    std::string text;
    for (unsigned i = random() % 40; i > 0; --i) {
      text += kLetters[random() % kLetters.size()];
    }
    std::string_view list = text;
    static_cast<void>(json_at(text, "a.a", round % 2 == 0 ? "" : "a"));
    for (int i = 0; i < 100 && json_next(list); ++i) {
    }
    static_cast<void>(json_string(text));
  }
}

}  // namespace
}  // namespace stof::lib
