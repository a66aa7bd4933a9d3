#pragma once

#include <array>

#include "hal/linux/usb/clock_converter.h"
#include "hal/linux/usb/usb_link.h"
#include "hal/time.h"

struct libusb_transfer;  // NOLINT(readability-identifier-naming): libusb's own

namespace stof::hal::linux {

// The clock of a PMD camera, which is read over USB: several times before it streams, then once a
// second beside its frames. For one thread; calls of libusb allocate (MarkedHeap).
class UsbClockReader {
 public:
  static constexpr Duration kEvery = std::chrono::seconds(1);

  UsbClockReader() = default;
  UsbClockReader(const UsbClockReader&) = delete;
  UsbClockReader& operator=(const UsbClockReader&) = delete;

  // Reads it anew. False: it does not answer, link.error() says why.
  bool read_now(UsbLink& link) noexcept;
  // Readies ask(). progress: set to 1 by each answer, outlives end(). False: no memory.
  bool begin(const UsbLink& link, int& progress) noexcept;
  // Asks, where a second has passed since the last time.
  void ask() noexcept;
  // A question is under way.
  bool pending() const noexcept { return pending_; }
  void cancel() noexcept;
  // A question that has not come back stays with libusb: to free it would be worse than to lose it.
  void end() noexcept;

  ClockConverter& clock() noexcept { return clock_; }
  const ClockConverter& clock() const noexcept { return clock_; }

 private:
  static void on_answer(libusb_transfer* done);

  ClockConverter clock_;
  libusb_transfer* transfer_ = nullptr;
  std::array<unsigned char, 16> space_{};  // a request and its answer
  Time asked_{};
  bool pending_ = false;
  int* progress_ = nullptr;
};

}  // namespace stof::hal::linux
