#include "firmware/program/run_config.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <utility>

#include "dsp/stereo/matcher.h"
#include "firmware/events/health_monitor.h"
#include "firmware/pipeline/pipeline.h"
#include "firmware/settings/depth_settings.h"
#include "firmware/settings/fields/document.h"
#include "firmware/wire/calibration/calibration_file.h"
#include "firmware/wire/calibration/calibration_packet.h"

namespace stof::firmware {
namespace {

// That files of a rig may be longer than this board's: what is wrong is told by their sizes.
constexpr std::size_t kSlack = 65536;

std::string size_text(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

std::expected<std::vector<std::byte>, std::string> read_file(const std::string& name,
                                                             std::size_t limit) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(name.c_str(), "rb"),
                                                             &std::fclose);
  if (!file) {
    return std::unexpected(name + ": cannot be opened: check the name and its permissions");
  }
  std::vector<std::byte> bytes;
  std::array<std::byte, 4096> part;
  while (const std::size_t count = std::fread(part.data(), 1, part.size(), file.get())) {
    bytes.insert(bytes.end(), part.begin(), part.begin() + static_cast<std::ptrdiff_t>(count));
    if (bytes.size() > limit) {
      return std::unexpected(name + ": longer than any calibration of this board: check the name");
    }
  }
  if (std::ferror(file.get()) != 0) {
    return std::unexpected(name + ": cannot be read: check that it is a file");
  }
  return bytes;
}

// As read_rig_calibration(), into the rig. Empty, or a line behind the name.
std::string take_calibration(std::span<const std::byte> file, const std::string& name,
                             RigInfo& rig) {
  constexpr std::size_t kLineBytes = 320;
  std::array<char, kLineBytes> space{};
  settings::PagedWriter why(space);
  std::vector<std::int16_t> pattern(pattern_pixels(*rig.needs.board));
  const std::optional<dsp::Calibration> read = read_rig_calibration(file, rig.needs, pattern, why);
  if (!read) {
    return name + ": " + std::string(why.text());
  }
  rig.calibration = *read;
  rig.fixed_pattern = std::move(pattern);
  rig.fingerprint = wire::calibration_fingerprint(file);
  return {};
}

// The factory's calibration of the rig. Empty, or what is wrong with it.
std::string take_factory(const board::Board& board, const std::string& calibration_file,
                         RigInfo& rig) {
  if (!calibration_file.empty()) {
    auto file = read_file(calibration_file, most_calibration_bytes(*rig.needs.board) + kSlack);
    if (!file) {
      return file.error();
    }
    rig.factory = std::move(*file);
    return take_calibration(rig.factory, calibration_file, rig);
  }
  if (const char* const why = dsp::problem(rig.calibration); *why != '\0') {
    return std::string("the rig's calibration: ") + why + ": calibrate the rig anew";
  }
  if (board.nominal_calibration && !board.allow_nominal_calibration) {
    return "no calibration: give --calibration FILE (docs/CALIBRATION.md says how to make one), or "
           "--uncalibrated to see pictures";
  }
  rig.factory.resize(wire::calibration_file_bytes(rig.calibration));
  if (!wire::encode_calibration_file(rig.calibration, rig.factory)) {
    rig.factory.clear();
  }
  rig.fingerprint = wire::calibration_fingerprint(rig.factory);
  return {};
}

// The installed calibration, where there is one. Empty, or what is wrong with it.
std::string take_installed(const InstalledCalibration& installed, RigInfo& rig) {
  if (installed.unreadable) {
    rig.dropped = CalibrationDropped::kUnreadable;
    return installed.place + ": no regular file, or it cannot be read";
  }
  if (installed.file.empty()) {
    return {};
  }
  std::string why = take_calibration(installed.file, installed.place, rig);
  rig.installed = why.empty();
  rig.dropped = why.empty() ? CalibrationDropped::kNot : CalibrationDropped::kUnusable;
  return why;
}

// The shortest period in whole milliseconds that this board takes.
std::string period_advice(board::TimingConfig timing, hal::Duration least) {
  const auto from = std::chrono::ceil<std::chrono::milliseconds>(least);
  for (auto period = std::max(from, std::chrono::milliseconds(1));
       period <= std::chrono::milliseconds(settings::kMostPeriodMs);
       period += std::chrono::milliseconds(1)) {
    timing.period = period;
    if (*board::problem(timing) == '\0') {
      return "takes at least " + std::to_string(period.count()) + " ms";
    }
  }
  return "choose another period";
}

// Of the board in front of us, beside those of any.
std::string period_limits(const RigInfo& rig, const board::Config& config, hal::Duration period) {
  const auto text = [](hal::Duration time) {
    return std::to_string(std::chrono::ceil<std::chrono::milliseconds>(time).count()) + " ms";
  };
  if (period < rig.least_period) {
    return "period_ms: the cameras of board " + std::string(config.name) + " need " +
           text(rig.least_period) +
           " from edge to edge, or frames cannot be told apart: choose a "
           "longer period";
  }
  const hal::Duration timeout = config.devices.watchdog_timeout;
  if (timeout > hal::Duration::zero() && board::least_watchdog_timeout(period) > timeout) {
    return "period_ms: the watchdog of board " + std::string(config.name) + " waits for " +
           text(timeout) + ", three periods must fit: choose a shorter period";
  }
  return {};
}

std::string limits(const Setup& setup, const board::Config& config) {
  const dsp::Pinhole& left = setup.calibration.stereo.left;
  if (left.width > config.stereo.width || left.height > config.stereo.height) {
    return "the stereo pictures are " + size_text(left.width, left.height) + ", board " +
           config.name + " takes up to " + size_text(config.stereo.width, config.stereo.height) +
           ": use smaller ones";
  }
  const dsp::Pinhole& pmd = setup.calibration.pmd.lens;
  if (pmd.width > config.pmd.width || pmd.height > config.pmd.height) {
    return "the PMD pictures are " + size_text(pmd.width, pmd.height) + ", board " + config.name +
           " takes up to " + size_text(config.pmd.width, config.pmd.height) + ": use smaller ones";
  }
  if (setup.depth.match.disparities > config.stereo.disparities) {
    return std::to_string(setup.depth.match.disparities) + " disparities are more than the " +
           std::to_string(config.stereo.disparities) + " of board " + config.name +
           ": choose fewer with --disparities";
  }
  if (setup.depth.match.block_width > config.stereo.block_width ||
      setup.depth.match.block_height > config.stereo.block_height) {
    return "a block of " +
           size_text(setup.depth.match.block_width, setup.depth.match.block_height) +
           " is larger than the " +
           size_text(config.stereo.block_width, config.stereo.block_height) + " of board " +
           config.name + ": choose a smaller one with --block";
  }
  if (dsp::check(setup.depth.match, left.width, left.height) != Status::kOk) {
    return "pictures of " + size_text(left.width, left.height) +
           " cannot be matched with these parameters: check --disparities, --min-disparity and "
           "--block";
  }
  return {};
}

// What of the settings leaves a robot without depth.
std::uint32_t blinding(const settings::Settings& settings) {
  constexpr int kShortRangeMm = 1000;
  const wire::StreamChoice& streams = settings.streams;
  const bool sent = streams.of(wire::Stream::kDepth) != wire::Coding::kOff ||
                    streams.of(wire::Stream::kCloud) != wire::Coding::kOff ||
                    (settings.serial.mode != settings::SerialMode::kOff &&
                     !settings.serial.device.view().empty());
  return (sent ? 0U : HealthMonitor::kNoDepthStream) |
         (settings.depth.max_range_mm < kShortRangeMm ? HealthMonitor::kShortRange : 0U);
}

// As many threads as there is memory for; each searches in memory of its own.
std::string share_memory(RunConfig& run_config, const board::Config& config, std::size_t room) {
  Setup& setup = run_config.setup;
  const auto measure = [&setup] {
    return dsp::bytes_taken([&setup](dsp::Arena& arena) noexcept {
      Pipeline(setup, arena, dsp::ThreadTeam::standing_for(setup.threads));
    });
  };
  run_config.image_bytes = measure();
  while (run_config.image_bytes > room && setup.threads > 1) {
    --setup.threads;
    run_config.image_bytes = measure();
  }
  if (run_config.image_bytes > room) {
    const dsp::Pinhole& left = setup.calibration.stereo.left;
    return "matching " + size_text(left.width, left.height) + " with " +
           std::to_string(setup.depth.match.disparities) + " disparities in this way takes " +
           std::to_string(run_config.image_bytes / kMiB + 1) + " MiB, board " + config.name +
           " has " + std::to_string(room / kMiB) +
           ": use fewer disparities, fewer threads or another preset";
  }
  return {};
}

}  // namespace

