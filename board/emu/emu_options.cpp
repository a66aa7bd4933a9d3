#include "board/emu/emu_options.h"

#include <algorithm>
#include <utility>

#include "board/emu/fault_orders.h"
#include "dsp/base/parse_number.h"

namespace stof::board {
namespace {

namespace emu = hal::emu;

std::unexpected<Refusal> refuse(std::string message) {
  return std::unexpected(Refusal{std::move(message)});
}

// N or N+CALLS.
bool parse_calls(std::string_view text, emu::Fault& fault) {
  const std::size_t plus = text.find('+');
  const auto first = dsp::parse_number<std::uint32_t>(text.substr(0, plus));
  const auto calls = plus == std::string_view::npos
                         ? std::optional(fault.calls)
                         : dsp::parse_number<std::uint32_t>(text.substr(plus + 1));
  if (!first || !calls || *calls == 0) {
    return false;
  }
  fault.call = *first;
  fault.calls = *calls;
  return true;
}

// DEVICE:KIND:CALL[+CALLS][:EVERY], such as stereo:drop:30, pmd:vanish:30+300 or pmd:repeat:10:10.
bool parse_fault(std::string_view text, std::array<emu::FaultPlan, kDeviceCount>& plans) {
  std::array<std::string_view, 4> parts{};
  std::size_t count = 0;
  for (std::size_t begin = 0; begin <= text.size(); ++count) {
    if (count == parts.size()) {
      return false;
    }
    const std::size_t end = std::min(text.find(':', begin), text.size());
    parts[count] = text.substr(begin, end - begin);
    begin = end + 1;
  }
  const std::optional<Device> device = device_named(parts[0]);
  const std::optional<emu::FaultKind> kind = fault_named(parts[1]);
  const auto every = count > 3 ? dsp::parse_number<std::uint32_t>(parts[3]) : std::optional(0U);
  emu::Fault fault{.duration = emu::kUsualFaultDuration};
  if (count < 3 || !device || !kind || !every || !parse_calls(parts[2], fault)) {
    return false;
  }
  fault.kind = *kind;
  fault.every = *every;
  return plans[static_cast<std::size_t>(*device)].add(fault);
}

bool take_switch(std::string_view flag, EmuOptions& options) {
  if (flag == "--free-run") {
    options.free_run = true;
  } else if (flag == "--no-tof") {
    options.no_tof = true;
  } else {
    return false;
  }
  return true;
}

bool take_value(std::string_view flag, std::string_view value, EmuOptions& options) {
  if (flag == "--dataset") {
    options.dataset = value;
  } else if (flag == "--tof") {
    options.tof = value;
  } else if (flag == "--truth") {
    options.truth = value;
  } else if (flag == "--replay") {
    options.replay = value;
  } else if (flag == "--fault-socket") {
    options.fault_socket = value;
  } else {
    return false;
  }
  return true;
}

// Flags that do not go together, in a line; empty: they do.
std::string contradiction(const EmuOptions& options, const std::string& scene_flag) {
  const bool sees =
      !scene_flag.empty() || options.dataset || options.no_tof || options.truth ||
      !options.fault_socket.empty() ||
      std::ranges::any_of(options.faults, [](const emu::FaultPlan& plan) { return !plan.empty(); });
  if (options.replay && sees) {
    return "--replay: what the cameras saw is in the recording: leave scene, dataset and faults "
           "out";
  }
  if (!scene_flag.empty() && options.dataset) {
    return scene_flag + " and --dataset exclude each other; leave one out";
  }
  if (options.tof && (options.no_tof || !options.dataset)) {
    return "--tof belongs to a --dataset, and excludes --no-tof";
  }
  return {};
}

}  // namespace

std::optional<std::filesystem::path> recording_beside(const std::filesystem::path& dataset) {
  std::error_code error;
  const std::filesystem::path absolute = std::filesystem::absolute(dataset / "", error);
  const std::filesystem::path folder = absolute.lexically_normal().parent_path();
  const std::filesystem::path data = folder.parent_path().parent_path();
  const std::string name = folder.filename().string() + "_64x16";
  for (const std::filesystem::path& beside : {data / "tof", data}) {
    std::filesystem::path prefix = beside / "sim" / "scene" / name;
    if (std::filesystem::exists(prefix.string() + ".json", error)) {
      return prefix;
    }
  }
  return std::nullopt;
}

std::expected<EmuOptions, Refusal> parse_emu_options(std::span<const std::string_view> arguments) {
  EmuOptions options;
  std::string scene_flag;  // one of those that only a rendered scene has
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string flag(arguments[i]);
    if (take_switch(flag, options)) {
      continue;
    }
    const bool last = i + 1 == arguments.size();
    const std::string_view value = last ? std::string_view() : arguments[i + 1];
    const std::expected<bool, std::string> of_scene = take_scene_flag(flag, value, options.scene);
    if (value.empty() && (!of_scene || *of_scene)) {
      return refuse(flag + " takes a value; try --help");
    }
    if (!of_scene) {
      return refuse(of_scene.error());
    }
    if (*of_scene) {
      scene_flag = flag;
    } else if (flag == "--fault") {
      if (!parse_fault(value, options.faults)) {
        return refuse(
            "--fault takes DEVICE:KIND:CALL[+CALLS][:EVERY], such as stereo:drop:30, eight of a "
            "device, not \"" +
            std::string(value) + "\"; try --help");
      }
    } else if (!take_value(flag, value, options)) {
      return refuse("unknown argument \"" + flag + "\"; try --help");
    } else if (value.empty()) {
      return refuse(flag + " takes a value; try --help");
    }
    ++i;
  }
  if (std::string line = contradiction(options, scene_flag); !line.empty()) {
    return refuse(std::move(line));
  }
  if (options.no_tof) {
    options.scene.pmd = emu::Size{};
  }
  if (options.truth && !options.dataset && moves(options.scene)) {
    return refuse("--truth: the scene " + options.scene.name +
                  " moves: leave --truth out, or take another scene");
  }
  if (!options.dataset) {
    if (std::expected<emu::Rig, std::string> rig = seen_rig(options.scene); !rig) {
      return refuse(std::move(rig.error()));
    }
  }
  if (!options.replay && renders_as_it_goes(options.scene) && !options.free_run) {
    return refuse("--scene " + options.scene.name +
                  ": its pictures take longer than real time: add --free-run");
  }
  return options;
}

