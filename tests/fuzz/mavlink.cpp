#include <algorithm>
#include <optional>

#include "firmware/serial/mavlink/mavlink_reader.h"
#include "tests/fuzz/fuzz_input.h"

// Bytes of a MAVLink line. However they are cut into pieces, the same messages come out.
namespace stof {
namespace {

struct Seen {
  std::uint64_t messages = 0;
  std::uint64_t skipped = 0;
  unsigned sum = 0;
  friend bool operator==(const Seen&, const Seen&) = default;
};

Seen read(std::span<const std::byte> line, std::size_t piece) {
  firmware::mavlink::Reader reader;
  firmware::mavlink::Autopilot autopilot;
  unsigned sum = 0;
  while (!line.empty()) {
    std::span<const std::byte> now = line.first(std::min(piece, line.size()));
    line = line.subspan(now.size());
    while (const std::optional<firmware::mavlink::Message> message = reader.take(now)) {
      fuzz::require(message->version == 1 || message->version == 2);
      sum = 31 * sum + fuzz::touch(message->payload) + message->id;
      firmware::mavlink::note_message(*message, {}, autopilot);
    }
    fuzz::require(now.empty());
  }
  return {.messages = reader.counters().messages, .skipped = reader.counters().skipped, .sum = sum};
}

}  // namespace
}  // namespace stof

void stof::fuzz::run(std::span<const std::byte> input) {
  require(read(input, 1) == read(input, 1 + input.size()));
}
