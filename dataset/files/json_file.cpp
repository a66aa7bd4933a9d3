#include "dataset/files/json_file.h"

#include <algorithm>
#include <cstdint>
#include <set>
#include <vector>

#include "dataset/files/file.h"

namespace stof::dataset {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxBytes = 1U << 20;

// Takes the parser's events: the parser itself keeps the last of two equal keys.
class Checker final : public nlohmann::json_sax<json> {
 public:
  const std::string& twice() const { return twice_; }
  std::size_t wrong_at() const { return wrong_at_; }  // how far the parser came

  bool null() override { return true; }
  bool boolean(bool /*value*/) override { return true; }
  bool number_integer(number_integer_t /*value*/) override { return true; }
  bool number_unsigned(number_unsigned_t /*value*/) override { return true; }
  bool number_float(number_float_t /*value*/, const string_t& /*text*/) override { return true; }
  bool string(string_t& /*value*/) override { return true; }
  bool binary(binary_t& /*value*/) override { return true; }
  bool start_array(std::size_t /*elements*/) override { return true; }
  bool end_array() override { return true; }

  bool start_object(std::size_t /*elements*/) override {
    keys_.emplace_back();
    return true;
  }
  bool key(string_t& name) override {
    if (!keys_.back().insert(name).second) {
      twice_ = name;
    }
    return twice_.empty();
  }
  bool end_object() override {
    keys_.pop_back();
    return true;
  }
  bool parse_error(std::size_t position, const std::string& /*token*/,
                   const json::exception& /*error*/) override {
    wrong_at_ = position;
    return false;
  }

 private:
  std::vector<std::set<std::string>> keys_;  // of the objects that are open
  std::string twice_;
  std::size_t wrong_at_ = 0;
};

// Both from 1. `count`: of the bytes up to there, that one included.
std::string place_of(const std::string& text, std::size_t count) {
  const std::string before = text.substr(0, count == 0 ? 0 : count - 1);
  const auto line = 1 + std::ranges::count(before, '\n');
  const std::size_t column = before.size() - (before.rfind('\n') + 1) + 1;
  return "line " + std::to_string(line) + ", column " + std::to_string(column);
}

}  // namespace

Loaded<std::string> read_object_text(const std::filesystem::path& file) {
  Loaded<std::string> text = read_whole(file, kMaxBytes);
  if (!text) {
    return text;
  }
  Checker checker;
  const bool whole = json::sax_parse(*text, &checker);
  if (!checker.twice().empty()) {
    return refuse(file, "has \"" + checker.twice() + "\" twice", "keep one of them");
  }
  if (!whole) {
    return refuse(file, "is not a JSON object (" + place_of(*text, checker.wrong_at()) + ")",
                  "correct it there");
  }
  if (const std::size_t first = text->find_first_not_of(" \t\r\n");
      first == std::string::npos || (*text)[first] != '{') {
    return refuse(file, "is not a JSON object", "correct the file");
  }
  return text;
}

Loaded<json> read_object(const std::filesystem::path& file) {
  const Loaded<std::string> text = read_object_text(file);
  if (!text) {
    return std::unexpected(text.error());
  }
  return json::parse(*text, nullptr, false);
}

}  // namespace stof::dataset
