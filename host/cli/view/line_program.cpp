#include "host/cli/view/line_program.h"

#include <array>
#include <cerrno>
#include <csignal>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace stof::host {
namespace {

constexpr std::size_t kMostComplaint = 1000;
constexpr int kLookEveryMs = 200;  // whether it goes on

std::string errno_text(int error) { return std::generic_category().message(error); }

}  // namespace

LineProgram::LineProgram(pid_t child, posix::Fd out, posix::Fd complaints, GoesOn goes_on) noexcept
    : child_(child),
      out_(std::move(out)),
      complaints_(std::move(complaints)),
      goes_on_(std::move(goes_on)) {}

LineProgram::LineProgram(LineProgram&& other) noexcept
    : child_(std::exchange(other.child_, -1)),
      out_(std::move(other.out_)),
      complaints_(std::move(other.complaints_)),
      read_(std::move(other.read_)),
      complaint_(std::move(other.complaint_)),
      complaint_ended_(other.complaint_ended_),
      goes_on_(std::move(other.goes_on_)),
      killed_at_(other.killed_at_) {}

LineProgram::~LineProgram() {
  if (child_ > 0) {
    kill(child_, SIGKILL);
    waitpid(child_, nullptr, 0);
  }
}

std::expected<LineProgram, std::string> LineProgram::start(const std::vector<std::string>& words,
                                                           GoesOn goes_on) {
  std::array<int, 2> out{};
  std::array<int, 2> complaints{};
  if (pipe2(out.data(), O_CLOEXEC) != 0) {
    return std::unexpected(words.front() + ": cannot be started: " + errno_text(errno));
  }
  const posix::Fd out_end(out[1]);
  posix::Fd out_begin(out[0]);
  if (pipe2(complaints.data(), O_CLOEXEC) != 0) {
    return std::unexpected(words.front() + ": cannot be started: " + errno_text(errno));
  }
  const posix::Fd complaints_end(complaints[1]);
  posix::Fd complaints_begin(complaints[0]);
  std::vector<std::string> copies(words);
  std::vector<char*> arguments;
  arguments.reserve(copies.size() + 1);
  for (std::string& word : copies) {
    arguments.push_back(word.data());
  }
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&files, out_end.get(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, complaints_end.get(), STDERR_FILENO);
  posix_spawn_file_actions_addclosefrom_np(&files, STDERR_FILENO + 1);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  sigset_t usual;  // what this program ignores another one need not
  sigemptyset(&usual);
  sigaddset(&usual, SIGPIPE);
  posix_spawnattr_setsigdefault(&attributes, &usual);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  pid_t child = -1;
  const int error =
      posix_spawn(&child, copies.front().c_str(), &files, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  if (error != 0) {
    return std::unexpected(words.front() + ": cannot be started: " + errno_text(error));
  }
  return LineProgram(child, std::move(out_begin), std::move(complaints_begin), std::move(goes_on));
}

void LineProgram::take_complaint(const char* bytes, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) {
    if (std::exchange(complaint_ended_, bytes[i] == '\n')) {
      if (bytes[i] == '\n') {
        continue;
      }
      complaint_.clear();
    }
    if (bytes[i] != '\n' && complaint_.size() < kMostComplaint) {
      complaint_.push_back(bytes[i]);
    }
  }
}

bool LineProgram::read_some() {
  std::array<pollfd, 2> ends{pollfd{.fd = out_.get(), .events = POLLIN, .revents = 0},
                             pollfd{.fd = complaints_.get(), .events = POLLIN, .revents = 0}};
  if (!out_.is_open() && !complaints_.is_open()) {
    return false;
  }
  if (poll(ends.data(), ends.size(), kLookEveryMs) < 0) {
    return errno == EINTR;
  }
  look_whether_it_goes_on();
  std::array<char, 65'536> bytes{};
  for (std::size_t i = 0; i < ends.size(); ++i) {
    if (ends[i].fd < 0 || ends[i].revents == 0) {
      continue;
    }
    const ssize_t size = read(ends[i].fd, bytes.data(), bytes.size());
    if (size < 0 && errno == EINTR) {
      continue;
    }
    if (size <= 0) {
      (i == 0 ? out_ : complaints_).reset();
    } else if (i == 1) {
      take_complaint(bytes.data(), static_cast<std::size_t>(size));
    } else {
      read_.append(bytes.data(), static_cast<std::size_t>(size));
    }
  }
  return true;
}

std::optional<std::string> LineProgram::next_line() {
  std::size_t looked = 0;
  while (true) {
    const std::size_t end = read_.find('\n', looked);
    if (end != std::string::npos) {
      std::string line = read_.substr(0, end);
      read_.erase(0, end + 1);
      return line;
    }
    looked = read_.size();
    if (read_.size() > kMostLine) {
      read_.clear();
      looked = 0;
    }
    if (!read_some()) {
      return std::nullopt;
    }
  }
}

void LineProgram::look_whether_it_goes_on() {
  if (!killed_at_ && !goes_on_()) {
    killed_at_ = Clock::now() + kPatience;
    kill(child_, SIGINT);
  } else if (killed_at_ && Clock::now() >= *killed_at_) {
    kill(child_, SIGKILL);
  }
}

int LineProgram::wait() {
  int status = 0;
  while (waitpid(child_, &status, 0) < 0 && errno == EINTR) {
  }
  child_ = -1;
  constexpr int kBySignal = 128;
  return WIFEXITED(status) ? WEXITSTATUS(status) : kBySignal + WTERMSIG(status);
}

}  // namespace stof::host
