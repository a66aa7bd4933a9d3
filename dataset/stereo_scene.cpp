#include "dataset/stereo_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "dataset/files/file.h"
#include "dataset/files/pgm.h"
#include "dsp/base/parse_number.h"

namespace stof::dataset {
namespace {

constexpr std::size_t kMaxMetaBytes = 1U << 20;
constexpr int kMaxNdisp = 4096;
constexpr double kMaxPlaneZ = 1000;  // metres

// What stands behind `key` at the beginning of a line of meta.txt, for each of these lines.
std::vector<std::string_view> meta_values(std::string_view text, std::string_view key) {
  std::vector<std::string_view> values;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.starts_with(key) && line.size() > key.size() &&
        (line[key.size()] == ' ' || line[key.size()] == '\t')) {
      line.remove_prefix(std::min(line.find_first_not_of(" \t", key.size()), line.size()));
      values.push_back(line.substr(0, line.find_last_not_of(" \t\r") + 1));
    }
  }
  return values;
}

std::optional<double> meta_number(std::string_view text, std::string_view key) {
  const std::vector<std::string_view> values = meta_values(text, key);
  return values.empty() ? std::nullopt : dsp::parse_number<double>(values.front());
}

std::string folder_name(const std::filesystem::path& dir) {
  std::error_code error;
  const std::filesystem::path whole = std::filesystem::weakly_canonical(dir, error);
  const std::filesystem::path name = (error ? dir : whole).filename();
  return name.empty() ? "scene" : name.string();
}

template <typename T>
std::expected<void, Problem> same_size_as_left(const std::filesystem::path& file,
                                               const Image<T>& image, const StereoScene& scene) {
  if (image.width != scene.left.width || image.height != scene.left.height) {
    return refuse(file,
                  "is " + size_text(image.width, image.height) + " but left.pgm is " +
                      size_text(scene.left.width, scene.left.height),
                  "use pictures of one size");
  }
  return {};
}

// Every key that is read stands there once, and a size is that of the pictures.
std::expected<void, Problem> check_meta(const std::filesystem::path& file, std::string_view meta,
                                        const StereoScene& scene) {
  for (const char* const key : {"ndisp", "gt_scale", "f_px", "baseline_m", "doff_px", "width",
                                "height", "camera_height_m", "camera_tilt_degrees", "plane_z_m"}) {
    if (meta_values(meta, key).size() > 1) {
      return refuse(file, std::string("has ") + key + " twice", "keep one of the lines");
    }
  }
  for (const auto& [key, side] :
       {std::pair("width", scene.left.width), std::pair("height", scene.left.height)}) {
    const std::vector<std::string_view> values = meta_values(meta, key);
    if (!values.empty() && dsp::parse_number<int>(values.front()) != side) {
      return refuse(file,
                    std::string("says ") + key + " " + std::string(values.front()) +
                        ", left.pgm is " + size_text(scene.left.width, scene.left.height),
                    "give the pictures that it describes, or take the line out");
    }
  }
  return {};
}

std::expected<void, Problem> read_truth(const std::filesystem::path& dir, std::string_view meta,
                                        StereoScene& scene) {
  const std::filesystem::path file = dir / "gt_left.pgm";
  if (!is_there(file)) {
    return {};
  }
  const std::optional<double> scale = meta_number(meta, "gt_scale");
  if (!scale || !(*scale > 0) || !(*scale <= 65535)) {
    return refuse(dir / "meta.txt", "has no usable gt_scale for gt_left.pgm",
                  "add a line such as \"gt_scale 4\"");
  }
  const Loaded<Image<std::uint16_t>> values = read_pgm16(file);
  if (!values) {
    return std::unexpected(values.error());
  }
  if (std::expected<void, Problem> same = same_size_as_left(file, *values, scene); !same) {
    return same;
  }
  Image<float> truth(values->width, values->height, std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < truth.pixels.size(); ++i) {
    if (values->pixels[i] != 0) {
      truth.pixels[i] = static_cast<float>(values->pixels[i] / *scale);
    }
  }
  scene.truth = std::move(truth);
  return {};
}

