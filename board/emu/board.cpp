#include "board/board.h"

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "board/devices/connections.h"
#include "board/emu/emu_options.h"
#include "board/emu/fault_orders.h"
#include "board/emu/recorded_rig.h"
#include "board/emu/scenes.h"
#include "dataset/dataset.h"
#include "hal/emu/cameras/pmd_camera.h"
#include "hal/emu/cameras/stereo_camera.h"
#include "hal/emu/cameras/trigger.h"
#include "hal/emu/devices/clock.h"
#include "hal/emu/imagery/replay.h"
#include "hal/linux/system/clock.h"
#include "hal/linux/system/file_disk.h"
#include "hal/linux/system/file_lock.h"
#include "hal/linux/system/file_slots.h"
#include "hal/linux/system/file_store.h"
#include "hal/linux/system/local_orders.h"
#include "hal/linux/system/realtime.h"
#include "hal/linux/system/signal_button.h"

namespace stof::board {
namespace {

namespace emu = hal::emu;

std::unexpected<Refusal> refuse(std::string message) {
  return std::unexpected(Refusal{std::move(message)});
}

// What the cameras see, and what is known about it.
struct World {
  std::unique_ptr<emu::Imagery> imagery;
  dsp::Calibration calibration;
  int disparities = 0;
  bool recorded = false;
  std::optional<dataset::Image<float>> depth;  // Z in metres, +inf = unknown
  std::vector<std::string> notes;
};

World rendered(const EmuOptions& options) {
  constexpr std::uint32_t kFirst = 1;  // exposures count from 1
  SceneOptions wanted = options.scene;
  const auto seconds = [](hal::Duration time) {
    return std::chrono::duration<double>(time).count();
  };
  wanted.times = {.period = seconds(kConfig.timing.period),
                  .pair = seconds(kConfig.timing.stereo_exposure),
                  .pmd = seconds(kConfig.timing.pmd_integration),
                  .pmd_every = kConfig.timing.pmd_every};
  SceneWorld scene = render_world(wanted);
  World world;
  world.calibration = scene.imagery->calibration();
  world.disparities = scene.imagery->disparities();
  if (!moves(wanted)) {
    world.depth = scene.imagery->depth(kFirst);
  }
  world.imagery = std::move(scene.imagery);
  if (world.imagery->pmd_size() == emu::Size{}) {
    world.notes.emplace_back("no PMD camera (--no-tof): depth from stereo alone");
  }
  return world;
}

// The recording that was asked for, else the one beside the dataset, if there is one.
std::optional<std::filesystem::path> find_tof(const EmuOptions& options,
                                              std::vector<std::string>& notes) {
  if (options.no_tof) {
    notes.emplace_back("no PMD camera (--no-tof): depth from stereo alone");
    return std::nullopt;
  }
  std::optional<std::filesystem::path> found =
      options.tof ? options.tof : recording_beside(*options.dataset);
  if (!found) {
    notes.emplace_back(
        "no PMD recording beside the dataset, and no --tof: depth from stereo alone");
  }
  return found;
}

std::expected<World, Refusal> replay(const EmuOptions& options) {
  World world;
  const std::optional<std::filesystem::path> tof = find_tof(options, world.notes);
  dataset::Loaded<std::unique_ptr<emu::Replay>> opened = emu::Replay::open(*options.dataset, tof);
  if (!opened) {
    return refuse(opened.error().message);
  }
  const emu::Replay& recorded = **opened;
  if (recorded.rig_is_assumed()) {
    world.notes.emplace_back(
        "the dataset does not say what its cameras were: a 0.16 m baseline and a focal length of "
        "one image width "
        "are assumed, depth has an arbitrary scale");
  }
  world.calibration = recorded.calibration();
  world.disparities = recorded.disparities();
  world.recorded = true;
  world.depth = recorded.depth();
  world.imagery = std::move(*opened);
  return world;
}

std::optional<Refusal> write_truth(const std::filesystem::path& file, const World& world) {
  if (!world.depth) {
    return Refusal{"--truth: the dataset has no ground truth (gt_left.pgm); leave --truth out"};
  }
  if (const auto written = dataset::write_pfm(file, *world.depth); !written) {
    return Refusal{written.error().message};
  }
  return std::nullopt;
}

emu::StereoTiming stereo_timing() { return {.exposure = kConfig.timing.stereo_exposure}; }

// The rig as long as the program lives. Real time unless --free-run, so that latency means
// something.
struct Rig {
  World world;
  FaultOrders orders;
  OpenConnections connections;
  emu::Clock emulated_clock;
  hal::linux::Clock machine_clock;
  hal::Clock& clock;
  emu::StereoCamera stereo;
  std::optional<emu::PmdCamera> pmd;
  std::optional<emu::Trigger> trigger;
  hal::linux::SignalButton button;
  std::optional<Board> board;
  std::optional<hal::linux::LocalOrders> order_socket;  // last: its thread uses the orders

