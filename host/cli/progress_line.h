#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

// What a long work says of itself while it goes on: one line on stderr that is overwritten, where
// that is a terminal and nobody reads JSON; nothing elsewhere.
namespace stof::host {

class TerminalLine {
 public:
  // json: of a command that prints JSON. first: how long nothing is said.
  explicit TerminalLine(bool json, std::chrono::milliseconds first = {});
  ~TerminalLine() { end(); }
  TerminalLine(const TerminalLine&) = delete;
  TerminalLine& operator=(const TerminalLine&) = delete;

  // Whether it is time to say something: at most twice a second.
  bool due();
  void show(const std::string& text);
  // Leaves what it says, and goes to the next line.
  void end();
  // Takes it away: something else is printed.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;

  bool shown_;
  Clock::time_point due_;
  std::size_t width_ = 0;  // of what stands there
};

// A bar of bytes.
class ProgressLine {
 public:
  explicit ProgressLine(bool json) : line_(json) {}
  void show(std::size_t bytes, std::size_t total);
  void end() { line_.end(); }

 private:
  TerminalLine line_;
};

// Of what may take long, nothing is said before.
inline constexpr std::chrono::milliseconds kLongWork{2000};

// Frames that are written to files.
class ExportProgress {
 public:
  // what: is exported.
  ExportProgress(const std::string& what, bool json, std::chrono::milliseconds first = kLongWork);

  // Of a recording: so many frames, of so many bytes of it.
  void show(std::uint64_t frames, std::uint64_t bytes, std::uint64_t total);
  // Of a sensor: wanted 0: until it is interrupted.
  void show(std::uint64_t frames, std::uint64_t wanted);
  void clear() { line_.clear(); }

 private:
  std::string what_;
  TerminalLine line_;
};

}  // namespace stof::host
