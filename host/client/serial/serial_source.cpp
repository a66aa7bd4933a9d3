#include "host/client/serial/serial_source.h"

#include <algorithm>
#include <array>
#include <chrono>

#include "posix/poll.h"

namespace stof::client {

Result<std::size_t> SerialSource::receive() {
  read_.clear();
  while (read_.size() < kMostAtOnce) {
    Result<SerialLine::Packet> packet = line_->take(SerialLine::For::kReceiver, Duration(0));
    if (packet) {
      read_.push_back(*std::move(packet));
    } else if (packet.error() == Status::kTimeout || !read_.empty()) {
      break;
    } else {
      return fail(packet.error());
    }
  }
  return read_.size();
}

Status SerialSource::wait(Duration timeout) const {
  // Who asks may read what is for us: look again soon.
  constexpr Duration kLook = std::chrono::milliseconds(20);
  const Time deadline = Time::clock::now() + timeout;
  while (true) {
    if (holds_packets()) {
      return Status::kOk;
    }
    std::array entries{pollfd{.fd = fd(), .events = POLLIN, .revents = 0}};
    const Time now = Time::clock::now();
    const auto ready =
        posix::wait_for(entries, std::min<Duration>(kLook, std::max(deadline - now, Duration(0))));
    if (!ready || (entries[0].revents & POLLNVAL) != 0) {
      return Status::kDeviceLost;
    }
    if (*ready > 0) {
      return Status::kOk;  // also that it was pulled out, which receive() finds
    }
    if (now >= deadline) {
      return Status::kTimeout;
    }
  }
}

}  // namespace stof::client
