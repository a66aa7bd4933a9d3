#include "hal/linux/usb/usb_find.h"

#include <array>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string_view>

#include <dirent.h>
#include <fcntl.h>
#include <unistd.h>

#include "dsp/base/parse_number.h"

namespace stof::hal::linux {
namespace {

constexpr int kMostBusNumber = 999;  // three digits of the node's name

// The first line of a small file; empty: there is none.
std::string read_line(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) {
    return {};
  }
  std::array<char, 256> text{};
  const ssize_t count = ::read(fd, text.data(), text.size());
  ::close(fd);
  std::string_view line(text.data(), count > 0 ? static_cast<std::size_t>(count) : 0);
  line = line.substr(0, line.find('\n'));
  return std::string(line);
}

std::optional<int> read_number(const std::string& path, int base) {
  const std::optional<int> value = dsp::parse_number<int>(read_line(path), base);
  return value && *value >= 0 ? value : std::nullopt;
}

bool is(const std::string& device, const UsbId& id) {
  return read_number(device + "/idVendor", 16) == id.vendor &&
         read_number(device + "/idProduct", 16) == id.product &&
         (id.serial.empty() || read_line(device + "/serial") == id.serial);
}

}  // namespace

std::string to_string(const UsbId& id) {
  std::array<char, 16> numbers{};
  std::snprintf(numbers.data(), numbers.size(), "%04x:%04x", unsigned{id.vendor},
                unsigned{id.product});
  std::string text = numbers.data();
  return id.serial.empty() ? text : text.append(" serial '").append(id.serial).append("'");
}

std::expected<std::string, OpenError> find_usb(const UsbId& id, const UsbRoots& roots) {
  const std::string what = "USB device " + to_string(id) + ": ";
  DIR* const folder = opendir(roots.devices.c_str());
  if (folder == nullptr) {
    return std::unexpected(OpenError{what + "cannot read " + roots.devices + ": " +
                                     std::strerror(errno) + "; does this kernel have USB?"});
  }
  int count = 0;
  int bus = 0;
  int number = 0;
  // NOLINTNEXTLINE(concurrency-mt-unsafe): no other thread has this folder
  while (const dirent* const entry = readdir(folder)) {
    const std::string device = roots.devices + "/" + &entry->d_name[0];
    if (entry->d_name[0] == '.' || !is(device, id)) {
      continue;
    }
    const std::optional<int> on_bus = read_number(device + "/busnum", 10);
    const std::optional<int> as = read_number(device + "/devnum", 10);
    if (on_bus && as && *on_bus <= kMostBusNumber && *as <= kMostBusNumber) {
      ++count;
      bus = *on_bus;
      number = *as;
    }
  }
  closedir(folder);
  if (count != 1) {
    const std::string why =
        count == 0
            ? "not plugged in; check cable, power and the board's table"
            : std::to_string(count) + " are plugged in; unplug those that are not this rig's";
    return std::unexpected(OpenError{what + why});
  }
  std::array<char, 16> place{};
  std::snprintf(place.data(), place.size(), "/%03d/%03d", bus, number);
  return roots.nodes + place.data();
}

}  // namespace stof::hal::linux
