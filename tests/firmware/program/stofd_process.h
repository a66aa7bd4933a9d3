#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <sys/types.h>

#include "posix/udp_socket.h"

namespace stof::firmware::test {

struct Ended {
  int code = -1;  // 1000 + signal where a signal ended it
  std::string out;
  std::string error;
};

// A running stofd. STOFD_COMMAND is its file, behind an emulator in cross builds, words apart by |.
class Stofd {
 public:
  // any_port: else the one of the settings; several may run at a time.
  explicit Stofd(const std::vector<std::string>& arguments, bool any_port = true);
  void signal(int number) const;
  // Waits for it. Both texts are short enough for a pipe, so one may be read after the other.
  Ended end() const;

 private:
  pid_t child_ = -1;
  int out_[2]{};
  int error_[2]{};
};

Ended run_stofd(const std::vector<std::string>& arguments, bool any_port = true);

// A UDP socket on loopback that stofd sends to.
class Socket {
 public:
  Socket();

  // The next datagram; empty when none comes for a long time.
  std::vector<std::byte> receive() const;

  std::string destination;  // for --to

 private:
  posix::UdpSocket socket_{AF_INET};
};

}  // namespace stof::firmware::test
