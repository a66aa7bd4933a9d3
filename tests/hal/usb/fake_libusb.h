#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "hal/linux/system/clock.h"
#include "hal/linux/usb/pmd_wire.h"

struct libusb_transfer;  // NOLINT(readability-identifier-naming): the library's name

namespace stof::test {

// A PMD camera behind a libusb that this test program defines itself (fake_libusb.cpp): the kernel
// fills transfers that are under way from what the camera has to send, whether or not anybody
// handles events. There is one at a time. A member for each thing that a test makes go wrong.
class FakeUsbCamera {
 public:
  static constexpr std::uint64_t kAhead = 123'456'789'000;  // its clock, of the monotonic one

  // What is wrong with the next frame.
  enum class Wrong : std::uint8_t {
    kNothing,
    kShort,
    kLong,
    kMagic,
    kSequence,
    kStamp,
    kError,
    kStall,
    kOverflow,
  };

  FakeUsbCamera();
  ~FakeUsbCamera();
  FakeUsbCamera(const FakeUsbCamera&) = delete;
  FakeUsbCamera& operator=(const FakeUsbCamera&) = delete;

  // The sysfs folder with this device in it, and the folder with its node.
  const std::string& sysfs() const { return sysfs_; }
  const std::string& nodes() const { return nodes_; }

  void expose(hal::Time edge, Wrong wrong = Wrong::kNothing);
  void unplug() { plugged = false; }
  std::uint64_t clock_at(hal::Time time) const {
    return static_cast<std::uint64_t>(time.time_since_epoch().count()) + kAhead +
           static_cast<std::uint64_t>(clock_shift);
  }

  hal::linux::PmdInfo info{.width = 12,
                           .height = 7,
                           .bits = 12,
                           .least_khz = 1000,
                           .most_khz = 100'000,
                           .least_integration_us = 10,
                           .most_integration_us = 5000,
                           .serial = 77};
  hal::linux::PmdConfig config;
  std::int64_t clock_shift = 0;
  bool plugged = true;
  bool streaming = false;
  bool refuses_config = false;
  bool answers = true;  // requests
  bool damaged_info = false;
  int claim_error = 0;
  int open_devices = 0;
  int transfers = 0;  // allocated
  int halts_cleared = 0;
  std::uint32_t sequence = 0;

  struct Message {
    std::vector<std::byte> bytes;
    Wrong wrong = Wrong::kNothing;
    hal::Time ready{};
  };
  std::deque<Message> messages;
  std::vector<libusb_transfer*> under_way;

 private:
  std::string root_;
  std::string sysfs_;
  std::string nodes_;
};

}  // namespace stof::test
