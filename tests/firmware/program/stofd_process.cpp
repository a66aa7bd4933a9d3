#include "tests/firmware/program/stofd_process.h"

#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <sstream>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "posix/poll.h"
#include "tests/support/loopback.h"

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

Stofd::Stofd(const std::vector<std::string>& arguments, bool any_port) {
  std::vector<std::string> words = command();
  if (any_port) {
    words.insert(words.end(), {"--port", "0"});
  }
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) {
    argv.push_back(word.data());
  }
  argv.push_back(nullptr);
  EXPECT_EQ(pipe(out_), 0);
  EXPECT_EQ(pipe(error_), 0);
  child_ = fork();
  if (child_ == 0) {
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

Ended run_stofd(const std::vector<std::string>& arguments, bool any_port) {
  return Stofd(arguments, any_port).end();
}

Socket::Socket() {
  EXPECT_EQ(socket_.bind(stof::test::loopback_address(0)), 0);
  destination = "127.0.0.1:" + std::to_string(socket_.port());
}

std::vector<std::byte> Socket::receive() const {
  std::array waiting{pollfd{.fd = socket_.fd(), .events = POLLIN, .revents = 0}};
  std::vector<std::byte> bytes(2048);
  if (posix::wait_for(waiting, std::chrono::minutes(1)) != 1) {
    return {};
  }
  bytes.resize(socket_.receive(bytes).value_or(0));
  return bytes;
}

}  // namespace stof::firmware::test
