// Debian's libusb-1.0.a refers to libudev, which has no static library. Nothing of it is called
// with LIBUSB_OPTION_NO_DEVICE_DISCOVERY (usb_link.cpp). A call aborts with a message.

#include <cstdio>
#include <cstdlib>

namespace {

[[noreturn]] void called(const char* name) noexcept {
  std::fprintf(stderr, "%s: this program has no udev; open USB devices by their node\n", name);
  std::abort();
}

}  // namespace

// Parameters do not matter to what never returns.
// NOLINTBEGIN(readability-identifier-naming,bugprone-macro-parentheses)
#define STOF_NO_UDEV(name) \
  void* name() { called(#name); }

extern "C" {
STOF_NO_UDEV(udev_device_get_action)
STOF_NO_UDEV(udev_device_get_devnode)
STOF_NO_UDEV(udev_device_get_sysname)
STOF_NO_UDEV(udev_device_new_from_syspath)
STOF_NO_UDEV(udev_device_unref)
STOF_NO_UDEV(udev_enumerate_add_match_property)
STOF_NO_UDEV(udev_enumerate_add_match_subsystem)
STOF_NO_UDEV(udev_enumerate_get_list_entry)
STOF_NO_UDEV(udev_enumerate_new)
STOF_NO_UDEV(udev_enumerate_scan_devices)
STOF_NO_UDEV(udev_enumerate_unref)
STOF_NO_UDEV(udev_list_entry_get_name)
STOF_NO_UDEV(udev_list_entry_get_next)
STOF_NO_UDEV(udev_monitor_enable_receiving)
STOF_NO_UDEV(udev_monitor_filter_add_match_subsystem_devtype)
STOF_NO_UDEV(udev_monitor_get_fd)
STOF_NO_UDEV(udev_monitor_new_from_netlink)
STOF_NO_UDEV(udev_monitor_receive_device)
STOF_NO_UDEV(udev_monitor_unref)
STOF_NO_UDEV(udev_new)
STOF_NO_UDEV(udev_unref)
}
// NOLINTEND(readability-identifier-naming,bugprone-macro-parentheses)
