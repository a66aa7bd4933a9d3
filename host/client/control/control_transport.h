#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/base/status.h"
#include "host/client/error.h"
#include "host/client/frame/frame.h"

namespace stof::client {

enum class Reach : std::uint8_t {
  kAddress,  // nobody but those on the way hears what is asked
  kLink,     // all of a link hear it, and may answer
  kLine,     // a serial line
};

// By address: how long the sensor's own answer is waited for behind a refusal that nobody signed,
// and that somebody on the way may have made up.
inline constexpr Duration kBehindARefusal = std::chrono::seconds(1);

// Carries whole packets to a sensor and back: UDP (open_udp_transport) or a serial line.
class ControlTransport {
 public:
  virtual ~ControlTransport() = default;
  // One sealed packet, at most wire::kMaxDatagram bytes. kDeviceError: nobody can be reached now;
  // kDeviceLost: the socket or line failed.
  virtual Status send(std::span<const std::byte> packet) = 0;
  // The next packet, any bytes, of any type. kTimeout; kDeviceError: nobody listens there (ask
  // again); kDeviceLost.
  virtual Result<std::vector<std::byte>> receive(Duration timeout) = 0;
  // For messages: "192.168.1.20:7560".
  virtual std::string place() const = 0;
  // Numeric, of the host that sent what receive() gave last; empty: it is not known.
  virtual std::string from() const { return {}; }
  virtual Reach reach() const { return Reach::kAddress; }
};

// The next packet until `deadline`, and what lies there behind it. kTimeout: there is none. Others
// as receive(). behind: 0 at the first call for a deadline, then left alone; it bounds a flood.
Result<std::vector<std::byte>> receive_until(ControlTransport& transport, Time deadline,
                                             int& behind);

using ControlError = OpenError;

// What to look after where nobody answers, for a message.
const char* to_check(Reach reach) noexcept;

// Cookies that were offered where anybody may offer one: each is tried.
class OfferedCookies {
 public:
  void add(std::uint64_t cookie);
  // The next one; nothing: all were tried.
  std::optional<std::uint64_t> take();
  void clear() noexcept { offered_.clear(); }

 private:
  std::vector<std::uint64_t> offered_;  // in the order of their coming
};

// sensor: HOST[:PORT], port 7560 without; an IPv6 address with a port in brackets. May block on a
// name server. kInvalidArgument: not such a thing, kDeviceError: no such host or no network.
std::expected<std::unique_ptr<ControlTransport>, ControlError> open_udp_transport(
    std::string_view sensor);

}  // namespace stof::client
