#include "host/cli/recording/export.h"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <map>
#include <memory>

#include <nlohmann/json.hpp>

#include "dataset/files/file.h"
#include "host/cli/evaluate/evaluate.h"
#include "host/cli/failure.h"
#include "host/cli/own_keys.h"
#include "host/cli/recording/damage_text.h"
#include "host/cli/recording/reading_progress.h"
#include "host/cli/view/ply.h"
#include "host/client/frame/point_cloud.h"
#include "host/picture/png.h"
#include "host/recording/recording.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

using recording::RecordedFrame;

constexpr std::uint32_t kUnitUm = 250;  // without a calibration

std::uint32_t unit_um(const RecordedFrame& frame) {
  return frame.calibration ? frame.calibration->depth_unit_um : kUnitUm;
}

// "000012": place of the frame in the recording, from 0.
std::string name_of(std::uint64_t index) {
  return printed("%06llu", static_cast<unsigned long long>(index));
}

void write_file(const std::filesystem::path& file, std::string_view bytes) {
  value_or_end(dataset::write_whole(file, bytes));
}

// In the folder that the user names: there a link may lie that leads anywhere.
void make_own_folder(const std::filesystem::path& folder) {
  std::error_code error;
  if (std::filesystem::is_symlink(folder, error)) {
    throw Failure(
        Exit::kBadInput,
        folder.string() + ": is a link, and is not followed: remove it, or give another --to");
  }
  make_folder(folder);
}

// One format.
class Exporter {
 public:
  explicit Exporter(std::filesystem::path to) : to_(std::move(to)) {}
  virtual ~Exporter() = default;
  // False: the frame has nothing for this format.
  virtual bool add(const RecordedFrame& frame, std::uint64_t index) = 0;
  virtual void finish(const recording::Sights& /*sights*/) {}

 protected:
  const std::filesystem::path& to() const { return to_; }

 private:
  std::filesystem::path to_;
};

template <typename T>
dataset::Image<T> image_of(const std::vector<T>& pixels, int width, int height) {
  dataset::Image<T> image;
  image.width = width;
  image.height = height;
  image.pixels = pixels;
  return image;
}

class PngExporter : public Exporter {
 public:
  using Exporter::Exporter;
  bool add(const RecordedFrame& frame, std::uint64_t index) override {
    if (frame.depth.empty()) {
      return false;
    }
    value_or_end(write_png(
        to() / (name_of(index) + ".png"), image_of(frame.depth, frame.width, frame.height),
        {{"Title", "Depth map"},
         {"Description",
          printed("16-bit grey: Z in the rectified left camera, unit %u um, 0 = none",
                  unit_um(frame))},
         {"Source", printed("frame %u", frame.stamp.number)}}));
    return true;
  }
};

class CloudExporter : public Exporter {
 public:
  using Exporter::Exporter;
  bool add(const RecordedFrame& frame, std::uint64_t index) override {
    if (client::point_cloud(frame.view(), points_) != Status::kOk) {
      return false;
    }
    write(to() / name_of(index), points_);
    return true;
  }

 protected:
  virtual void write(std::filesystem::path file, const std::vector<client::Point>& points) = 0;

 private:
  std::vector<client::Point> points_;
};

class PlyExporter : public CloudExporter {
 public:
  using CloudExporter::CloudExporter;

 protected:
  void write(std::filesystem::path file, const std::vector<client::Point>& points) override {
    value_or_end(write_ply(file += ".ply", points));
  }
};

class PcdExporter : public CloudExporter {
 public:
  using CloudExporter::CloudExporter;

 protected:
  // PCD 0.7, binary: what write_ply() writes, in the words of another format.
  void write(std::filesystem::path file, const std::vector<client::Point>& points) override {
    const std::string count = std::to_string(points.size());
    std::string bytes =
        "# .PCD v0.7 - metres in the left camera: x right, y down, z forward; sigma is of z\n"
        "VERSION 0.7\nFIELDS x y z sigma source\nSIZE 4 4 4 4 1\nTYPE F F F F U\n"
        "COUNT 1 1 1 1 1\nWIDTH " +
        count + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count + "\nDATA binary\n";
    for (const client::Point& point : points) {
      for (const float value : {point.x, point.y, point.z, point.z_width / 4}) {
        std::uint32_t word = std::bit_cast<std::uint32_t>(value);
        for (int k = 0; k < 4; ++k, word >>= 8U) {
          bytes.push_back(static_cast<char>(word & 0xFFU));
        }
      }
      bytes.push_back(static_cast<char>(point.source));
    }
    value_or_end(dataset::write_whole(file += ".pcd", bytes));
  }
};

