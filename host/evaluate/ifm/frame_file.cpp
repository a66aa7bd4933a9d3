#include "host/evaluate/ifm/frame_file.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <nlohmann/json.hpp>

#include "dataset/files/file.h"
#include "dataset/files/json_file.h"

namespace stof::host {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr unsigned kInvalid = 1;  // bit of the confidence
constexpr unsigned kExposureBit = 4;
constexpr unsigned kExposureMask = 3;
constexpr std::size_t kMetadata = 48;  // of a chunk's header: JSON from here on
constexpr std::size_t kMaxBufferBytes = std::size_t{1} << 26;

dataset::Loaded<FrameInfo> read_info(const fs::path& file) {
  const dataset::Loaded<json> read = dataset::read_object(file);
  if (!read) {
    return std::unexpected(read.error());
  }
  const json& root = *read;
  const json lens = root.value("intrinsics", json());
  const json k = lens.is_object() ? lens.value("k", json()) : json();
  const auto number = [](const json& of, const char* key) {
    const json value = of.value(key, json());
    return value.is_number() ? value.get<double>() : std::nan("");
  };
  if (!k.is_array() || k.size() < 5 ||
      !std::ranges::all_of(k, [](const json& value) { return value.is_number(); })) {
    return dataset::refuse(file, "has no \"intrinsics\" with fx, fy, cx, cy and k of five numbers",
                           "correct the file");
  }
  FrameInfo info{.lens = {.width = static_cast<int>(number(root, "width")),
                          .height = static_cast<int>(number(root, "height")),
                          .fx = number(lens, "fx"),
                          .fy = number(lens, "fy"),
                          .cx = number(lens, "cx"),
                          .cy = number(lens, "cy"),
                          .k1 = k[0],
                          .k2 = k[1],
                          .k3 = k[4],
                          .p1 = k[2],
                          .p2 = k[3]},
                 .unit_m = number(root, "distance_unit_m")};
  const dsp::Pinhole& l = info.lens;
  if (!(l.fx > 0 && l.fy > 0 && std::isfinite(l.cx) && std::isfinite(l.cy) && info.unit_m > 0)) {
    return dataset::refuse(file,
                           "has an intrinsic or a distance_unit_m that cannot be computed with",
                           "correct the file");
  }
  return info;
}

template <typename T>
std::expected<void, dataset::Problem> read_beside(const fs::path& file, const dsp::Pinhole& lens,
                                                  std::optional<dataset::Image<T>>& image) {
  std::error_code error;
  if (!fs::exists(file, error)) {
    return {};
  }
  dataset::Loaded<dataset::Image<T>> found;
  if constexpr (sizeof(T) == 1) {
    found = dataset::read_pgm8(file);
  } else {
    found = dataset::read_pgm16(file);
  }
  if (!found) {
    return std::unexpected(std::move(found.error()));
  }
  if (found->width != lens.width || found->height != lens.height) {
    return dataset::refuse(file, "is not of the size that info.json says",
                           "give the files of one frame");
  }
  image = std::move(*found);
  return {};
}

}  // namespace

bool CameraFrame::valid(std::size_t i) const {
  return radial.pixels[i] != 0 && (!confidence || (confidence->pixels[i] & kInvalid) == 0);
}

const PcicChunk* CameraFrame::chunk(std::uint32_t type) const {
  const auto found = std::ranges::find(chunks, type, &PcicChunk::type);
  return found == chunks.end() ? nullptr : &*found;
}

std::uint32_t CameraFrame::word(const PcicChunk& chunk, std::size_t n, std::size_t bytes) const {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < bytes; ++i) {
    const char byte = buffer[chunk.at + chunk.header_size + bytes * n + i];
    value |= std::uint32_t{static_cast<std::uint8_t>(byte)} << (8 * i);
  }
  return value;
}

std::vector<double> CameraFrame::amplitude_factors() const {
  const PcicChunk* const amplitudes = chunk(kPcicAmplitude);
  if (amplitudes == nullptr || !confidence) {
    return {};
  }
  std::string text = buffer.substr(amplitudes->at + kMetadata, amplitudes->header_size - kMetadata);
  text.resize(std::min(text.find('\0'), text.size()));
  const json root = json::parse(text, nullptr, false);
  const json named = root.is_object() ? root.value("AmpNormalizationFactors", json()) : json();
  if (!named.is_array() || named.empty() ||
      !std::ranges::all_of(named, [](const json& f) { return f.is_number() && f > 0; })) {
    return {};
  }
  std::vector<double> sorted = named.get<std::vector<double>>();
  std::ranges::sort(sorted, std::greater());  // the shortest exposure is multiplied by most
  std::vector<double> factors;
  for (const std::uint8_t bits : confidence->pixels) {
    const std::size_t exposure = unsigned{bits} >> kExposureBit & kExposureMask;
    factors.push_back(sorted[std::clamp<std::size_t>(exposure, 1, sorted.size()) - 1]);
  }
  return factors;
}

dataset::Loaded<CameraFrame> read_camera_frame(const fs::path& folder) {
  dataset::Loaded<FrameInfo> info = read_info(folder / "info.json");
  if (!info) {
    return std::unexpected(std::move(info.error()));
  }
  CameraFrame frame{.info = *info,
                    .radial = {},
                    .amplitude = std::nullopt,
                    .noise = std::nullopt,
                    .confidence = std::nullopt,
                    .buffer = {},
                    .chunks = {}};
  std::optional<dataset::Image<std::uint16_t>> radial;
  std::expected<void, dataset::Problem> done =
      read_beside(folder / "radial_distance.pgm", info->lens, radial);
  if (done) {
    done = read_beside(folder / "amplitude.pgm", info->lens, frame.amplitude);
  }
  if (done) {
    done = read_beside(folder / "distance_noise.pgm", info->lens, frame.noise);
  }
  if (done) {
    done = read_beside(folder / "confidence.pgm", info->lens, frame.confidence);
  }
  if (!done) {
    return std::unexpected(std::move(done.error()));
  }
  if (!radial) {
    return dataset::refuse(folder / "radial_distance.pgm", "is absent", "give a whole frame");
  }
  frame.radial = std::move(*radial);
  const fs::path file = folder / "O3RBuffer.data";
  std::error_code error;
  if (fs::exists(file, error)) {
    dataset::Loaded<std::string> buffer = dataset::read_whole(file, kMaxBufferBytes);
    if (!buffer) {
      return std::unexpected(std::move(buffer.error()));
    }
    frame.buffer = std::move(*buffer);
    dataset::Loaded<std::vector<PcicChunk>> chunks = pcic_chunks(frame.buffer, file);
    if (!chunks) {
      return std::unexpected(std::move(chunks.error()));
    }
    frame.chunks = std::move(*chunks);
  }
  return frame;
}

}  // namespace stof::host
