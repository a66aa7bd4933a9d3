#include "dataset/files/json_file.h"

#include "tests/dataset/scratch.h"

namespace stof::dataset {
namespace {

class JsonFile : public test::Scratch {
 protected:
  void expect_refused(std::string_view text, std::string_view fact) const {
    put("a.json", text);
    const Loaded<nlohmann::json> read = read_object(folder() / "a.json");
    ASSERT_FALSE(read) << text;
    test::expect_one_line_about(read.error().message, folder() / "a.json", fact);
  }
};

TEST_F(JsonFile, IsReadWhole) {
  put("a.json", "\n {\"a\": 1, \"b\": {\"a\": 2}, \"c\": [{\"a\": 3}, {\"a\": 4}]}\n");
  const Loaded<nlohmann::json> read = read_object(folder() / "a.json");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ((*read)["b"]["a"], 2);
  EXPECT_EQ((*read)["c"][1]["a"], 4);
}

TEST_F(JsonFile, SaysWhereItIsNone) {
  expect_refused("{\"a\": NaN}", "line 1, column 7");
  expect_refused("{\n \"a\": 1,\n \"b\": Infinity\n}", "line 3, column 7");
  expect_refused("{\"a\": 1e999}", "line 1");
  expect_refused("{ not json", "line 1, column ");
  expect_refused("{\"a\": 1} {", "line 1, column 10");
  expect_refused("", "line 1, column 1");
  expect_refused("[1, 2]", "is not a JSON object");
  expect_refused("7", "is not a JSON object");
}

TEST_F(JsonFile, HasNoKeyTwiceInOneObject) {
  expect_refused(R"({"a": 1, "b": 2, "a": 1})", "has \"a\" twice");
  expect_refused(R"({"o": {"k": 1, "k": 2}})", "has \"k\" twice");
}

}  // namespace
}  // namespace stof::dataset
