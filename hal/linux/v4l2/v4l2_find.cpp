#include "hal/linux/v4l2/v4l2_find.h"

#include <algorithm>
#include <cctype>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string_view>
#include <system_error>
#include <vector>

#include <linux/videodev2.h>

namespace stof::hal::linux {
namespace {

constexpr std::string_view kUsb = "usb:";
constexpr std::string_view kCard = "card:";

std::string first_line(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

struct UsbName {
  std::string vendor;
  std::string product;
  std::string serial;  // empty: any
};

std::optional<UsbName> parse_usb(std::string_view text) {
  constexpr std::size_t kDigits = 4;
  constexpr std::size_t kShort = 2 * kDigits + 1;  // VVVV:PPPP
  if (text.size() < kShort || (text.size() > kShort && text[kShort] != ':')) {
    return std::nullopt;
  }
  const auto lower = [](std::string_view digits) {
    std::string out;
    for (const char digit : digits) {
      out += static_cast<char>(std::tolower(static_cast<unsigned char>(digit)));
    }
    return out;
  };
  UsbName name{.vendor = lower(text.substr(0, kDigits)),
               .product = lower(text.substr(kDigits + 1, kDigits)),
               .serial = {}};
  constexpr std::string_view kHex = "0123456789abcdef";
  if (text[kDigits] != ':' ||
      (name.vendor + name.product).find_first_not_of(kHex) != std::string::npos) {
    return std::nullopt;
  }
  if (text.size() > kShort) {
    name.serial = text.substr(kShort + 1);
  }
  return name;
}

// Of all video nodes, video2 before video10.
std::vector<std::string> list_nodes(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code error;
  const std::filesystem::directory_iterator end;
  for (std::filesystem::directory_iterator it(folder, error); !error && it != end;
       it.increment(error)) {
    std::string name = it->path().filename().string();
    if (name.starts_with("video")) {
      names.push_back(std::move(name));
    }
  }
  std::ranges::sort(names, [](const std::string& a, const std::string& b) {
    return a.size() != b.size() ? a.size() < b.size() : a < b;
  });
  return names;
}

// The card's name where the node captures and streams.
std::optional<std::string> capture_card(V4l2Calls& calls, const std::string& path) {
  const int fd = calls.open(path.c_str());
  if (fd < 0) {
    return std::nullopt;
  }
  v4l2_capability answer{};
  const int error = ask_driver(calls, fd, VIDIOC_QUERYCAP, &answer);
  calls.close(fd);
  constexpr std::uint32_t kNeeded = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  if (error != 0 || (answer.device_caps & kNeeded) != kNeeded) {
    return std::nullopt;
  }
  const char* const card = reinterpret_cast<const char*>(answer.card);
  return std::string(card, strnlen(card, sizeof answer.card));
}

bool is_usb(const std::string& device, const UsbName& name) {
  return first_line(device + "/idVendor") == name.vendor &&
         first_line(device + "/idProduct") == name.product &&
         (name.serial.empty() || first_line(device + "/serial") == name.serial);
}

}  // namespace

std::expected<std::string, OpenError> find_v4l2_node(V4l2Calls& calls, const std::string& text,
                                                     const std::string& sysfs) {
  const auto refuse = [&text](const char* reason) {
    return std::unexpected(OpenError{"camera '" + text + "': " + reason});
  };
  if (text.starts_with('/')) {
    return text;
  }
  std::optional<UsbName> usb;
  if (text.starts_with(kUsb)) {
    usb = parse_usb(std::string_view(text).substr(kUsb.size()));
  }
  if (!usb && !text.starts_with(kCard)) {
    return refuse("no such form; give /dev/videoN, usb:VVVV:PPPP[:SERIAL] or card:NAME");
  }
  const std::string folder = sysfs + "/class/video4linux";
  std::string found;
  std::filesystem::path found_in;  // the device that has the node
  for (const std::string& name : list_nodes(folder)) {
    // The node's interface; its USB device is the folder above.
    const std::string node = std::string(folder).append("/").append(name);
    const std::string device = node + (usb ? "/device/.." : "/device");
    if (usb && !is_usb(device, *usb)) {
      continue;
    }
    const std::string path = "/dev/" + name;
    const std::optional<std::string> card = capture_card(calls, path);
    if (!card || (!usb && *card != text.substr(kCard.size()))) {
      continue;
    }
    std::error_code error;
    const std::filesystem::path place = std::filesystem::canonical(device, error);
    if (found.empty()) {
      found = path;
      found_in = place;
    } else if (place != found_in) {
      return refuse("two of them are there; add its serial number or give /dev/videoN");
    }
  }
  if (found.empty()) {
    return refuse("not there, or not to be opened; check the cable and the group video");
  }
  return found;
}

}  // namespace stof::hal::linux
