#include "firmware/serial/line/line_speed.h"

#include "firmware/serial/line/line_writer.h"

namespace stof::firmware {
void LineSpeed::want(std::uint32_t baud) noexcept {
  wanted_ = baud;
  if (baud_ == 0) {
    baud_ = baud;
  }
}

Result<bool> LineSpeed::tick(hal::SerialPort& port, bool idle, hal::Time now) noexcept {
  if (wanted_ == baud_) {
    change_at_.reset();
    return false;
  }
  if (!change_at_) {
    change_at_ = now + kLongestTurn + line_time(kDriverBytes + 2 * LineWriter::kFrameBytes, baud_);
  }
  if (now < *change_at_ || !idle) {
    return false;
  }
  change_at_.reset();
  const Status status = port.set_baud(wanted_);
  if (status == Status::kDeviceLost) {
    return fail(status);
  }
  refused_.store(status != Status::kOk, std::memory_order_relaxed);
  baud_ = status == Status::kOk ? wanted_ : baud_;
  wanted_ = baud_;
  return true;
}

}  // namespace stof::firmware