std::expected<RigInfo, std::string> make_rig(const board::Board& board, const board::Config& config,
                                             const std::string& calibration_file,
                                             const InstalledCalibration& installed,
                                             std::string& note) {
  RigInfo rig{.calibration = board.calibration,
              .fixed_pattern = {},
              .factory = {},
              .needs = {.board = &config},
              .disparities = board.disparities,
              .threads = 1,
              .least_period = board.least_period};
  if (const char* const why = dsp::complete(rig.calibration.stereo); *why != '\0') {
    return std::unexpected(std::string("the rig's calibration: ") + why +
                           ": calibrate the rig anew");
  }
  if (board.pmd == nullptr) {
    rig.calibration.pmd.lens = {};
  }
  rig.needs.left = rig.calibration.stereo.left;
  rig.needs.pmd = rig.calibration.pmd.lens;
  if (board.nominal_calibration) {
    rig.needs.modulation = rig.calibration.pmd.frequency.modulation;
  }
  const std::string no_factory = take_factory(board, calibration_file, rig);
  // What the command line names has to be good; that it names nothing may be made good for.
  if (!no_factory.empty() && !calibration_file.empty()) {
    return std::unexpected(no_factory);
  }
  note = take_installed(installed, rig);
  if (!no_factory.empty() && !rig.installed) {
    return std::unexpected(note.empty() ? no_factory : note + "; " + no_factory);
  }
  if (!note.empty()) {
    note += "; the factory's calibration holds";
  }
  return rig;
}

