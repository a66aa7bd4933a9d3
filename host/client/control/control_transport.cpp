#include "host/client/control/control_transport.h"

#include <algorithm>
#include <utility>

#include "host/client/sensor_socket.h"

namespace stof::client {
namespace {

constexpr int kMostBehind = 64;  // packets that are looked at behind a deadline

class UdpTransport final : public ControlTransport {
 public:
  explicit UdpTransport(std::unique_ptr<SensorSocket> socket) : socket_(std::move(socket)) {}

  Status send(std::span<const std::byte> packet) override { return socket_->send(packet); }

  Result<std::vector<std::byte>> receive(Duration timeout) override {
    if (next_ == read_) {
      Result<std::size_t> read = socket_->receive();
      if (read && *read == 0 && !socket_->take_refusal()) {
        if (const Status waited = socket_->wait(timeout); waited != Status::kOk) {
          return fail(waited);
        }
        read = socket_->receive();
      }
      if (!read) {
        return fail(read.error());
      }
      next_ = 0;
      read_ = *read;
      if (read_ == 0) {
        return fail(Status::kDeviceError);
      }
    }
    const std::span<const std::byte> datagram = socket_->packet(next_++);
    return std::vector<std::byte>(datagram.begin(), datagram.end());
  }

  std::string place() const override { return socket_->place(); }

 private:
  std::unique_ptr<SensorSocket> socket_;
  std::size_t read_ = 0;
  std::size_t next_ = 0;
};

}  // namespace

std::expected<std::unique_ptr<ControlTransport>, ControlError> open_udp_transport(
    std::string_view sensor) {
  constexpr int kBuffer = 1 << 16;
  auto socket = SensorSocket::connect(sensor, kBuffer);
  if (!socket) {
    return std::unexpected(std::move(socket.error()));
  }
  return std::make_unique<UdpTransport>(std::move(*socket));
}

Result<std::vector<std::byte>> receive_until(ControlTransport& transport, Time deadline,
                                             int& behind) {
  for (;;) {
    const Duration left = deadline - Time::clock::now();
    const bool over = left <= Duration::zero();
    if (over && ++behind > kMostBehind) {
      return fail(Status::kTimeout);
    }
    Result<std::vector<std::byte>> bytes = transport.receive(std::max(left, Duration::zero()));
    if (bytes || bytes.error() != Status::kTimeout || over) {
      return bytes;
    }
  }
}

const char* to_check(Reach reach) noexcept {
  return reach == Reach::kLine ? "check that the sensor runs, the line and its speed"
                               : "check that the sensor runs, and its address";
}

void OfferedCookies::add(std::uint64_t cookie) {
  constexpr std::size_t kMost = 8;
  if (offered_.size() < kMost && std::ranges::find(offered_, cookie) == offered_.end()) {
    offered_.push_back(cookie);
  }
}

std::optional<std::uint64_t> OfferedCookies::take() {
  if (offered_.empty()) {
    return std::nullopt;
  }
  const std::uint64_t cookie = offered_.front();
  offered_.erase(offered_.begin());
  return cookie;
}

}  // namespace stof::client
