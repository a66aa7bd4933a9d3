#include "tests/hal/usb/fake_libusb.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>

#include <libusb-1.0/libusb.h>

#include "hal/linux/usb/usb_pmd.h"
#include "tests/hal/usb/pmd_wire_peer.h"

// NOLINTBEGIN(readability-identifier-naming): libusb's names
struct libusb_context {};
struct libusb_device {};
struct libusb_device_handle {
  libusb_device device;
};
// NOLINTEND(readability-identifier-naming)

namespace stof::test {
namespace {

using hal::linux::PmdRequest;
using Wrong = FakeUsbCamera::Wrong;

FakeUsbCamera* camera = nullptr;

void write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path) << text << '\n';
}

// What the kernel has finished.
struct Done {
  libusb_transfer* transfer = nullptr;
  libusb_transfer_status status = LIBUSB_TRANSFER_COMPLETED;
};
std::vector<Done> done;

void finish(libusb_transfer* transfer, libusb_transfer_status status, int bytes = 0) {
  transfer->actual_length = bytes;
  std::erase(camera->under_way, transfer);
  done.push_back({transfer, status});
}

libusb_transfer_status status_of(Wrong wrong) {
  switch (wrong) {
    case Wrong::kError:
      return LIBUSB_TRANSFER_ERROR;
    case Wrong::kStall:
      return LIBUSB_TRANSFER_STALL;
    case Wrong::kOverflow:
      return LIBUSB_TRANSFER_OVERFLOW;
    default:
      return LIBUSB_TRANSFER_COMPLETED;
  }
}

int answer(std::uint8_t request, unsigned char* data, int length) {
  const auto copy = [&](const auto& bytes) {
    const int count = std::min(length, static_cast<int>(bytes.size()));
    std::memcpy(data, bytes.data(), static_cast<std::size_t>(count));
    return count;
  };
  switch (static_cast<PmdRequest>(request)) {
    case PmdRequest::kInfo: {
      auto bytes = compose_pmd_info(camera->info);
      bytes[0] ^= std::byte{camera->damaged_info ? std::uint8_t{1} : std::uint8_t{0}};
      return copy(bytes);
    }
    case PmdRequest::kClock: {
      const std::uint64_t now = camera->clock_at(hal::linux::Clock().now());
      std::array<std::uint8_t, 8> bytes{};
      for (std::size_t i = 0; i < bytes.size(); ++i) {
        bytes[i] = static_cast<std::uint8_t>(now >> (8 * i));
      }
      return copy(bytes);
    }
    case PmdRequest::kGetConfig:
      return copy(compose_pmd_config(camera->config));
    default:
      return LIBUSB_ERROR_PIPE;
  }
}

int obey(std::uint8_t request, std::uint16_t value, const unsigned char* data, int length) {
  if (static_cast<PmdRequest>(request) == PmdRequest::kStream) {
    camera->streaming = value == 1;
    camera->sequence = 0;
    camera->messages.clear();
    return 0;
  }
  const auto config = hal::linux::parse_pmd_config(
      std::as_bytes(std::span(data, static_cast<std::size_t>(length))));
  if (camera->refuses_config || !config) {
    return LIBUSB_ERROR_PIPE;
  }
  camera->config = *config;
  return length;
}

