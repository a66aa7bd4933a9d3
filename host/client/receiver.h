#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <memory>
#include <string>

#include "dsp/base/status.h"
#include "host/client/frame.h"
#include "host/client/reassembler.h"
#include "host/client/statistics.h"

namespace stof::client {

inline constexpr std::uint16_t kDefaultPort = 7560;

struct ReceiverOptions {
  std::string address = "0.0.0.0";    // IPv4 or IPv6 literal of the interface to listen at
  std::uint16_t port = kDefaultPort;  // 0: any free one, see Receiver::port()
  int socket_buffer = 4 << 20;        // bytes asked of the system
  ReassemblerOptions reassembler{};
};

// One line for a person: what, where, what to do.
struct OpenError {
  Status status;
  std::string message;
};

// Receives the frames of one sensor. For one thread.
class Receiver {
 public:
  // kInvalidArgument: not an address; kDeviceError: the port cannot be had.
  static std::expected<Receiver, OpenError> open(const ReceiverOptions& options);

  Receiver(Receiver&&) noexcept;
  Receiver& operator=(Receiver&&) noexcept;
  ~Receiver();

  // The next frame, valid until the next call. Blocks no longer than `timeout`; with 0 it only
  // looks. kTimeout: none was finished; kDeviceLost: the socket failed, open again.
  // Call it often: what the socket's buffer cannot hold in between is lost (socket_drops).
  Result<Frame> next(Duration timeout);

  const Statistics& statistics() const noexcept;
  std::uint16_t port() const noexcept;

  // What the system granted of ReceiverOptions::socket_buffer.
  int socket_buffer() const noexcept;
  // Empty, or what to change on this machine to lose less, in one line.
  std::string advice() const;

 private:
  struct Parts;
  explicit Receiver(std::unique_ptr<Parts> parts) noexcept;
  std::unique_ptr<Parts> parts_;
};

}  // namespace stof::client
