#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "board/board.h"
#include "firmware/events/event_printer.h"
#include "firmware/events/events.h"
#include "firmware/events/log_text.h"
#include "firmware/loop/watchdog_feeder.h"
#include "firmware/pipeline/pipeline.h"
#include "firmware/program/appliance.h"
#include "firmware/program/control_services.h"
#include "firmware/program/initial_settings.h"
#include "firmware/program/options.h"
#include "firmware/program/reopener.h"
#include "firmware/program/replay_driver.h"
#include "firmware/program/run_config.h"
#include "firmware/program/update_parts.h"
#include "firmware/settings/fields/schema.h"
#include "firmware/settings/settings_trial.h"
#include "firmware/wire/crypto/crypto.h"
#include "firmware/workspace.h"
#include "posix/out_of_resources.h"
#include "posix/worker_threads.h"

namespace stof::firmware {
namespace {

constexpr int kExitOk = 0;
constexpr int kExitFailure = 1;
constexpr int kExitBadInput = 2;
constexpr int kExitRestart = 3;
constexpr int kExitTrial = 4;

constinit Workspace workspace{};
constinit Events events{};
constinit RunConfigRing run_configs{};
constinit ReceiverRing receivers{};
constinit ChangeRing changes{};
constinit LoopStatus loop_status{};
constinit std::atomic<update::Restart> restart{update::Restart::kNone};
// Too large for the stack.
constinit std::optional<keys::Keyring> ring{};
constinit std::optional<keys::PairingServer> pairing{};
constinit std::optional<ControlServices> control{};
alignas(64) constinit std::array<std::byte, SerialSender::kRingBytes> serial_memory{};
static_assert(sizeof(events) + sizeof(run_configs) + sizeof(receivers) + sizeof(changes) +
                  sizeof(loop_status) + sizeof(ring) + sizeof(pairing) + sizeof(control) +
                  sizeof(serial_memory) <=
              kOtherStaticBytes / 4 * 3);
std::atomic<bool> stop_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free);  // a signal handler writes it

void request_stop(int) { stop_requested.store(true, std::memory_order_relaxed); }

void watch_signals() {
  struct sigaction action{};
  action.sa_handler = &request_stop;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  sigaction(SIGHUP, &action, nullptr);  // whoever started it by hand has gone
  struct sigaction none{};
  none.sa_handler = SIG_IGN;  // a reader of our lines that has gone ends nothing
  sigaction(SIGPIPE, &none, nullptr);
}

int refuse(const std::string& line, int code = kExitBadInput) {
  std::fprintf(stderr, "stofd: %s\n", line.c_str());
  return code;
}

// What was asked for is what was printed.
int end_of_output() {
  return std::fflush(stdout) == 0 && std::ferror(stdout) == 0
             ? kExitOk
             : refuse("its output cannot be written: make room, or send it elsewhere",
                      kExitFailure);
}

int help() {
  const std::string flags = options_usage();
  std::printf(
      "stofd: triggers the cameras, computes depth, sends it. One program, one board: "
      "%s.\n\n%.*s\nBoard %s:\n%.*s\n"
      "Exit codes: 0 stopped as asked, 1 a device failed at start, another stofd has its files, or "
      "what --help and the like print cannot be written, "
      "2 bad input, 3 and 4 the board "
      "shall restart, with 4 once from the other slot; nothing that was saved ends it.\n",
      board::kConfig.name, static_cast<int>(flags.size()), flags.data(), board::kConfig.name,
      static_cast<int>(board::usage().size()), board::usage().data());
  return end_of_output();
}

// Random, so that a receiver notices a sender that started anew.
std::uint32_t make_session_id() { return std::random_device()(); }

void print_start(const board::Board& board, const RigInfo& rig, const RunConfig& run_config) {
  const dsp::Pinhole& left = rig.calibration.stereo.left;
  const dsp::Pinhole& pmd = rig.calibration.pmd.lens;
  for (const std::string& note : board.notes) {
    print_line(note);
  }
  print_line(
      "board " + std::string(board::kConfig.name) + ", stereo " + std::to_string(left.width) + "x" +
      std::to_string(left.height) + " with " +
      std::to_string(run_config.setup.depth.match.disparities) + " disparities, " +
      (board.pmd == nullptr
           ? std::string("no PMD camera: depth from stereo alone")
           : "PMD " + std::to_string(pmd.width) + "x" + std::to_string(pmd.height)) +
      ", period " +
      std::to_string(
          std::chrono::duration_cast<std::chrono::microseconds>(run_config.timing.period).count()) +
      " us, workspace " + std::to_string(run_config.image_bytes / 1024) + " of " +
      std::to_string(sizeof(Workspace::memory) / 1024) + " KiB, " +
      threads_text(run_config.setup.threads, rig.threads));
  if (rig.installed) {
    print_line("the calibration is the installed one; stof calib install --factory goes back");
  }
  print_line("listening at UDP port " + std::to_string(board.port.port()));
}

wire::Announce make_announce(const board::Board& board, const RigInfo& rig,
                             const Options& options) {
  wire::Announce announce{
      .port = board.port.port(),
      .image_width = static_cast<std::uint16_t>(rig.calibration.stereo.left.width),
      .image_height = static_cast<std::uint16_t>(rig.calibration.stereo.left.height)};
  std::array<char, 16> serial{};
  std::snprintf(serial.data(), serial.size(), "%08x", options.device_id);
  put_text(serial.data(), announce.serial);
  put_text(STOF_VERSION, announce.version);
  put_text(board::kConfig.name, announce.board);
  return announce;
}

bool write_port(const std::string& file, std::uint16_t port) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> out(std::fopen(file.c_str(), "w"),
                                                            &std::fclose);
  return out && std::fprintf(out.get(), "%u\n", unsigned{port}) > 0 && std::fflush(out.get()) == 0;
}

