#include <optional>
#include <string>
#include <utility>

#include "host/cli/config/settings_text.h"
#include "host/client/control/control_client.h"
#include "host/client/printable.h"
#include "tests/fuzz/fuzz_input.h"

// What a sensor answers to `stof config`: packets in any order, a document of any text.
namespace stof {
namespace {

// Gives the input's records one by one. A sealed one answers the newest request.
class Answers final : public client::ControlTransport {
 public:
  explicit Answers(std::span<const std::byte> input) {
    fuzz::for_each_record(input, [this](const fuzz::Record& record) {
      wire::DatagramBuffer space{};
      const bool seal = (record.flags & fuzz::kSeal) != 0;
      const auto packet = seal ? fuzz::sealed(record.bytes, space) : record.bytes;
      packets_.emplace_back(packet.begin(), packet.end());
    });
  }

  Status send(std::span<const std::byte> packet) override {
    request_id_ = wire::get_u32(packet.subspan(wire::kHeaderBytes).first<4>());
    return Status::kOk;
  }
  Result<std::vector<std::byte>> receive(client::Duration /*timeout*/) override {
    if (next_ == packets_.size()) {
      return fail(Status::kDeviceLost);
    }
    std::vector<std::byte> packet = packets_[next_++];
    if (packet.size() >= wire::kHeaderBytes + 4 + wire::kCrcBytes && wire::parse_packet(packet)) {
      const std::span<std::byte> bytes(packet);
      wire::put_u32(bytes.subspan(wire::kHeaderBytes).first<4>(), request_id_);
      wire::put_u32(bytes.last<4>(), wire::crc32c(bytes.first(bytes.size() - 4)));
    }
    return packet;
  }
  std::string place() const override { return "fuzz"; }

 private:
  std::vector<std::vector<std::byte>> packets_;
  std::size_t next_ = 0;
  std::uint32_t request_id_ = 0;
};

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
