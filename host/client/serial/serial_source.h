#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/client/packet_source.h"
#include "host/client/serial/serial_line.h"

namespace stof::client {

// What a sensor sends over a serial line, for a receiver. There is no subscription on it: the
// sensor's settings serial.* say what it sends.
class SerialSource final : public PacketSource {
 public:
  explicit SerialSource(std::shared_ptr<SerialLine> line) : line_(std::move(line)) {
    line_->begin_receiving();
  }

  Status send(std::span<const std::byte> /*packet*/) override { return Status::kUnsupported; }
  Result<std::size_t> receive() override;
  std::span<const std::byte> packet(std::size_t index) const override { return read_[index].bytes; }
  Time arrived(std::size_t index) const override { return read_[index].arrived; }
  const posix::SocketAddress* from(std::size_t /*index*/) const override { return nullptr; }

  Status wait(Duration timeout) const override;
  bool holds_packets() const override { return line_->holds(SerialLine::For::kReceiver); }
  int fd() const override { return line_->fd(); }
  const std::string& place() const override { return line_->device(); }
  std::uint64_t dropped() const override { return line_->dropped(); }

 private:
  static constexpr std::size_t kMostAtOnce = 64;

  std::shared_ptr<SerialLine> line_;
  std::vector<SerialLine::Packet> read_;
};

}  // namespace stof::client
