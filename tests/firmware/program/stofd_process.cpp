#include "tests/firmware/program/stofd_process.h"

#include <array>
#include <csignal>
#include <cstdlib>
#include <sstream>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

namespace stof::firmware::test {
namespace {

std::string read_all(int fd) {
  std::string text;
  std::array<char, 4096> part;
  for (ssize_t n = 0; (n = read(fd, part.data(), part.size())) > 0;) {
    text.append(part.data(), static_cast<std::size_t>(n));
  }
  close(fd);
  return text;
}

std::vector<std::string> command() {
  std::vector<std::string> words;
  std::istringstream text(STOFD_COMMAND);
  for (std::string word; std::getline(text, word, '|');) {
    if (!word.empty()) {
      words.push_back(word);
    }
  }
  return words;
}

}  // namespace

Stofd::Stofd(const std::vector<std::string>& arguments) {
  std::vector<std::string> words = command();
  words.insert(words.end(), {"--port", "0"});  // several may run at a time
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) {
    argv.push_back(word.data());
  }
  argv.push_back(nullptr);
  EXPECT_EQ(pipe(out_), 0);
  EXPECT_EQ(pipe(error_), 0);
  child_ = fork();
  if (child_ == 0) {
    unsetenv("STOF_DATA");
    dup2(out_[1], STDOUT_FILENO);
    dup2(error_[1], STDERR_FILENO);
    for (const int fd : {out_[0], out_[1], error_[0], error_[1]}) {
      close(fd);
    }
    execvp(argv[0], argv.data());
    _exit(127);
  }
  close(out_[1]);
  close(error_[1]);
}

void Stofd::signal(int number) const { kill(child_, number); }

Ended Stofd::end() const {
  Ended ended;
  ended.out = read_all(out_[0]);
  ended.error = read_all(error_[0]);
  int status = 0;
  waitpid(child_, &status, 0);
  ended.code = WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
  return ended;
}

Ended run_stofd(const std::vector<std::string>& arguments) { return Stofd(arguments).end(); }

Socket::Socket() : fd_(socket(AF_INET, SOCK_DGRAM, 0)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(bind(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  socklen_t size = sizeof address;
  getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size);
  destination = "127.0.0.1:" + std::to_string(ntohs(address.sin_port));
}

Socket::~Socket() { close(fd_); }

std::vector<std::byte> Socket::receive() const {
  pollfd waiting{.fd = fd_, .events = POLLIN, .revents = 0};
  std::vector<std::byte> bytes(2048);
  if (poll(&waiting, 1, 60'000) != 1) {
    return {};
  }
  const ssize_t count = recv(fd_, bytes.data(), bytes.size(), 0);
  bytes.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
  return bytes;
}

}  // namespace stof::firmware::test
