#pragma once

#include <chrono>
#include <cstdlib>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include <asm/termbits.h>
#include <fcntl.h>
#include <sys/ioctl.h>
#include <unistd.h>

namespace stof::test {

// The far end of a serial line: a program opens name() as its tty.
class Pty {
 public:
  Pty() = default;
  Pty(const Pty&) = delete;
  Pty& operator=(const Pty&) = delete;
  ~Pty() { close(); }

  // Raw from the start, so that nothing is echoed before the tty has been configured.
  bool open() {
    fd_ = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (fd_ < 0 || grantpt(fd_) != 0 || unlockpt(fd_) != 0) {
      return false;
    }
    const char* const name = ptsname(fd_);
    name_ = name == nullptr ? "" : name;
    return !name_.empty();
  }
  void close() {
    if (fd_ >= 0) {
      ::close(std::exchange(fd_, -1));
    }
  }
  const std::string& name() const { return name_; }
  // qemu-user knows the named speeds only.
  bool has_any_speed() const {
    termios2 line{};
    return ioctl(fd_, TCGETS2, &line) == 0;
  }
  // Whether the program's end is held up by RTS and CTS.
  bool has_flow_control() const {
    termios line{};
    return ioctl(fd_, TCGETS, &line) == 0 && (line.c_cflag & CRTSCTS) != 0;
  }

  void write(std::string_view text) const {
    while (!text.empty()) {
      const ssize_t count = ::write(fd_, text.data(), text.size());
      if (count <= 0) {
        return;
      }
      text.remove_prefix(static_cast<std::size_t>(count));
    }
  }
  // What is there now.
  std::string read_some() const {
    std::string text(65'536, '\0');
    const ssize_t count = ::read(fd_, text.data(), text.size());
    text.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
    return text;
  }
  // Waits up to five seconds for so many bytes.
  std::string read(std::size_t bytes) const {
    std::string text;
    for (int i = 0; i < 5000 && text.size() < bytes; ++i) {
      text += read_some();
      if (text.size() < bytes) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    }
    return text;
  }

 private:
  int fd_ = -1;
  std::string name_;
};

}  // namespace stof::test
