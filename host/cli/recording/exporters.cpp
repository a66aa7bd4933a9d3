#include "host/cli/recording/exporters.h"

#include <algorithm>
#include <bit>
#include <map>
#include <system_error>
#include <utility>
#include <vector>

#include "dataset/files/file.h"
#include "host/cli/evaluate/evaluate.h"
#include "host/cli/failure.h"
#include "host/cli/image_copy.h"
#include "host/cli/own_keys.h"
#include "host/cli/view/ply.h"
#include "host/client/frame/point_cloud.h"
#include "host/picture/png.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr std::uint32_t kUnitUm = 250;  // without a calibration

std::uint32_t unit_um(const client::Frame& frame) {
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

class PngExporter : public Exporter {
 public:
  using Exporter::Exporter;
  bool add(const client::Frame& frame, const ExportStamp& stamp) override {
    if (frame.depth.empty()) {
      return false;
    }
    value_or_end(
        write_png(to() / (name_of(stamp.index) + ".png"), copy_of(frame.depth),
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
  bool add(const client::Frame& frame, const ExportStamp& stamp) override {
    if (client::point_cloud(frame, points_) != Status::kOk) {
      return false;
    }
    write(to() / name_of(stamp.index), points_);
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
  bool add(const client::Frame& frame, const ExportStamp& stamp) override {
    const dataset::Image<dsp::QuarterMm> depth = copy_of(frame.depth);
    const auto covered = std::ranges::count_if(
        depth.pixels, [](dsp::QuarterMm one) { return one != dsp::kNoDepth; });
    frames_ += printed(
        "%llu,%llu,%u,%u,%lld,%u,%u,%zu,%lld,%s,%s\n", static_cast<unsigned long long>(stamp.index),
        static_cast<unsigned long long>(stamp.log_time), frame.stamp.number,
        frame.origin.session_id, static_cast<long long>(frame.stamp.exposure_middle_ns),
        frame.packets, frame.missing_packets, depth.pixels.size(), static_cast<long long>(covered),
        frame.info ? std::to_string(frame.info->latency_ns).c_str() : "",
        frame.info ? std::to_string(frame.info->settings_revision).c_str() : "");
    return true;
  }
  // Its files hold all frames: without them there is none.
  std::uint64_t rescue(std::uint64_t /*exported*/) override { return 0; }
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
  bool add(const client::Frame& frame, const ExportStamp& /*stamp*/) override {
    if (frame.depth.empty()) {
      return false;
    }
    const std::int64_t ns = frame.stamp.exposure_middle_ns;
    const std::string stamp = printed("%.6f", static_cast<double>(ns) * 1e-9);
    dataset::Image<std::uint16_t> scaled = copy_of(frame.depth);
    std::ranges::transform(scaled.pixels, scaled.pixels.begin(), [&](dsp::QuarterMm depth) {
      const std::uint64_t value = (std::uint64_t{depth} * unit_um(frame) + 100) / 200;
      return static_cast<std::uint16_t>(value > 65535 ? 0 : value);  // beyond 13.107 m: none
    });
    const std::string depth = "depth/" + stamp + ".png";
    value_or_end(write_png(to() / depth, scaled,
                           {{"Description", "16-bit grey: Z, value / 5000 = metres, 0 = none"}}));
    pictures_.push_back({.stamp = stamp});
    if (!frame.left.empty()) {
      make_own_folder(to() / "rgb");
      write_file(to() / left_of(pictures_.back()), png_bytes(copy_of(frame.left)));
      pictures_.back().has_left = true;
    }
    return true;
  }
  void finish(const recording::Sights& /*sights*/) override {
    const char* const head = "# seconds of the sensor's clock, middle of the exposure; file\n";
    std::string depth = head;
    std::string left;
    for (const Picture& one : pictures_) {
      depth += one.stamp + " " + depth_of(one) + "\n";
      left += one.has_left ? one.stamp + " " + left_of(one) + "\n" : "";
    }
    write_file(to() / "depth.txt", depth);
    if (!left.empty()) {
      write_file(to() / "rgb.txt", head + left);
    }
  }
  // The lists, for which up to eight of the last pictures give way.
  std::uint64_t rescue(std::uint64_t exported) override {
    constexpr int kMostGiven = 8;
    std::error_code none;
    for (int given = 0; !pictures_.empty() && given <= kMostGiven; ++given) {
      try {
        finish({});
        return std::min<std::uint64_t>(exported, pictures_.size());
      } catch (const Failure&) {
        std::filesystem::remove(to() / depth_of(pictures_.back()), none);
        std::filesystem::remove(to() / left_of(pictures_.back()), none);
        pictures_.pop_back();
      }
    }
    for (const char* const folder : {"depth", "rgb"}) {  // where nothing lies in it
      std::filesystem::remove(to() / folder, none);
    }
    return std::min<std::uint64_t>(exported, pictures_.size());
  }

 private:
  struct Picture {
    std::string stamp{};
    bool has_left = false;
  };
  static std::string depth_of(const Picture& one) { return "depth/" + one.stamp + ".png"; }
  static std::string left_of(const Picture& one) { return "rgb/" + one.stamp + ".png"; }

  std::vector<Picture> pictures_;
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

std::vector<std::string> export_formats() {
  std::vector<std::string> names;
  for (const auto& [name, one] : formats()) {
    names.push_back(name);
  }
  return names;
}

std::unique_ptr<Exporter> make_exporter(const std::string& format,
                                        const std::filesystem::path& to) {
  return formats().at(format)(to);
}

}  // namespace stof::host