// Threads that compute depth, the loop's own among them.
int threads_of(const settings::Settings& settings) {
  if (settings.compute.threads > 0) {
    return settings.compute.threads;
  }
  return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1,
                    settings::kUsualThreads);
}

void end_loop(WatchdogFeeder& watchdog) {
  if (watchdog.end() != Status::kOk) {
    print_line(
        "the watchdog cannot be stopped: the board restarts unless stofd is started again soon");
  }
  if (const board::HeapCalls heap = board::heap_calls(); heap.counted) {
    print_line(heap_text(heap.own, heap.libraries, events.counters.edges));
  }
  static_cast<void>(board::set_realtime_priority(false));
  control.reset();
}

// For the control thread.
void note_round(const Appliance& appliance) {
  loop_status.rate_millihertz.store(appliance.publisher().health().rate_millihertz(),
                                    std::memory_order_relaxed);
  loop_status.installs.store(appliance.installs(), std::memory_order_release);
  loop_status.published.store(events.counters.published, std::memory_order_relaxed);
  loop_status.with_pair.store(events.counters.with_pair, std::memory_order_relaxed);
  loop_status.with_pmd.store(events.counters.with_pmd, std::memory_order_relaxed);
  loop_status.rounds.fetch_add(1, std::memory_order_relaxed);
  loop_status.standby.store(appliance.in_standby(), std::memory_order_relaxed);
  loop_status.health.store(appliance.publisher().health().summary(), std::memory_order_relaxed);
}

wire::ClockState clock_of(const board::Board& board) {
  if (board.replay != nullptr) {
    return wire::ClockState::kRecorded;
  }
  return board.emulated_time ? wire::ClockState::kEmulated : wire::ClockState::kMonotonic;
}

// What came of a replay: the exit code.
int judge_replay(const board::Board& board, const std::string& problem) {
  if (board.replay == nullptr) {
    return kExitOk;
  }
  const board::Replay::Verdict verdict = board.replay->verdict();
  for (const std::string& line : verdict.lines) {
    print_line(line);
  }
  if (!problem.empty()) {
    return refuse(problem, kExitFailure);
  }
  return verdict.equal ? kExitOk : kExitFailure;
}

// Until it is stopped, has made its frames, or the recording is over.
void run_rounds(Appliance& appliance, WatchdogFeeder& watchdog, const Options& options,
                ReplayDriver* replay) {
  while ((replay == nullptr || replay->prepare(appliance)) &&
         !stop_requested.load(std::memory_order_relaxed) &&
         restart.load(std::memory_order_relaxed) == update::Restart::kNone &&
         (options.frames == 0 || events.counters.published < options.frames)) {
    static_cast<void>(appliance.step(control->status(appliance.serial())));
    watchdog.after_round();
    note_round(appliance);
  }
}