// The kernel's part: moves what is ready into transfers that wait for it.
void serve() {
  if (!camera->plugged) {
    while (!camera->under_way.empty()) {
      finish(camera->under_way.front(), LIBUSB_TRANSFER_NO_DEVICE);
    }
    return;
  }
  for (;;) {
    const auto bulk = std::ranges::find(camera->under_way, LIBUSB_TRANSFER_TYPE_BULK,
                                        [](const libusb_transfer* t) { return t->type; });
    if (bulk == camera->under_way.end() || camera->messages.empty() ||
        camera->messages.front().ready > hal::linux::Clock().now()) {
      break;
    }
    libusb_transfer* const transfer = *bulk;
    const FakeUsbCamera::Message message = camera->messages.front();
    camera->messages.pop_front();
    const int bytes = std::min(transfer->length, static_cast<int>(message.bytes.size()));
    std::memcpy(transfer->buffer, message.bytes.data(), static_cast<std::size_t>(bytes));
    finish(transfer, status_of(message.wrong), bytes);
  }
  const std::vector<libusb_transfer*> waiting = camera->under_way;
  for (libusb_transfer* const transfer : waiting) {
    if (transfer->type == LIBUSB_TRANSFER_TYPE_CONTROL) {
      finish(transfer, LIBUSB_TRANSFER_COMPLETED,
             answer(transfer->buffer[1], transfer->buffer + 8, 8));
    }
  }
}

}  // namespace

FakeUsbCamera::FakeUsbCamera() {
  camera = this;
  std::string pattern = (std::filesystem::temp_directory_path() / "stof-usb-XXXXXX").string();
  root_ = mkdtemp(pattern.data());
  sysfs_ = root_ + "/sys";
  nodes_ = root_ + "/dev";
  std::filesystem::create_directories(sysfs_ + "/1-2");
  std::filesystem::create_directories(nodes_ + "/001");
  write_text(sysfs_ + "/1-2/idVendor", "1209");
  write_text(sysfs_ + "/1-2/idProduct", "0050");
  write_text(sysfs_ + "/1-2/busnum", "1");
  write_text(sysfs_ + "/1-2/devnum", "4");
  write_text(nodes_ + "/001/004", "");
}

FakeUsbCamera::~FakeUsbCamera() {
  std::filesystem::remove_all(root_);
  done.clear();
  camera = nullptr;
}

void FakeUsbCamera::expose(hal::Time edge, Wrong wrong) {
  if (!streaming || !plugged) {
    return;
  }
  constexpr std::uint32_t kStepNs = 200'000;
  hal::linux::PmdHeader header{
      .sequence = ++sequence, .modulation_khz = config.modulation_khz, .edge = clock_at(edge)};
  for (std::uint32_t k = 0; k < 4; ++k) {
    header.samples[k] = {.begin_ns = k * kStepNs, .length_ns = kStepNs};
  }
  header.sequence -= wrong == Wrong::kSequence ? 1 : 0;
  header.edge += wrong == Wrong::kStamp ? 10'000'000 : 0;
  const auto head = compose_pmd_header(header, info);
  Message message{.bytes = {head.begin(), head.end()},
                  .wrong = wrong,
                  .ready = edge + std::chrono::milliseconds(1)};
  const std::size_t size = head.size() + pmd_picture_bytes(info);
  while (message.bytes.size() < size) {
    message.bytes.push_back(static_cast<std::byte>(header.sequence));
  }
  if (wrong == Wrong::kShort || wrong == Wrong::kLong) {
    message.bytes.resize(wrong == Wrong::kShort ? size - 2 : size + 2);
  }
  message.bytes[0] ^= std::byte{wrong == Wrong::kMagic ? std::uint8_t{1} : std::uint8_t{0}};
  messages.push_back(message);
}

}  // namespace stof::test

using stof::test::camera;
using stof::test::done;

