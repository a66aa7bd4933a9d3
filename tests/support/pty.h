#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include <unistd.h>

#include "posix/fd.h"
#include "posix/terminal.h"

namespace stof::test {

// The far end of a serial line: a program opens name() as its tty.
class Pty {
 public:
  // Raw from the start, so that nothing is echoed before the tty has been configured.
  bool open() {
    auto opened = posix::open_pseudo_terminal(name_);
    fd_ = opened ? *std::move(opened) : posix::Fd();
    return fd_.is_open();
  }
  void close() { fd_.reset(); }
  const std::string& name() const { return name_; }
  // qemu-user knows the named speeds only.
  bool has_any_speed() const { return posix::has_any_speed(fd_.get()); }
  // Whether the program's end is held up by RTS and CTS.
  bool has_flow_control() const { return posix::has_flow_control(fd_.get()); }
  int fd() const { return fd_.get(); }

  void write(std::string_view text) const {
    while (!text.empty()) {
      const ssize_t count = ::write(fd_.get(), text.data(), text.size());
      if (count <= 0) {
        return;
      }
      text.remove_prefix(static_cast<std::size_t>(count));
    }
  }
  // What is there now.
  std::string read_some() const {
    std::string text(65'536, '\0');
    const ssize_t count = ::read(fd_.get(), text.data(), text.size());
    text.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
    return text;
  }
  // Waits up to a minute for so many bytes.
  std::string read(std::size_t bytes) const {
    std::string text;
    for (int i = 0; i < 60'000 && text.size() < bytes; ++i) {
      text += read_some();
      if (text.size() < bytes) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    }
    return text;
  }

 private:
  posix::Fd fd_;
  std::string name_;
};

}  // namespace stof::test
