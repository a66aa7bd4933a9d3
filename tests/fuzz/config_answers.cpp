#include <optional>
#include <string>
#include <utility>

#include "host/cli/config/settings_text.h"
#include "host/client/printable.h"
#include "tests/fuzz/control_answers.h"

// What a sensor answers to `stof config`: packets in any order, a document of any text.
namespace stof {
namespace {

void walk(const std::string& text) {
  const std::string shown = client::printable(text, client::Lines::kSeveral);
  fuzz::require(shown.find_first_of("\x1b\x07\x7f\r") == std::string::npos);
  fuzz::require(client::printable(shown, client::Lines::kSeveral) == shown);
  if (const std::optional<host::Json> document = host::read_json(text)) {
    static_cast<void>(host::settings_diff(*document, host::Json::object()));
    static_cast<void>(document->dump(2));
  }
}

}  // namespace
}  // namespace stof

void stof::fuzz::run(std::span<const std::byte> input) {
  const auto* const begin = reinterpret_cast<const char*>(input.data());
  walk(std::string(begin, begin + input.size()));
  for (const auto operation : {wire::SettingsOperation::kGet, wire::SettingsOperation::kSave}) {
    client::ControlClient client(std::make_unique<Answers>(input));
    if (const auto answer = client.request(operation, {}, {})) {
      walk(answer->text);
    }
  }
}