extern "C" {
// NOLINTBEGIN(readability-identifier-naming, readability-inconsistent-declaration-parameter-name)
int libusb_set_option(libusb_context* /*context*/, libusb_option option, ...) {
  return option == LIBUSB_OPTION_NO_DEVICE_DISCOVERY ? 0 : LIBUSB_ERROR_NOT_SUPPORTED;
}
int libusb_init(libusb_context** context) {
  *context = new libusb_context;
  return 0;
}
void libusb_exit(libusb_context* context) { delete context; }
int libusb_wrap_sys_device(libusb_context*, intptr_t, libusb_device_handle** device) {
  if (!camera->plugged) {
    return LIBUSB_ERROR_NO_DEVICE;
  }
  *device = new libusb_device_handle;
  ++camera->open_devices;
  return 0;
}
void libusb_close(libusb_device_handle* device) {
  --camera->open_devices;
  delete device;
}
libusb_device* libusb_get_device(libusb_device_handle* device) { return &device->device; }
int libusb_get_active_config_descriptor(libusb_device*, libusb_config_descriptor** config) {
  static libusb_interface_descriptor usual{};
  usual.bInterfaceNumber = 3;
  usual.bInterfaceClass = stof::hal::linux::kPmdInterfaceClass;
  usual.bInterfaceSubClass = stof::hal::linux::kPmdInterfaceSubclass;
  usual.bInterfaceProtocol = stof::hal::linux::kPmdInterfaceProtocol;
  static libusb_interface interface{};
  interface.altsetting = &usual;
  interface.num_altsetting = 1;
  static libusb_config_descriptor only{};
  only.bNumInterfaces = 1;
  only.interface = &interface;
  *config = &only;
  return 0;
}
void libusb_free_config_descriptor(libusb_config_descriptor*) {}
int libusb_claim_interface(libusb_device_handle*, int number) {
  return number == 3 ? camera->claim_error : LIBUSB_ERROR_NOT_FOUND;
}
int libusb_release_interface(libusb_device_handle*, int) { return 0; }
const char* libusb_strerror(int) { return "an error of the fake"; }
int libusb_control_transfer(libusb_device_handle*, uint8_t type, uint8_t request, uint16_t value,
                            uint16_t index, unsigned char* data, uint16_t length, unsigned) {
  if (!camera->plugged) {
    return LIBUSB_ERROR_NO_DEVICE;
  }
  if (!camera->answers || index != 3) {
    return LIBUSB_ERROR_TIMEOUT;
  }
  return type == stof::hal::linux::kPmdRequestIn ? stof::test::answer(request, data, length)
                                                 : stof::test::obey(request, value, data, length);
}
libusb_transfer* libusb_alloc_transfer(int) {
  ++camera->transfers;
  return static_cast<libusb_transfer*>(std::calloc(1, sizeof(libusb_transfer)));
}
void libusb_free_transfer(libusb_transfer* transfer) {
  camera->transfers -= transfer == nullptr ? 0 : 1;
  std::free(transfer);
}
int libusb_submit_transfer(libusb_transfer* transfer) {
  if (!camera->plugged) {
    return LIBUSB_ERROR_NO_DEVICE;
  }
  camera->under_way.push_back(transfer);
  return 0;
}
int libusb_cancel_transfer(libusb_transfer* transfer) {
  stof::test::finish(transfer, LIBUSB_TRANSFER_CANCELLED);
  return 0;
}
int libusb_clear_halt(libusb_device_handle*, unsigned char endpoint) {
  ++camera->halts_cleared;
  return endpoint == stof::hal::linux::kPmdEndpoint ? 0 : LIBUSB_ERROR_NOT_FOUND;
}
// NOLINTNEXTLINE(readability-non-const-parameter): the library's declaration
int libusb_handle_events_timeout_completed(libusb_context*, timeval* limit, int* completed) {
  stof::hal::linux::Clock clock;
  const stof::hal::Time end =
      clock.now() + std::chrono::seconds(limit->tv_sec) + std::chrono::microseconds(limit->tv_usec);
  for (;;) {
    const bool over = clock.now() >= end;  // before the last look, as poll(2) does it
    stof::test::serve();
    const std::vector<stof::test::Done> ready = std::exchange(done, {});
    for (const stof::test::Done& one : ready) {
      one.transfer->status = one.status;
      one.transfer->callback(one.transfer);
    }
    if (!ready.empty() || *completed != 0 || over) {
      return 0;
    }
    clock.wait_until(clock.now() + std::chrono::microseconds(100));
  }
}
// NOLINTEND(readability-identifier-naming, readability-inconsistent-declaration-parameter-name)
}
