#include "board/emu/write_pair.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <utility>

#include "board/emu/exposures.h"
#include "board/emu/scenes.h"
#include "board/emu/write_set.h"
#include "dataset/dataset.h"
#include "dsp/base/parse_number.h"
#include "dsp/calib/stereo/column_tables.h"

namespace stof::board {
namespace {

namespace emu = hal::emu;

constexpr int kBadInput = 2;
constexpr std::uint32_t kMaxFrames = 1000;

struct WritePairOptions {
  SceneOptions scene;
  std::filesystem::path folder;
  std::uint32_t exposure = 0;
  std::uint32_t frames = 1;
  std::uint32_t sequence = 0;  // exposures, a folder each; 0: one, without
  bool help = false;
};

// Disparity of a point that the left pixel in column x sees, z metres away; infinite: none.
double disparity_of(const dsp::StereoRig& rig, int x, double z) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  double d = rig.left.fx * rig.baseline_m / z - rig.doff_px;
  if (const auto& c = rig.converging) {
    const double tangent = rig.baseline_m / z + dsp::left_tangent(rig, x);
    const double right =
        c->cx_right - c->f1_m / c->pixel_m * std::tan(std::atan(tangent) - c->alpha_rad);
    d = x - right;
  }
  return d > 0 ? d : kNone;
}

dataset::StereoScene stereo_scene(const SceneWorld& world, const WritePairOptions& options) {
  const dsp::StereoRig& rig = world.imagery->calibration().stereo;
  dataset::StereoScene scene = pictures_of(*world.imagery, options.exposure);
  scene.name = options.scene.name;
  if (options.scene.rig.changes_pair()) {  // raw pictures: what is true is in another folder
    return scene;
  }
  scene.visible = world.imagery->visible(options.exposure);
  scene.floor = world.floor;
  if (!rig.converging) {
    scene.rig = rig;
  }
  scene.truth = world.imagery->depth(options.exposure);
  for (int y = 0; y < scene.truth->height; ++y) {
    for (int x = 0; x < scene.truth->width; ++x) {
      float& value = scene.truth->view().at(x, y);
      value = static_cast<float>(disparity_of(rig, x, double{value}));
    }
  }
  return scene;
}

dataset::PmdRecording recording(const SceneWorld& world, const WritePairOptions& options) {
  dataset::PmdRecording out = recording_of(*world.imagery, options.exposure, options.frames);
  if (renders_as_it_goes(options.scene)) {  // else the world stands still through an exposure
    out.after_pair_us = after_pair_us(options.scene.times);
  }
  out.has_rig = !options.scene.rig.changes_pair();
  return out;
}

std::expected<std::uint32_t, std::string> count(std::string_view flag, std::string_view value,
                                                std::uint32_t low, std::uint32_t high) {
  const auto out = dsp::parse_number_in<std::uint32_t>(value, low, high);
  if (!out) {
    std::string line(flag);
    line += " takes a whole number from ";
    line += std::to_string(low);
    line += " to ";
    line += std::to_string(high);
    line += "; try --help";
    return std::unexpected(std::move(line));
  }
  return *out;
}

// What a flag with a number sets; nullptr: it takes none.
std::uint32_t* number_of(std::string_view flag, WritePairOptions& options) {
  if (flag == "--frames") {
    return &options.frames;
  }
  if (flag == "--sequence") {
    return &options.sequence;
  }
  return flag == "--exposure" ? &options.exposure : nullptr;
}

// One flag and its value.
std::expected<void, std::string> take(std::string_view flag, std::string_view value,
                                      WritePairOptions& options) {
  std::uint32_t* const counted = number_of(flag, options);
  if (counted != nullptr) {
    const std::expected<std::uint32_t, std::string> number =
        flag == "--exposure" ? count(flag, value, 0, 1'000'000) : count(flag, value, 1, kMaxFrames);
    if (!number) {
      return std::unexpected(number.error());
    }
    *counted = *number;
    return {};
  }
  const std::expected<bool, std::string> taken = take_scene_flag(flag, value, options.scene);
  if (!taken) {
    return std::unexpected(taken.error());
  }
  if (!*taken) {
    return std::unexpected("unknown argument \"" + std::string(flag) + "\"; try --help");
  }
  return {};
}

std::expected<WritePairOptions, std::string> parse(std::span<const std::string_view> arguments) {
  WritePairOptions options;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string_view argument = arguments[i];
    if (argument == "--help") {
      options.help = true;
      return options;
    }
    if (!argument.starts_with("--")) {
      if (!options.folder.empty()) {
        return std::unexpected("takes one folder to write to, not two; try --help");
      }
      options.folder = argument;
      continue;
    }
    if (i + 1 == arguments.size()) {
      return std::unexpected(std::string(argument) + " takes a value, or is unknown; try --help");
    }
    if (auto taken = take(argument, arguments[++i], options); !taken) {
      return std::unexpected(taken.error());
    }
  }
  if (options.folder.empty()) {
    return std::unexpected("takes the folder to write the emulated scene to; try --help");
  }
  if (const auto rig = seen_rig(options.scene); !rig) {
    return std::unexpected(rig.error());
  }
  const bool set = emu::is_board(options.scene.name) && options.sequence == 0;
  if (options.frames > 1 && moves(options.scene) && !set) {
    return std::unexpected("--frames: the scene moves: write a --sequence of exposures");
  }
  if (options.frames > 1 && options.sequence > 0) {
    return std::unexpected("--frames: each exposure of a --sequence has one: leave it out");
  }
  return options;
}

