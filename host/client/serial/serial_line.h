#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <expected>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/framing/cobs.h"
#include "host/client/control/control_client.h"
#include "host/client/error.h"
#include "host/client/frame/frame.h"
#include "posix/fd.h"

namespace stof::client {

inline constexpr unsigned kDefaultBaud = 921'600;  // as serial.baud of docs/SETTINGS.md

// A serial line to a sensor (docs/WIRE.md, "Serial lines"): COBS frames, 8N1, any speed that the
// driver can make. Two may read it at a time, each on a thread of its own: who asks, and who
// receives. What one of them reads for the other waits for that one.
class SerialLine {
 public:
  // kDeviceError: no such line, or not a line.
  static std::expected<std::shared_ptr<SerialLine>, OpenError> open(const std::string& device,
                                                                    unsigned baud = kDefaultBaud);

  enum class For : std::uint8_t {
    kReceiver,  // what a sensor sends by itself
    kAsker,     // all else: answers, and what nobody knows
  };
  struct Packet {
    std::vector<std::byte> bytes{};
    Time arrived{};
  };

  // One packet of at most wire::kMaxDatagram bytes, whole; blocks for a second at most. From any
  // thread. kTooLarge; kDeviceError: the line takes nothing; kDeviceLost.
  Status send(std::span<const std::byte> packet);
  // The next packet for one of them; with 0 it only looks. kTimeout; kDeviceLost.
  Result<Packet> take(For whom, Duration timeout);
  // Whether take() would return one at once, of what was read already.
  bool holds(For whom) const;
  // Until then nothing is kept for a receiver.
  void begin_receiving() { receives_ = true; }

  int fd() const noexcept { return line_.get(); }
  const std::string& device() const noexcept { return device_; }
  // Packets for a receiver that took them too late: the oldest ones go.
  std::uint64_t dropped() const;

 private:
  static constexpr std::size_t kMostWaiting = 512;

  SerialLine(posix::Fd line, std::string device)
      : line_(std::move(line)), device_(std::move(device)) {}
  std::deque<Packet>& queue(For whom) { return waiting_[static_cast<std::size_t>(whom)]; }
  Status read();  // with mutex_
  Status wait(short events, Time deadline) const;

  posix::Fd line_;
  std::string device_;
  std::atomic<bool> receives_{false};
  std::mutex sending_;
  mutable std::mutex mutex_;  // of all that follows
  hal::CobsReader reader_;
  std::array<std::byte, 4096> space_{};
  std::array<std::deque<Packet>, 2> waiting_;
  std::uint64_t dropped_ = 0;
};

// For who asks over it.
std::unique_ptr<ControlTransport> serial_transport(std::shared_ptr<SerialLine> line);
// The same over a line of its own. As SerialLine::open().
std::expected<std::unique_ptr<ControlTransport>, ControlError> open_serial_transport(
    const std::string& device, unsigned baud);

}  // namespace stof::client