// Ends with the loop; the control thread before it. Returns the exit code.
int run_loop(board::Board& board, const Options& options, RigInfo& rig, const board::Config& config,
             const RunConfig& run_config, InitialSettings& start, update::Updater& updater,
             posix::WorkerThreads& workers) {
  std::optional<settings::SettingsTrial> trial;
  if (start.store != nullptr) {
    trial.emplace(start.stores(), start.saved.settings, !start.saved.on_trial);
  }
  const wire::Origin origin{.device_id = options.device_id,
                            .session_id = options.session_id.value_or(make_session_id())};
  DeviceLending lending(board.emulated_time);
  const Reopener reopener(board, lending);
  ByteRing serial(serial_memory);
  ByteRing* const line = board.serial == nullptr ? nullptr : &serial;
  Appliance appliance(
      {.board = board,
       .events = events,
       .run_configs = run_configs,
       .receivers = receivers,
       .serial = line,
       .threads = {workers, workers.threads()},
       .changes = &changes,
       .lending = &lending},
      {.origin = origin, .clock = clock_of(board), .calibration = run_config.calibration},
      run_config, {.images = workspace.memory, .coded = workspace.coded});
  control.emplace(ControlServices::Parts{.board = board,
                                         .rig = rig,
                                         .store = start.store.get(),
                                         .fixed = start.fixed.get(),
                                         .installed = start.calibration.get(),
                                         .network = start.network ? &*start.network : nullptr,
                                         .updater = updater,
                                         .saved = start.saved,
                                         .trial = trial ? &*trial : nullptr,
                                         .keys = *ring,
                                         .pairing = pairing.emplace(origin, *ring, start.label),
                                         .connection_replaced = (board.other_port ? 1U : 0U) |
                                                                (start.serial_dropped ? 2U : 0U),
                                         .origin = origin,
                                         .announce = make_announce(board, rig, options),
                                         .run_configs = run_configs,
                                         .changes = changes,
                                         .receivers = receivers,
                                         .serial = line,
                                         .loop_status = loop_status,
                                         .restart = restart},
                  start.active);
  const EventPrinter printer(events);
  WatchdogFeeder watchdog(board.watchdog, board.clock);
  // Only now: what the other threads do can wait.
  static_cast<void>(board::set_realtime_priority(true));
  board::count_heap_calls();
  std::optional<ReplayDriver> replay;
  if (board.replay != nullptr) {
    replay.emplace(*board.replay, rig, config, start.active, options);
  }
  appliance.end_after(options.frames);  // one step may publish two
  run_rounds(appliance, watchdog, options, replay ? &*replay : nullptr);
  end_loop(watchdog);
  return judge_replay(board, replay ? replay->problem() : std::string());
}

void say_refusal(const std::optional<std::string>& refusal) {
  if (refusal) {
    print_line(*refusal);
  }
}

// What the board shall do, as an exit code.
int end_of(const update::Updater& updater) {
  switch (restart.load(std::memory_order_relaxed)) {
    case update::Restart::kTrial:
      print_line("the other slot is tried once: the board restarts");
      return kExitTrial;
    case update::Restart::kUsual:
      print_line(
          "release " + std::string(updater.version()) +
          " did not publish what was published before: the board restarts with the other one");
      return kExitRestart;
    case update::Restart::kNone:
      break;
  }
  return kExitOk;
}

void print_release(const UpdateParts& parts, const update::Updater& updater) {
  say_refusal(parts.note.empty() ? std::nullopt : std::optional(parts.note));
  if (!updater.version().empty() || updater.trial_runs()) {
    print_line("release " + std::string(updater.version()) + " in slot " +
               std::string(1, update::letter(parts.running)) +
               (updater.trial_runs() ? " on trial: half a minute of frames confirms it" : ""));
  }
}