std::expected<RunConfig, std::string> make_run_config(const RigInfo& rig,
                                                      const board::Config& config,
                                                      const settings::Settings& settings,
                                                      std::size_t room) {
  if (const char* const why = settings::problem(settings); *why != '\0') {
    return std::unexpected(std::string(why));
  }
  RunConfig run_config{
      .setup = {.calibration = rig.calibration,
                .depth = settings::depth_params(settings, rig.disparities),
                .threads = rig.threads,
                .require_both = settings.depth.require == settings::RequiredSensors::kBoth},
      .timing = config.timing,
      .publisher = {.choice = settings.streams,
                    .pace_percent = settings.pace_percent,
                    .fingerprint = settings::fingerprint(settings),
                    .blinding = blinding(settings)},
      .serial = serial_params(settings),
      .calibration = {},
      .installs = rig.installs,
      .standby = settings.standby};
  if (settings.period_ms > 0) {
    run_config.timing.period = std::chrono::milliseconds(settings.period_ms);
  }
  run_config.publisher.period = run_config.timing.period;
  run_config.publisher.pmd_every = run_config.timing.pmd_every;
  run_config.publisher.disparities = run_config.setup.depth.match.disparities;
  run_config.publisher.max_range = run_config.setup.depth.fusion.max_range;
  if (const char* const why = board::problem(run_config.timing); *why != '\0') {
    return std::unexpected(std::string("period_ms: ") + why + ": " +
                           period_advice(run_config.timing, rig.least_period));
  }
  if (std::string why = period_limits(rig, config, run_config.timing.period); !why.empty()) {
    return std::unexpected(std::move(why));
  }
  if (std::string why = limits(run_config.setup, config); !why.empty()) {
    return std::unexpected(std::move(why));
  }
  if (std::string why = share_memory(run_config, config, room); !why.empty()) {
    return std::unexpected(std::move(why));
  }
  const auto packet = wire::make_calibration_packet(run_config.setup.calibration,
                                                    run_config.setup.depth.fusion.max_range,
                                                    run_config.timing.period.count());
  if (!packet) {
    return std::unexpected(
        std::string("the rig's calibration holds numbers that no rig has: calibrate it anew"));
  }
  run_config.calibration = *packet;
  run_config.calibration.fingerprint = rig.fingerprint;
  return run_config;
}

}  // namespace stof::firmware