std::expected<void, Problem> read_visible(const std::filesystem::path& dir, StereoScene& scene) {
  const std::filesystem::path file = dir / "nonocc.pgm";
  if (!is_there(file)) {
    return {};
  }
  Loaded<Image<std::uint8_t>> mask = read_pgm8(file);
  if (!mask) {
    return std::unexpected(std::move(mask.error()));
  }
  if (std::expected<void, Problem> same = same_size_as_left(file, *mask, scene); !same) {
    return same;
  }
  scene.visible = std::move(*mask);
  return {};
}

std::expected<void, Problem> read_floor(const std::filesystem::path& dir, std::string_view meta,
                                        StereoScene& scene) {
  const std::filesystem::path file = dir / "surfaces.pgm";
  if (!is_there(file)) {
    return {};
  }
  constexpr double kLargestTilt = 90;
  const double height = meta_number(meta, "camera_height_m").value_or(0);
  const double tilt = meta_number(meta, "camera_tilt_degrees").value_or(kLargestTilt);
  if (!(height > 0) || !std::isfinite(height) || !(std::abs(tilt) < kLargestTilt)) {
    return refuse(dir / "meta.txt",
                  "has no usable camera_height_m and camera_tilt_degrees for surfaces.pgm",
                  R"(add lines such as "camera_height_m 0.6" and "camera_tilt_degrees 15")");
  }
  const Loaded<Image<std::uint8_t>> values = read_pgm8(file);
  if (!values) {
    return std::unexpected(values.error());
  }
  if (std::expected<void, Problem> same = same_size_as_left(file, *values, scene); !same) {
    return same;
  }
  FloorTruth floor{
      .height_m = height, .tilt_degrees = tilt, .surface = {values->width, values->height}};
  std::ranges::transform(values->pixels, floor.surface.pixels.begin(), [](std::uint8_t value) {
    return value < kSurfaces ? static_cast<Surface>(value) : Surface::kOther;
  });
  scene.floor = std::move(floor);
  return {};
}

std::optional<dsp::StereoRig> read_rig(std::string_view meta, const StereoScene& scene) {
  const double focal = meta_number(meta, "f_px").value_or(0);
  const double baseline = meta_number(meta, "baseline_m").value_or(0);
  const double doff = meta_number(meta, "doff_px").value_or(0);
  if (!(focal > 0) || !(baseline > 0) || !std::isfinite(focal + baseline + doff)) {
    return std::nullopt;
  }
  return dsp::StereoRig{.left = {.width = scene.left.width,
                                 .height = scene.left.height,
                                 .fx = focal,
                                 .fy = focal,
                                 .cx = (scene.left.width - 1) / 2.0,
                                 .cy = (scene.left.height - 1) / 2.0},
                        .baseline_m = baseline,
                        .doff_px = doff};
}

std::expected<void, Problem> read_pair(const std::filesystem::path& dir, StereoScene& scene) {
  Loaded<Image<std::uint8_t>> left = read_pgm8(dir / "left.pgm");
  if (!left) {
    return std::unexpected(std::move(left.error()));
  }
  Loaded<Image<std::uint8_t>> right = read_pgm8(dir / "right.pgm");
  if (!right) {
    return std::unexpected(std::move(right.error()));
  }
  scene.left = std::move(*left);
  scene.right = std::move(*right);
  return same_size_as_left(dir / "right.pgm", scene.right, scene);
}

constexpr int kTruthScale = 256;
constexpr float kMaxTruthPx = 255;

// 0 = unknown.
std::string truth_pgm(const Image<float>& truth) {
  Image<std::uint16_t> steps(truth.width, truth.height);
  std::ranges::transform(truth.pixels, steps.pixels.begin(), [](float d) {
    const long value = std::isfinite(d) && d > 0
                           ? std::max(std::lround(std::min(d, kMaxTruthPx) * kTruthScale), 1L)
                           : 0;
    return static_cast<std::uint16_t>(value);
  });
  return pgm_bytes(steps);
}

