#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <span>
#include <string>

#include "hal/linux/open_error.h"

// libusb's own.
struct libusb_context;
struct libusb_device_handle;

namespace stof::hal::linux {

// Class, subclass, protocol of an interface.
struct UsbFunction {
  std::uint8_t kind = 0;
  std::uint8_t subkind = 0;
  std::uint8_t protocol = 0;
};

// One interface of one USB device, claimed through libusb, which does not look for devices itself
// (no udev). For one thread.
class UsbLink {
 public:
  // A request that is not answered by then has failed.
  static constexpr unsigned kRequestMs = 500;

  UsbLink() = default;
  ~UsbLink() { close(); }
  UsbLink(const UsbLink&) = delete;
  UsbLink& operator=(const UsbLink&) = delete;

  // `node`: such as /dev/bus/usb/001/004. An error is one line. Closed before.
  std::expected<void, OpenError> open(const std::string& node, const UsbFunction& function);
  // No transfer may be under way.
  void close() noexcept;
  bool is_open() const noexcept { return device_ != nullptr; }

  // Vendor requests to the interface; block for up to kRequestMs. False: another number of bytes,
  // or an error of libusb, which error() names.
  bool ask(std::uint8_t request, std::span<std::byte> answer) noexcept;
  bool tell(std::uint8_t request, std::uint16_t value, std::span<const std::byte> data) noexcept;
  const char* error() const noexcept;

  // Runs what has finished; waits for it no longer than `timeout_us`. `done`: not 0 ends the wait.
  // False: the device is gone. May allocate inside libusb (MarkedHeap).
  bool run(std::int64_t timeout_us, int& done) noexcept;

  libusb_device_handle* device() const noexcept { return device_; }
  std::uint16_t interface() const noexcept { return interface_; }

 private:
  bool find_interface(const UsbFunction& function) noexcept;

  int fd_ = -1;
  libusb_context* context_ = nullptr;
  libusb_device_handle* device_ = nullptr;
  std::uint16_t interface_ = 0;
  bool claimed_ = false;
  int error_ = 0;  // libusb's
};

}  // namespace stof::hal::linux