class CsvExporter : public Exporter {
 public:
  using Exporter::Exporter;
  bool add(const RecordedFrame& frame, std::uint64_t index) override {
    const auto covered = std::ranges::count_if(
        frame.depth, [](dsp::QuarterMm depth) { return depth != dsp::kNoDepth; });
    frames_ += printed(
        "%llu,%llu,%u,%u,%lld,%u,%u,%zu,%lld,%s,%s\n", static_cast<unsigned long long>(index),
        static_cast<unsigned long long>(frame.log_time), frame.stamp.number,
        frame.origin.session_id, static_cast<long long>(frame.stamp.exposure_middle_ns),
        frame.packets, frame.missing_packets, frame.depth.size(), static_cast<long long>(covered),
        frame.info ? std::to_string(frame.info->latency_ns).c_str() : "",
        frame.info ? std::to_string(frame.info->settings_revision).c_str() : "");
    return true;
  }
  void finish(const recording::Sights& sights) override {
    write_file(to() / "frames.csv",
               "index,log_time_ns,number,session,exposure_middle_ns,packets,missing_packets,pixels,"
               "pixels_with_depth,latency_ns,settings_revision\n" +
                   frames_);
    std::string health =
        "log_time_ns,uptime_ms,severity,reaction,active,rate_millihertz,latency_us,"
        "longest_latency_us,subscribers,settings_revision,frames_published,timeouts,"
        "deadline_misses,link_drops\n";
    for (const auto& [time, one] : sights.health) {
      health += printed(
          "%llu,%llu,%d,%d,%u,%u,%u,%u,%d,%u,%llu,%llu,%llu,%llu\n",
          static_cast<unsigned long long>(time), static_cast<unsigned long long>(one.uptime_ms),
          static_cast<int>(one.severity), static_cast<int>(one.reaction), one.active,
          one.rate_millihertz, one.latency_us, one.longest_latency_us, one.subscribers,
          one.settings_revision, static_cast<unsigned long long>(one.counters.frames_published),
          static_cast<unsigned long long>(one.counters.timeouts),
          static_cast<unsigned long long>(one.counters.deadline_misses),
          static_cast<unsigned long long>(one.counters.link_drops));
    }
    write_file(to() / "health.csv", health);
    std::string events = "log_time_ns,at_ns,condition,active,severity,reaction,count,value\n";
    for (const auto& [time, one] : sights.events) {
      events += printed("%llu,%lld,%d,%d,%d,%d,%u,%u\n", static_cast<unsigned long long>(time),
                        static_cast<long long>(one.at_ns), one.condition, one.active,
                        static_cast<int>(one.severity), static_cast<int>(one.reaction), one.count,
                        one.value);
    }
    write_file(to() / "events.csv", events);
  }

 private:
  std::string frames_;
};

// The folder of the TUM RGB-D data set: depth/STAMP.png in 1/5000 m, depth.txt; rgb/ and rgb.txt of
// the left picture, where that was recorded.
class TumExporter : public Exporter {
 public:
  explicit TumExporter(std::filesystem::path to) : Exporter(std::move(to)) {
    make_own_folder(this->to() / "depth");
  }
  bool add(const RecordedFrame& frame, std::uint64_t /*index*/) override {
    if (frame.depth.empty()) {
      return false;
    }
    const std::int64_t ns = frame.stamp.exposure_middle_ns;
    const std::string stamp = printed("%.6f", static_cast<double>(ns) * 1e-9);
    std::vector<std::uint16_t> scaled(frame.depth.size());
    std::ranges::transform(frame.depth, scaled.begin(), [&](dsp::QuarterMm depth) {
      const std::uint64_t value = (std::uint64_t{depth} * unit_um(frame) + 100) / 200;
      return static_cast<std::uint16_t>(value > 65535 ? 0 : value);  // beyond 13.107 m: none
    });
    const std::string depth = "depth/" + stamp + ".png";
    value_or_end(write_png(to() / depth, image_of(scaled, frame.width, frame.height),
                           {{"Description", "16-bit grey: Z, value / 5000 = metres, 0 = none"}}));
    depth_ += stamp + " " + depth + "\n";
    if (!frame.left.empty()) {
      make_own_folder(to() / "rgb");
      const std::string left = "rgb/" + stamp + ".png";
      write_file(to() / left, png_bytes(image_of(frame.left, frame.left_width, frame.left_height)));
      left_ += stamp + " " + left + "\n";
    }
    return true;
  }
  void finish(const recording::Sights& /*sights*/) override {
    const char* const head = "# seconds of the sensor's clock, middle of the exposure; file\n";
    write_file(to() / "depth.txt", head + depth_);
    if (!left_.empty()) {
      write_file(to() / "rgb.txt", head + left_);
    }
  }