int run(board::Board& board, const Options& options, InitialSettings& start,
        const UpdateParts& parts) {
  const board::Config config = ReplayDriver::config(board);
  if (board.replay != nullptr) {
    auto settings = ReplayDriver::first_settings(*board.replay, start.active, options);
    if (!settings) {
      return refuse(settings.error());
    }
    start.active = *settings;
  }
  std::string note;
  auto rig =
      make_rig(board, board::kConfig, options.calibration, read_installed(options, start), note);
  if (!rig) {
    return refuse(rig.error());
  }
  if (!note.empty()) {
    print_line(note);
  }
  drop_unusable(*rig, options, start);
  begin_network(options, start);
  // What the sensor runs with: --port, or a port that is taken, may have made it another one.
  start.active.udp_port = board.port.port();
  say_refusal(board::lock_memory());
  // The threads that help to compute inherit it.
  say_refusal(board::set_realtime_priority(true));
  posix::WorkerThreads workers({.threads = threads_of(start.active), .name = "stof-depth"});
  if (workers.error() != 0) {
    print_line("the system refuses threads, " + std::to_string(workers.threads()) + " of " +
               std::to_string(threads_of(start.active)) + " compute: check its limits");
  }
  static_cast<void>(board::set_realtime_priority(false));
  rig->threads = workers.threads();
  auto run_config = make_run_config(*rig, config, start.active);
  if (!run_config) {
    return refuse(run_config.error());
  }
  run_config->publisher.revision = 1;
  if (!options.port_file.empty() && !write_port(options.port_file, board.port.port())) {
    return refuse(options.port_file + ": cannot be written: check the folder and its permissions");
  }
  print_start(board, *rig, *run_config);
  ring.emplace(start.keys.get(), start.damaged_keys.get());
  read_keys(options, *ring);
  update::Updater updater(parts.setup());
  print_release(parts, updater);
  const int code = run_loop(board, options, *rig, config, *run_config, start, updater, workers);
  pairing.reset();
  ring.reset();
  print_line(summary(events.counters));
  print_line(stage_times(events.counters));
  return code == kExitOk ? end_of(updater) : code;
}

int print(const std::string& text) {
  std::printf("%s", text.c_str());
  return end_of_output();
}

int start_and_run(std::span<const std::string_view> arguments) {
  const auto options = parse_options(arguments);
  if (!options) {
    return refuse(options.error());
  }
  if (options->help) {
    return help();
  }
  if (options->schema) {
    return print(settings::settings_schema());
  }
  if (options->settings_table) {
    return print(settings::settings_tables());
  }
  if (!options->restart.empty()) {
    static_cast<void>(board::restart_machine(options->restart == "trial"));
    return refuse(
        "the board cannot be restarted: only its administrator may, on a board of its own",
        kExitFailure);
  }
  if (!options->which_slot.empty()) {
    const auto slot = slot_of_start(*options);
    return slot ? print(*slot + "\n") : refuse(slot.error());
  }
  if (!wire::start_crypto()) {
    return refuse("this system has no random numbers: keys cannot be used", kExitFailure);
  }
  const auto parts = open_update_parts(*options);
  if (!parts) {
    return refuse(parts.error());
  }
  watch_signals();
  auto start = read_settings(*options);
  if (!start) {
    return refuse(start.error().message, start.error().in_use ? kExitFailure : kExitBadInput);
  }
  const settings::Settings& active = start->active;
  const auto board =
      board::open({.udp_port = options->port.value_or(static_cast<std::uint16_t>(active.udp_port)),
                   .to = options->to,
                   .serial = std::string(active.serial.device.view()),
                   .baud = static_cast<std::uint32_t>(active.serial.baud),
                   .flow_control = active.serial.flow_control,
                   .dscp = active.dscp,
                   .mdns = true,
                   .port_required = options->port || names(*options, "udp.port"),
                   .serial_required = names(*options, "serial.device")},
                  options->board);
  if (!board) {
    if (!board.error().device) {
      forget_start(*start);
    }
    return refuse(board.error().message, board.error().device ? kExitFailure : kExitBadInput);
  }
  const int code = run(**board, *options, *start, *parts);
  if (code == kExitBadInput) {
    forget_start(*start);
  }
  return code;
}

}  // namespace
}  // namespace stof::firmware

int main(int argc, char** argv) {
  stof::posix::end_in_one_line_when_refused("stofd");
  const std::vector<std::string_view> arguments(argv + (argc > 0 ? 1 : 0), argv + argc);
  return stof::firmware::start_and_run(arguments);
}
