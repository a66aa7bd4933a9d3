#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "board/board.h"
#include "firmware/events.h"
#include "firmware/loop.h"
#include "firmware/options.h"
#include "firmware/pipeline.h"
#include "firmware/report.h"
#include "firmware/start.h"
#include "firmware/stream.h"
#include "firmware/wire/calibration_packet.h"
#include "firmware/workspace.h"

namespace stof::firmware {
namespace {

constexpr int kExitOk = 0;
constexpr int kExitFailure = 1;
constexpr int kExitBadInput = 2;

constinit Workspace workspace{};
constinit Events events{};
std::atomic<bool> stop_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free);  // a signal handler writes it

void request_stop(int) { stop_requested.store(true, std::memory_order_relaxed); }

void watch_signals() {
  struct sigaction action{};
  action.sa_handler = &request_stop;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

void say(const std::string& line) {
  std::printf("stofd: %s\n", line.c_str());
  std::fflush(stdout);
}

int refuse(const std::string& line, int code = kExitBadInput) {
  std::fprintf(stderr, "stofd: %s\n", line.c_str());
  return code;
}

int help() {
  const std::string flags = options_usage();
  std::printf(
      "stofd: triggers the cameras, computes depth, sends it. One program, one board: "
      "%s.\n\n%.*s\nBoard %s:\n%.*s\n"
      "Exit codes: 0 stopped as asked, 1 a device failed at start, 2 bad input.\n",
      board::kConfig.name, static_cast<int>(flags.size()), flags.data(), board::kConfig.name,
      static_cast<int>(board::usage().size()), board::usage().data());
  return kExitOk;
}

// Random, so that a receiver notices a sender that started anew.
std::uint32_t make_session_id() { return std::random_device()(); }

// Prints what the loop notes, from a thread of its own: a terminal that blocks must not block the
// loop.
class Teller {
 public:
  Teller() : thread_([this] { run(); }) {}
  ~Teller() {
    done_.store(true);
    thread_.join();
    tell();
  }

 private:
  void run() {
    while (!done_.load()) {
      tell();
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }
  static void tell() {
    while (const std::optional<Event> event = events.take()) {
      say(describe(*event));
    }
  }

  std::atomic<bool> done_{false};
  std::thread thread_;
};

// Asks the board to reopen what is lost, soon at first, then once a second.
class Reopener {
 public:
  explicit Reopener(board::Board& board) : board_(board) {}

  void after(Status step) noexcept {
    if (step != Status::kDeviceLost) {
      wait_ = kShortest;
      return;
    }
    const hal::Time now = board_.clock.now();
    if (now < next_) {
      return;
    }
    // Not back yet, or gone again at once: the loop goes on and tells.
    static_cast<void>(board::reopen(board_));
    next_ = now + wait_;
    wait_ = std::min(2 * wait_, kLongest);
  }

 private:
  static constexpr hal::Duration kShortest = std::chrono::milliseconds(50);
  static constexpr hal::Duration kLongest = std::chrono::seconds(1);

  board::Board& board_;
  hal::Time next_{};
  hal::Duration wait_ = kShortest;
};

void greet(const board::Board& board, const Start& start, std::size_t bytes) {
  const dsp::Pinhole& left = start.setup.calibration.stereo.left;
  const dsp::Pinhole& pmd = start.setup.calibration.pmd.lens;
  for (const std::string& note : board.notes) {
    say(note);
  }
  say("board " + std::string(board::kConfig.name) + ", stereo " + std::to_string(left.width) + "x" +
      std::to_string(left.height) + " with " + std::to_string(start.setup.depth.match.disparities) +
      " disparities, " +
      (board.pmd == nullptr
           ? std::string("no PMD camera: depth from stereo alone")
           : "PMD " + std::to_string(pmd.width) + "x" + std::to_string(pmd.height)) +
      ", period " +
      std::to_string(
          std::chrono::duration_cast<std::chrono::microseconds>(start.timing.period).count()) +
      " us, workspace " + std::to_string(bytes / 1024) + " of " +
      std::to_string(sizeof(Workspace) / 1024) + " KiB");
}

int run(board::Board& board, const Options& options, const Start& start) {
  const std::size_t bytes = Pipeline::bytes_needed(start.setup);
  if (bytes > sizeof(Workspace)) {
    return refuse("these pictures and parameters need " + std::to_string(bytes / 1024) +
                  " KiB, board " + board::kConfig.name + " reserves " +
                  std::to_string(sizeof(Workspace) / 1024) + ": use smaller ones");
  }
  const auto calibration = wire::make_calibration_packet(
      start.setup.calibration, start.setup.depth.fusion.max_range, start.timing.period.count());
  if (!calibration) {
    return refuse("the rig's calibration holds numbers that no rig has: calibrate it anew");
  }
  workspace.prefault(bytes);
  dsp::Arena arena = workspace.arena();
  Pipeline pipeline(start.setup, board.clock, arena);
  const StreamSetup stream_setup{
      .origin = {.device_id = options.device_id,
                 .session_id = options.session_id.value_or(make_session_id())},
      .clock = board.emulated_time ? wire::ClockState::kEmulated : wire::ClockState::kMonotonic,
      .calibration = *calibration};
  Stream stream(stream_setup, board.clock, board.link, events);
  greet(board, start, bytes);
  {
    const Teller teller;
    Reopener reopener(board);
    Loop loop(board, start.timing, start.setup, pipeline, stream, events);
    while (!stop_requested.load(std::memory_order_relaxed) &&
           (options.frames == 0 || events.counters.published < options.frames)) {
      reopener.after(loop.step());
    }
  }
  say(summary(events.counters));
  say(stage_times(events.counters));
  return kExitOk;
}

int start_and_run(std::span<const std::string_view> arguments) {
  const auto options = parse_options(arguments);
  if (!options) {
    return refuse(options.error());
  }
  if (options->help) {
    return help();
  }
  watch_signals();
  const auto board = board::open(options->board);
  if (!board) {
    return refuse(board.error().message, board.error().device ? kExitFailure : kExitBadInput);
  }
  const auto start = make_start(**board, board::kConfig, *options);
  if (!start) {
    return refuse(start.error());
  }
  return run(**board, *options, *start);
}

}  // namespace
}  // namespace stof::firmware

int main(int argc, char** argv) {
  const std::vector<std::string_view> arguments(argv + (argc > 0 ? 1 : 0), argv + argc);
  return stof::firmware::start_and_run(arguments);
}