 private:
  std::string depth_;
  std::string left_;
};

using MakeExporter = std::unique_ptr<Exporter> (*)(const std::filesystem::path&);
template <typename T>
std::unique_ptr<Exporter> make(const std::filesystem::path& to) {
  return std::make_unique<T>(to);
}
const std::map<std::string, MakeExporter>& formats() {
  static const std::map<std::string, MakeExporter> all{{"csv", make<CsvExporter>},
                                                       {"pcd", make<PcdExporter>},
                                                       {"ply", make<PlyExporter>},
                                                       {"png16", make<PngExporter>},
                                                       {"tum", make<TumExporter>}};
  return all;
}

}  // namespace

void export_recording(const ExportOptions& options) {
  auto reader = value_or_fail(recording::FrameReader::open(options.file));
  make_folder(options.to);
  const std::unique_ptr<Exporter> exporter = formats().at(options.as)(options.to);
  std::uint64_t frames = 0;
  std::uint64_t exported = 0;
  {
    ReadingProgress progress(options.file.string());
    while (options.frames == 0 || frames < options.frames) {
      const std::optional<RecordedFrame> frame = reader.next();
      if (!frame) {
        break;
      }
      exported += exporter->add(*frame, frames) ? 1U : 0U;
      ++frames;
      progress.show(reader.position(), reader.size());
    }
  }
  exporter->finish(reader.sights());
  if (options.json) {
    const nlohmann::ordered_json json{{"file", options.file.string()},
                                      {"to", options.to.string()},
                                      {"as", options.as},
                                      {"frames", frames},
                                      {"exported", exported},
                                      {"damaged", reader.damaged()},
                                      {"damaged_bytes", reader.damaged_bytes()}};
    std::puts(json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace).c_str());
  } else {
    std::printf("wrote %llu of %llu frames to %s\n", static_cast<unsigned long long>(exported),
                static_cast<unsigned long long>(frames), options.to.c_str());
  }
  if (exported == 0 || reader.damaged() != 0) {
    std::string what = "no frame in it has what " + options.as +
                       " takes: clouds take depth and calibration, pictures depth";
    if (reader.damaged() != 0) {
      what = damage_text(reader.damaged(), reader.damaged_bytes()) +
             (exported == 0 ? ", and no frame is left that " + options.as + " takes" : "");
    }
    throw Failure(Exit::kFailure, options.file.string() + ": " + what + ": see stof info FILE");
  }
}

void add_export(CLI::App& app, ExportOptions& options) {
  CLI::App& command = *app.add_subcommand("export", "Frames of a recording as other files");
  command.footer(
      "Example: stof export hall.mcap --to hall --as png16\n"
      "png16: NUMBER.png, 16 bit, quarter millimetres. ply, pcd: NUMBER.ply or .pcd, clouds in "
      "metres. csv: frames.csv, health.csv, events.csv. tum: the folder of the TUM RGB-D data "
      "set.\n"
      "Links and pipes that have the name of a file are not written to.\n"
      "Ends with 0 (done), 1 (no frame has what the format takes, records are damaged, or a file "
      "cannot be written) or 2 (bad input).");
  command.add_option("FILE", options.file, "The recording, also a cut one")->required();
  command.add_option("--to", options.to, "Folder, which is made where missing")->required();
  std::vector<std::string> names;
  for (const auto& [name, one] : formats()) {
    names.push_back(name);
  }
  command.add_option("--as", options.as, "Format: csv, pcd, ply, png16 or tum")
      ->required()
      ->check(CLI::IsMember(names));
  command.add_option("--frames", options.frames, "Only so many, the first ones; 0: all")
      ->capture_default_str();
  command.add_flag("--json", options.json, "A JSON object");
  command.callback([&options] { export_recording(options); });
}

}  // namespace stof::host
