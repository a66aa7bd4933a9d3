#include "hal/linux/usb/usb_link.h"

#include <array>
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <libusb-1.0/libusb.h>
#include <unistd.h>

#include "hal/linux/system/heap_watch.h"
#include "hal/linux/usb/pmd_wire.h"

namespace stof::hal::linux {
namespace {

const char* advice(int error) noexcept {
  switch (error) {
    case EACCES:
    case EPERM:
      return "give this user the device by a udev rule, or run as root";
    case ENOENT:
    case ENODEV:
      return "it was unplugged just now: check cable and power";
    default:
      return "unplug it and plug it in again";
  }
}

}  // namespace

std::expected<void, OpenError> UsbLink::open(const std::string& node, const UsbFunction& function) {
  close();
  const auto refused = [&](const std::string& why) {
    close();
    return std::unexpected(OpenError{"USB device '" + node + "': " + why});
  };
  fd_ = ::open(node.c_str(), O_RDWR | O_CLOEXEC);
  if (fd_ < 0) {
    const int error = errno;
    return refused(std::string(std::strerror(error)) + "; " + advice(error));
  }
  // For the contexts that are made from here on. NOLINTNEXTLINE: libusb's interface
  libusb_set_option(nullptr, LIBUSB_OPTION_NO_DEVICE_DISCOVERY);
  error_ = libusb_init(&context_);
  if (error_ != 0) {
    context_ = nullptr;
    return refused(std::string("libusb does not start: ") + error());
  }
  error_ = libusb_wrap_sys_device(context_, fd_, &device_);
  if (error_ != 0) {
    device_ = nullptr;
    return refused(std::string(error()) + "; unplug it and plug it in again");
  }
  if (!find_interface(function)) {
    return refused("has no interface of a PMD camera; check the numbers in the board's table");
  }
  error_ = libusb_claim_interface(device_, interface_);
  if (error_ != 0) {
    return refused(std::string(error()) + "; another program or driver has it: end that first");
  }
  claimed_ = true;
  return {};
}

bool UsbLink::find_interface(const UsbFunction& function) noexcept {
  libusb_config_descriptor* config = nullptr;
  error_ = libusb_get_active_config_descriptor(libusb_get_device(device_), &config);
  if (error_ != 0) {
    return false;
  }
  bool found = false;
  for (const libusb_interface& interface : std::span(config->interface, config->bNumInterfaces)) {
    if (interface.num_altsetting < 1) {
      continue;
    }
    const libusb_interface_descriptor& usual = interface.altsetting[0];
    if (!found && usual.bInterfaceClass == function.kind &&
        usual.bInterfaceSubClass == function.subkind &&
        usual.bInterfaceProtocol == function.protocol) {
      interface_ = usual.bInterfaceNumber;
      found = true;
    }
  }
  libusb_free_config_descriptor(config);
  return found;
}

void UsbLink::close() noexcept {
  if (device_ != nullptr) {
    if (claimed_) {
      libusb_release_interface(device_, interface_);
    }
    libusb_close(device_);
  }
  if (context_ != nullptr) {
    libusb_exit(context_);
  }
  if (fd_ >= 0) {
    ::close(fd_);  // libusb leaves it to who opened it
  }
  device_ = nullptr;
  context_ = nullptr;
  claimed_ = false;
  fd_ = -1;
}

bool UsbLink::ask(std::uint8_t request, std::span<std::byte> answer) noexcept {
  const MarkedHeap libusb;
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): libusb's bytes
  auto* const bytes = reinterpret_cast<unsigned char*>(answer.data());
  const int got = libusb_control_transfer(device_, kPmdRequestIn, request, 0, interface_, bytes,
                                          static_cast<std::uint16_t>(answer.size()), kRequestMs);
  error_ = got < 0 ? got : 0;
  return got == static_cast<int>(answer.size());
}

bool UsbLink::tell(std::uint8_t request, std::uint16_t value,
                   std::span<const std::byte> data) noexcept {
  const MarkedHeap libusb;
  std::array<unsigned char, 64> bytes{};
  if (data.size() > bytes.size()) {
    return false;
  }
  if (!data.empty()) {
    std::memcpy(bytes.data(), data.data(), data.size());
  }
  const int put =
      libusb_control_transfer(device_, kPmdRequestOut, request, value, interface_, bytes.data(),
                              static_cast<std::uint16_t>(data.size()), kRequestMs);
  error_ = put < 0 ? put : 0;
  return put == static_cast<int>(data.size());
}

const char* UsbLink::error() const noexcept {
  return error_ == 0 ? "an answer of the wrong length" : libusb_strerror(error_);
}

bool UsbLink::run(std::int64_t timeout_us, int& done) noexcept {
  const MarkedHeap libusb;
  constexpr std::int64_t kPerSecond = 1'000'000;
  timeval limit{};
  limit.tv_sec = static_cast<time_t>(timeout_us / kPerSecond);
  limit.tv_usec = static_cast<suseconds_t>(timeout_us % kPerSecond);
  error_ = libusb_handle_events_timeout_completed(context_, &limit, &done);
  return error_ == 0 || error_ == LIBUSB_ERROR_INTERRUPTED || error_ == LIBUSB_ERROR_TIMEOUT;
}

}  // namespace stof::hal::linux