std::string_view usage() noexcept {
  static constexpr std::string_view kRest =
      "  --dataset DIR        a recorded stereo pair in place of the scene: left.pgm, "
      "right.pgm, meta.txt\n"
      "  --tof PREFIX         its PMD recording, PREFIX.json and PREFIX_raw.pgm\n"
      "                       (default: what lies beside DIR as "
      "DIR/../../tof/sim/scene/<name>_64x16)\n"
      "  --no-tof             a rig without PMD camera\n"
      "  --truth FILE         write the exact depth as PFM: Z in metres, left view, inf = "
      "unknown\n"
      "  --replay FILE        compute depth again of a recording with raw pictures (stof record "
      "--raw), with\n"
      "                       its settings and stamps, and compare it with what was recorded: "
      "exit code 0\n"
      "                       where all of it is equal. --free-run: as fast as this machine "
      "computes\n"
      "  --free-run           emulated time, as fast as this machine computes\n"
      "  --fault D:KIND:N[+K][:M]\n"
      "                       fault at call N, and at those behind it until there are K (and again "
      "every M\n"
      "                       calls), of D = trigger, stereo, pmd; KIND = drop, delay, repeat, "
      "tear, "
      "corrupt,\n"
      "                       vanish, freeze (old pixels: of the right picture, of all samples), "
      "dark (no lamp),\n"
      "                       hang (freeze, until it is opened again);\n"
      "                       up to eight of a device\n"
      "  --fault-socket PATH  take faults while it runs (stof fault PATH pmd:vanish:30), of "
      "programs "
      "of this user\n"
      "                       alone: a socket at PATH\n";
  static const std::string text = [] {
    std::string all(scene_usage());
    all += kRest;
    return all;
  }();
  return text;
}

}  // namespace stof::board
