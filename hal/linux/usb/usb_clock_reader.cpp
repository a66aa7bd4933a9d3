#include "hal/linux/usb/usb_clock_reader.h"

#include <span>

#include <libusb-1.0/libusb.h>

#include "hal/linux/system/clock.h"
#include "hal/linux/system/heap_watch.h"
#include "hal/linux/usb/pmd_wire.h"

namespace stof::hal::linux {
namespace {

constexpr int kTries = 8;
constexpr unsigned kAnswerMs = 1000;
constexpr std::uint8_t kRequest = static_cast<std::uint8_t>(PmdRequest::kClock);

}  // namespace

bool UsbClockReader::read_now(UsbLink& link) noexcept {
  clock_.reset();
  for (int i = 0; i < kTries; ++i) {
    std::array<std::byte, kPmdClockBytes> answer{};
    const Time before = Clock().now();
    if (!link.ask(kRequest, answer)) {
      return false;
    }
    const Time after = Clock().now();
    clock_.sync(before, *parse_pmd_clock(answer), after);
    asked_ = after;
  }
  return true;
}

bool UsbClockReader::begin(const UsbLink& link, int& progress) noexcept {
  progress_ = &progress;
  transfer_ = libusb_alloc_transfer(0);
  if (transfer_ == nullptr) {
    return false;
  }
  libusb_fill_control_setup(space_.data(), kPmdRequestIn, kRequest, 0, link.interface(),
                            kPmdClockBytes);
  libusb_fill_control_transfer(transfer_, link.device(), space_.data(), on_answer, this, kAnswerMs);
  return true;
}

void UsbClockReader::ask() noexcept {
  const Time now = Clock().now();
  if (pending_ || now - asked_ < kEvery) {
    return;
  }
  const MarkedHeap libusb;
  asked_ = now;
  pending_ = libusb_submit_transfer(transfer_) == 0;
}

void UsbClockReader::cancel() noexcept {
  if (pending_) {
    static_cast<void>(libusb_cancel_transfer(transfer_));
  }
}

void UsbClockReader::end() noexcept {
  if (!pending_) {
    libusb_free_transfer(transfer_);
  }
  transfer_ = nullptr;
  pending_ = false;
}

// libusb calls it while events are handled.
void UsbClockReader::on_answer(libusb_transfer* done) {
  UsbClockReader& self = *static_cast<UsbClockReader*>(done->user_data);
  self.pending_ = false;
  *self.progress_ = 1;
  const auto answer = std::as_bytes(std::span(self.space_)).last<kPmdClockBytes>();
  if (done->status == LIBUSB_TRANSFER_COMPLETED &&
      done->actual_length == static_cast<int>(kPmdClockBytes)) {
    self.clock_.sync(self.asked_, *parse_pmd_clock(answer), Clock().now());
  }
}

}  // namespace stof::hal::linux
