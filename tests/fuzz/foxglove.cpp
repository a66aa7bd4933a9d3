#include <array>
#include <chrono>
#include <memory>
#include <string_view>
#include <vector>

#include "host/viewer/foxglove/foxglove_channels.h"
#include "host/viewer/foxglove/foxglove_message.h"
#include "tests/fuzz/fuzz_input.h"

// What clients of the Foxglove protocol say: a record of the input is a message of one of four of
// them, and what is due to it goes out behind. A topic is wanted as long as somebody subscribes to
// it, and by nobody when all have left.
namespace stof {
namespace {

constexpr std::size_t kClients = 4;

void send_due(viewer::Conversation& client) {
  std::vector<std::uint8_t> bytes;
  while (const auto kind = client.next(bytes)) {
    fuzz::require(!bytes.empty());
    fuzz::require(*kind == viewer::MessageKind::kBinary || bytes.front() == '{');
    bytes.clear();
  }
}

}  // namespace
}  // namespace stof

void stof::fuzz::run(std::span<const std::byte> input) {
  viewer::FoxgloveChannels channels("fuzz", std::chrono::hours(1), [] {});
  std::array<std::unique_ptr<viewer::Conversation>, kClients> clients;
  for_each_record(input, [&](const Record& record) {
    auto& client = clients[record.peer()];
    if (!client) {
      client = channels.open_conversation();
      send_due(*client);
    }
    const std::size_t size = std::min(record.bytes.size(), viewer::kMaxPageMessage);
    if (!client->take({reinterpret_cast<const char*>(record.bytes.data()), size})) {
      client.reset();  // the connection ends
      return;
    }
    const auto topic = static_cast<bridge::Topic>(record.seconds() % bridge::kTopics);
    if (channels.wanted(topic)) {
      static_cast<void>(channels.publish(topic, recording::Buffer(record.seconds())));
    }
    send_due(*client);
  });
  clients = {};
  for (std::size_t k = 0; k < bridge::kTopics; ++k) {
    require(!channels.wanted(static_cast<bridge::Topic>(k)));
  }
}
