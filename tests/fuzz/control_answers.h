#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "host/client/control/control_client.h"
#include "tests/fuzz/fuzz_input.h"

namespace stof::fuzz {

// What a sensor answers to who asks: gives the input's records one by one. A sealed one answers the
// newest request.
class Answers final : public client::ControlTransport {
 public:
  explicit Answers(std::span<const std::byte> input) {
    for_each_record(input, [this](const Record& record) {
      wire::DatagramBuffer space{};
      const bool seal = (record.flags & kSeal) != 0;
      const auto packet = seal ? sealed(record.bytes, space) : record.bytes;
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

}  // namespace stof::fuzz