std::string meta(const StereoScene& scene) {
  std::string text = "scene " + scene.name + "\nndisp " + std::to_string(scene.ndisp) +
                     "\ngt_scale " + std::to_string(kTruthScale) + "\n";
  if (scene.rig) {
    std::array<char, 160> rig{};
    std::snprintf(rig.data(), rig.size(), "f_px %.17g\nbaseline_m %.17g\ndoff_px %.17g\n",
                  scene.rig->left.fx, scene.rig->baseline_m, scene.rig->doff_px);
    text += rig.data();
  }
  if (scene.plane_z_m) {
    std::array<char, 48> plane{};
    std::snprintf(plane.data(), plane.size(), "plane_z_m %.17g\n", *scene.plane_z_m);
    text += plane.data();
  }
  if (scene.floor) {
    std::array<char, 96> pose{};
    std::snprintf(pose.data(), pose.size(), "camera_height_m %.17g\ncamera_tilt_degrees %.17g\n",
                  scene.floor->height_m, scene.floor->tilt_degrees);
    text += pose.data();
  }
  return text;
}

}  // namespace

Loaded<StereoScene> read_stereo_scene(const std::filesystem::path& dir) {
  std::error_code error;
  if (!std::filesystem::is_directory(dir, error)) {
    return refuse(dir, "is not a folder", "give a folder with left.pgm, right.pgm and meta.txt");
  }
  StereoScene scene;
  scene.name = folder_name(dir);
  if (std::expected<void, Problem> pair = read_pair(dir, scene); !pair) {
    return std::unexpected(std::move(pair.error()));
  }
  const Loaded<std::string> meta = read_whole(dir / "meta.txt", kMaxMetaBytes);
  if (!meta) {
    return std::unexpected(meta.error());
  }
  if (std::expected<void, Problem> checked = check_meta(dir / "meta.txt", *meta, scene); !checked) {
    return std::unexpected(std::move(checked.error()));
  }
  const std::optional<double> ndisp = meta_number(*meta, "ndisp");
  if (!ndisp || !(*ndisp >= 1) || !(*ndisp <= kMaxNdisp) || *ndisp != static_cast<int>(*ndisp)) {
    return refuse(dir / "meta.txt", "has no usable ndisp (the search range, 1 to 4096)",
                  "add a line such as \"ndisp 64\"");
  }
  scene.ndisp = static_cast<int>(*ndisp);
  scene.plane_z_m = meta_number(*meta, "plane_z_m");
  if (!meta_values(*meta, "plane_z_m").empty() &&
      !(scene.plane_z_m && *scene.plane_z_m > 0 && *scene.plane_z_m <= kMaxPlaneZ)) {
    return refuse(dir / "meta.txt", "has no usable plane_z_m (metres, up to 1000)",
                  "add a line such as \"plane_z_m 1.6\", or leave it out");
  }
  scene.rig = read_rig(*meta, scene);
  if (std::expected<void, Problem> truth = read_truth(dir, *meta, scene); !truth) {
    return std::unexpected(std::move(truth.error()));
  }
  if (std::expected<void, Problem> visible = read_visible(dir, scene); !visible) {
    return std::unexpected(std::move(visible.error()));
  }
  if (std::expected<void, Problem> floor = read_floor(dir, *meta, scene); !floor) {
    return std::unexpected(std::move(floor.error()));
  }
  return scene;
}

std::expected<void, Problem> write_stereo_scene(const std::filesystem::path& dir,
                                                const StereoScene& scene) {
  std::vector<std::pair<const char*, std::string>> files{{"left.pgm", pgm_bytes(scene.left)},
                                                         {"right.pgm", pgm_bytes(scene.right)},
                                                         {"meta.txt", meta(scene)}};
  if (scene.truth) {
    files.emplace_back("gt_left.pgm", truth_pgm(*scene.truth));
  }
  if (scene.visible) {
    files.emplace_back("nonocc.pgm", pgm_bytes(*scene.visible));
  }
  if (scene.floor) {
    Image<std::uint8_t> values(scene.left.width, scene.left.height);
    std::ranges::transform(scene.floor->surface.pixels, values.pixels.begin(),
                           [](Surface surface) { return static_cast<std::uint8_t>(surface); });
    files.emplace_back("surfaces.pgm", pgm_bytes(values));
  }
  for (const auto& [name, bytes] : files) {
    if (std::expected<void, Problem> written = write_whole(dir / name, bytes); !written) {
      return written;
    }
  }
  return {};
}

}  // namespace stof::dataset