int complain(const std::string& line) {
  std::fprintf(stderr, "stof_emu_pair: %s\n", line.c_str());
  return kBadInput;
}

void print_help() {
  const std::string_view usage = scene_usage();
  std::printf(
      "stof_emu_pair DIR [flags]: writes an emulated scene as left.pgm, right.pgm, gt_left.pgm,\n"
      "nonocc.pgm, meta.txt and its PMD recording pmd.json, pmd_raw.pgm, pmd_fppn.pgm\n"
      "(`stof evaluate fusion DIR DIR/pmd`). Of a board or a plane it writes a calibration set: a\n"
      "folder DIR/pose_000 for each pose, and DIR/truth.json. Of a raw pair, DIR/ideal too.\n"
      "  --exposure N         which exposure (default 0): its noise, and where things that move "
      "are\n"
      "  --frames N           of the PMD recording (default 1)\n"
      "  --sequence N         so many exposures from there on, each in a folder DIR/0000 that is "
      "its\n"
      "                       number (`stof evaluate sequence DIR`)\n%.*s",
      static_cast<int>(usage.size()), usage.data());
}

// One exposure.
std::expected<void, dataset::Problem> write(const SceneWorld& world,
                                            const WritePairOptions& options) {
  auto written = make_folder(options.folder);
  if (written) {
    written = dataset::write_stereo_scene(options.folder, stereo_scene(world, options));
  }
  if (written && world.imagery->pmd_size() != emu::Size{}) {
    written = dataset::write_pmd(options.folder / "pmd", recording(world, options));
  }
  return written;
}

std::expected<void, dataset::Problem> write(const WritePairOptions& options) {
  if (auto made = make_folder(options.folder); !made) {
    return made;
  }
  if (emu::is_board(options.scene.name) && options.sequence == 0) {
    return write_set(options.folder, options.scene, options.exposure, options.frames);
  }
  const SceneWorld world = render_world(options.scene);
  if (options.sequence == 0) {
    const auto written = write(world, options);
    return written && options.scene.rig.changes_pair()
               ? write_ideal(options.folder, options.scene, options.exposure, options.frames)
               : written;
  }
  for (std::uint32_t i = 0; i < options.sequence; ++i) {
    WritePairOptions one = options;
    one.exposure += i;
    std::string number = std::to_string(one.exposure);
    number.insert(0, std::max<std::size_t>(number.size(), 4) - number.size(), '0');
    one.folder /= number;
    if (auto written = write(world, one); !written) {
      return written;
    }
  }
  return {};
}

}  // namespace

int write_pair(std::span<const std::string_view> arguments) {
  const std::expected<WritePairOptions, std::string> options = parse(arguments);
  if (!options) {
    return complain(options.error());
  }
  if (options->help) {
    print_help();
    return 0;
  }
  const std::expected<void, dataset::Problem> written = write(*options);
  return written ? 0 : complain(written.error().message);
}

}  // namespace stof::board