  Rig(World&& seen, OpenConnections&& opened, const EmuOptions& options)
      : world(std::move(seen)),
        orders(world.imagery->pmd_size() != emu::Size{}),
        connections(std::move(opened)),
        clock(options.free_run ? static_cast<hal::Clock&>(emulated_clock) : machine_clock),
        stereo(clock, *world.imagery, stereo_timing(), options.faults_of(Device::kStereo),
               &orders.of(Device::kStereo)) {
    constexpr hal::Duration kPulse = std::chrono::microseconds(50);
    if (world.imagery->pmd_size() != emu::Size{}) {
      pmd.emplace(clock, *world.imagery,
                  emu::PmdTiming{.integration = kConfig.timing.pmd_integration,
                                 .every = kConfig.timing.pmd_every},
                  options.faults_of(Device::kPmd), &orders.of(Device::kPmd));
      trigger.emplace(clock, kPulse, std::initializer_list<emu::EdgeListener*>{&stereo, &*pmd},
                      options.faults_of(Device::kTrigger), &orders.of(Device::kTrigger));
    } else {
      trigger.emplace(clock, kPulse, std::initializer_list<emu::EdgeListener*>{&stereo},
                      options.faults_of(Device::kTrigger), &orders.of(Device::kTrigger));
    }
    board.emplace(Board{.clock = clock,
                        .trigger = *trigger,
                        .stereo = stereo,
                        .pmd = pmd ? &*pmd : nullptr,
                        .port = *connections.port,
                        .serial = connections.serial ? &*connections.serial : nullptr,
                        .to = connections.to,
                        .network = *connections.network,
                        .beacon = connections.beacon.get(),
                        .mdns = connections.mdns.get(),
                        .button = &button,
                        .calibration = world.calibration,
                        .disparities = world.disparities,
                        .emulated_time = options.free_run,
                        .other_port = connections.other_port,
                        .recorded = world.recorded,
                        .notes = world.notes});
    board->notes.push_back(hal::linux::SignalButton::usage());
    board->notes.insert(board->notes.end(), connections.notes.begin(), connections.notes.end());
  }
};

std::optional<Rig> rig;

// A recording in its place.
struct RecordedBoard {
  std::unique_ptr<RecordedRig> devices;
  OpenConnections connections;
  hal::linux::SignalButton button;
  std::optional<Board> board;

  RecordedBoard(std::unique_ptr<RecordedRig> recorded, OpenConnections&& opened)
      : devices(std::move(recorded)), connections(std::move(opened)) {
    const bool has_pmd = devices->calibration().pmd.lens.width > 0;
    board.emplace(Board{.clock = devices->clock(),
                        .trigger = *devices,
                        .stereo = devices->stereo(),
                        .pmd = has_pmd ? &devices->pmd() : nullptr,
                        .port = *connections.port,
                        .serial = connections.serial ? &*connections.serial : nullptr,
                        .to = connections.to,
                        .network = *connections.network,
                        .beacon = connections.beacon.get(),
                        .mdns = connections.mdns.get(),
                        .button = &button,
                        .calibration = devices->calibration(),
                        .disparities = devices->disparities(),
                        .emulated_time = true,
                        .other_port = connections.other_port,
                        .replay = devices.get(),
                        .recorded = true,
                        .notes = devices->notes()});
    board->notes.insert(board->notes.end(), connections.notes.begin(), connections.notes.end());
  }
};

std::optional<RecordedBoard> recorded_board;

}  // namespace

std::expected<Board*, Refusal> open(const Connections& connections,
                                    std::span<const std::string_view> arguments) {
  const std::expected<EmuOptions, Refusal> options = parse_emu_options(arguments);
  if (!options) {
    return std::unexpected(options.error());
  }
  std::expected<OpenConnections, Refusal> talks = open_connections(connections);
  if (!talks) {
    return std::unexpected(talks.error());
  }
  if (options->replay) {
    auto recorded = RecordedRig::open(*options->replay, !options->free_run);
    if (!recorded) {
      return refuse(std::move(recorded.error()));
    }
    return &*recorded_board.emplace(std::move(*recorded), std::move(*talks)).board;
  }
  std::expected<World, Refusal> world = options->dataset ? replay(*options) : rendered(*options);
  if (!world) {
    return std::unexpected(world.error());
  }
  if (options->truth) {
    if (std::optional<Refusal> refusal = write_truth(*options->truth, *world)) {
      return std::unexpected(*refusal);
    }
  }
  rig.emplace(std::move(*world), std::move(*talks), *options);
  if (!options->fault_socket.empty()) {
    auto socket = hal::linux::LocalOrders::open(
        options->fault_socket, [](std::string_view order) { return rig->orders.obey(order); });
    if (!socket) {
      return refuse("--fault-socket: " + socket.error());
    }
    rig->order_socket.emplace(std::move(*socket));
  }
  return &*rig->board;
}

std::unique_ptr<hal::Store> make_store(std::string_view name) {
  return std::make_unique<hal::linux::FileStore>(std::string(name));
}

std::unique_ptr<hal::Store> make_secret_store(std::string_view name) {
  return std::make_unique<hal::linux::FileStore>(std::string(name),
                                                 hal::linux::FileStore::Readers::kOwner);
}

Status hold_alone(std::string_view name, bool make) {
  return hal::linux::hold_file(std::string(name), make, std::chrono::seconds(2));
}

Result<std::unique_ptr<hal::Disk>> make_disk(std::string_view name) {
  return hal::linux::FileDisk::open(std::string(name));
}

Result<std::unique_ptr<hal::Slots>> make_slots(std::string_view prefix) {
  return hal::linux::FileSlots::open(std::string(prefix));
}

Status restart_machine(bool /*trial*/) noexcept { return Status::kUnsupported; }

// An emulated rig shares a laptop with others.
std::optional<std::string> lock_memory() { return std::nullopt; }
void keep_memory_private() noexcept { hal::linux::keep_memory_private(); }
std::optional<std::string> set_realtime_priority(bool) { return std::nullopt; }
void count_heap_calls() noexcept {}
HeapCalls heap_calls() noexcept { return {}; }

// Emulated devices come back by themselves when their fault ends, but for cameras that hang.
Status reopen(Board& /*board*/, Device device) noexcept {
  if (!rig) {
    return Status::kOk;
  }
  if (device == Device::kStereo) {
    rig->stereo.reopen();
  } else if (device == Device::kPmd && rig->pmd) {
    rig->pmd->reopen();
  }
  return Status::kOk;
}

}  // namespace stof::board
