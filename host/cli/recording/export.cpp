#include "host/cli/recording/export.h"

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <system_error>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/cli/evaluate/evaluate.h"
#include "host/cli/failure.h"
#include "host/cli/help_text.h"
#include "host/cli/json_output.h"
#include "host/cli/live/reception.h"
#include "host/cli/output.h"
#include "host/cli/progress_line.h"
#include "host/cli/recording/damage_text.h"
#include "host/cli/recording/exporters.h"
#include "host/cli/recording/reading_progress.h"
#include "host/cli/sensor/find_sensor.h"
#include "host/cli/sensor_text.h"
#include "host/client/printable.h"
#include "host/recording/frame_messages.h"
#include "host/recording/recording.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

struct ExportCounts {
  std::uint64_t frames = 0;  // that came, or that the file holds and --frames takes
  std::uint64_t exported = 0;
  std::uint64_t damaged = 0;
  std::uint64_t damaged_bytes = 0;
};

// link: of a sensor.
void print_counts(const ExportOptions& options, const ExportCounts& counts,
                  const LinkTeller* link) {
  if (options.json) {
    nlohmann::ordered_json json{{is_recorded(options.sensor) ? "file" : "sensor", options.sensor},
                                {"to", options.to.string()},
                                {"as", options.as},
                                {"frames", counts.frames},
                                {"exported", counts.exported},
                                {"damaged", counts.damaged},
                                {"damaged_bytes", counts.damaged_bytes}};
    if (link != nullptr) {
      json["silences"] = link->silences();
      json["restarts"] = link->restarts();
    }
    say_json(json);
  } else {
    say(printed("wrote %llu of %llu frames to %s", static_cast<unsigned long long>(counts.exported),
                static_cast<unsigned long long>(counts.frames),
                client::printable(options.to.string()).c_str()));
  }
}

std::string none_text(const ExportOptions& options) {
  return "no frame in it has what " + options.as +
         " takes: clouds take depth and calibration, pictures depth";
}

// A folder and those above it, made where missing; what was made for nothing goes again.
class MadeFolder {
 public:
  explicit MadeFolder(const std::filesystem::path& folder) {
    std::error_code error;
    for (std::filesystem::path at = std::filesystem::absolute(folder, error);
         !at.empty() && !std::filesystem::exists(at, error); at = at.parent_path()) {
      if (at.has_filename()) {  // no slash at its end
        made_.push_back(at);
      }
    }
    make_folder(folder);
  }
  ~MadeFolder() {
    std::error_code in_use;
    for (const std::filesystem::path& one : made_) {
      if (!std::filesystem::remove(one, in_use)) {
        break;
      }
    }
  }
  MadeFolder(const MadeFolder&) = delete;
  MadeFolder& operator=(const MadeFolder&) = delete;

 private:
  std::vector<std::filesystem::path> made_;  // the innermost first
};

// Tells what was exported, also where a file could not be written after others were.
// rescue: as Exporter's.
void told_also_when_it_fails(ExportCounts& counts, const std::function<void()>& work,
                             const std::function<std::uint64_t(std::uint64_t)>& rescue,
                             const std::function<void()>& tell) {
  try {
    work();
  } catch (const Failure&) {
    counts.exported = rescue(counts.exported);
    if (counts.exported != 0) {
      tell();
    }
    throw;
  }
  tell();
}

// What a sensor sends, as it comes.
class LiveExport {
 public:
  explicit LiveExport(const ExportOptions& options)
      : options_(options),
        reception_(options, {.frame = [this](const client::Frame& frame) { take(frame); },
                             .event =
                                 [this](const wire::EventReport& event) {
                                   sights_.events.emplace_back(clock_.now(), event);
                                 },
                             .line =
                                 [this](const std::string& line) {
                                   if (!options_.json) {
                                     progress_.clear();
                                     say(line);
                                   }
                                 },
                             .change =
                                 [this](const LinkTeller::Change& change) {
                                   if (options_.json) {
                                     say_aside(change.text);
                                   }
                                 }}),
        progress_(options.sensor, options.json) {}

  void run() {
    reception_.run([this] {
      const std::optional<wire::HealthReport>& health = reception_.receiver().health();
      if (health && health->uptime_ms != uptime_ms_) {
        uptime_ms_ = health->uptime_ms;
        sights_.health.emplace_back(clock_.now(), *health);
      }
      return options_.frames != 0 && counts_.frames >= options_.frames;
    });
    progress_.clear();
    if (reception_.frames() == 0) {
      reception_.fail();
    }
    if (exporter_) {
      exporter_->finish(sights_);
    }
  }
  ExportCounts& counts() { return counts_; }
  void tell() const { print_counts(options_, counts_, &reception_.link()); }
  std::uint64_t rescue(std::uint64_t exported) {
    return exporter_ ? exporter_->rescue(exported) : exported;
  }

  // After what came was told.
  void judge() {
    if (reception_.silent()) {
      reception_.fail();
    }
    if (counts_.exported == 0) {
      throw Failure(Exit::kFailure, reception_.place() + ": " + none_text(options_));
    }
  }

 private:
  // The calibration comes once a second, and clouds take one: what comes before it is left out, for
  // a second or so.
  void take(const client::Frame& frame) {
    constexpr std::chrono::milliseconds kWait{1500};
    const client::Time now = client::Time::clock::now();
    began_ = began_.value_or(now);
    if (!frame.calibration && now - *began_ < kWait) {
      return;
    }
    if (!exporter_) {
      exporter_ = make_exporter(options_.as, options_.to);
    }
    if (options_.frames == 0 || counts_.frames < options_.frames) {
      const ExportStamp stamp{.index = counts_.frames, .log_time = clock_.at(frame.last_packet)};
      ++counts_.frames;
      counts_.exported += exporter_->add(frame, stamp) ? 1U : 0U;
      progress_.show(counts_.frames, options_.frames);
    }
  }

  const ExportOptions& options_;
  recording::LogClock clock_;
  recording::Sights sights_;
  ExportCounts counts_;
  std::optional<client::Time> began_;  // the first frame
  std::optional<std::uint64_t> uptime_ms_;
  std::unique_ptr<Exporter> exporter_;  // none before the first frame that counts
  Reception reception_;
  ExportProgress progress_;
};

void export_sensor(const ExportOptions& options) {
  need_folder(options.to, "--to");
  const MadeFolder folder(options.to);
  LiveExport session(options);
  told_also_when_it_fails(
      session.counts(), [&] { session.run(); },
      [&](std::uint64_t exported) { return session.rescue(exported); }, [&] { session.tell(); });
  session.judge();
}

void note_damage(const recording::FrameReader& reader, ExportCounts& counts) {
  counts.damaged = reader.damaged();
  counts.damaged_bytes = reader.damaged_bytes();
}

// After a file could not be written: of how many frames some were.
void count_rest(const ExportOptions& options, recording::FrameReader& reader,
                ExportCounts& counts) {
  ReadingProgress progress(options.sensor, options.json);
  while ((options.frames == 0 || counts.frames < options.frames) && reader.next()) {
    ++counts.frames;
    progress.show(reader.position(), reader.size());
  }
  note_damage(reader, counts);
}

void export_recording(const ExportOptions& options) {
  const std::string& file = options.sensor;
  auto reader = value_or_fail(recording::FrameReader::open(file));
  const MadeFolder folder(options.to);
  const std::unique_ptr<Exporter> exporter = make_exporter(options.as, options.to);
  ExportCounts counts;
  const auto work = [&] {
    {
      ExportProgress progress(file, options.json);
      while (options.frames == 0 || counts.frames < options.frames) {
        const std::optional<recording::RecordedFrame> frame = reader.next();
        if (!frame) {
          break;
        }
        const ExportStamp stamp{.index = counts.frames, .log_time = frame->log_time};
        ++counts.frames;
        counts.exported += exporter->add(frame->view(), stamp) ? 1U : 0U;
        progress.show(counts.frames, reader.position(), reader.size());
      }
    }
    exporter->finish(reader.sights());
    note_damage(reader, counts);
  };
  const auto rescue = [&](std::uint64_t exported) {
    const std::uint64_t kept = exporter->rescue(exported);
    if (kept != 0) {
      count_rest(options, reader, counts);
    }
    return kept;
  };
  told_also_when_it_fails(counts, work, rescue, [&] { print_counts(options, counts, nullptr); });
  if (reader.lenses().contradict()) {
    throw Failure(Exit::kFailure, file + ": " + lenses_contradict_text());
  }
  if (counts.exported == 0 || counts.damaged != 0) {
    std::string what = none_text(options);
    if (counts.damaged != 0) {
      what = damage_text(counts.damaged, counts.damaged_bytes) +
             (counts.exported == 0 ? ", and no frame is left that " + options.as + " takes" : "");
    }
    throw Failure(Exit::kFailure, file + ": " + what + ": see stof info FILE");
  }
}

}  // namespace

void add_export(CLI::App& app, ExportOptions& options) {
  CLI::App& command =
      *app.add_subcommand("export", "Frames of a sensor or a recording as other files");
  show_example(
      command, "stof export hall.mcap --to hall --as png16",
      "png16: NUMBER.png, 16 bit, quarter millimetres. ply, pcd: NUMBER.ply or .pcd, clouds in "
      "metres. csv: frames.csv, health.csv, events.csv. tum: the folder of the TUM RGB-D data "
      "set.\n"
      "Links and pipes that have the name of a file are not written to.\n"
      "Ends with 0 (done), 1 (no frame has what the format takes, none came, the sensor fell "
      "silent, records are damaged, lenses contradict each other, or a file cannot be written) or "
      "2 (bad input).");
  command.add_option("SENSOR", options.sensor, std::string(kSensorOrFile) + ", also a cut one")
      ->check(not_empty())
      ->required();
  command.add_option("--to", options.to, "Folder, which is made where missing")->required();
  command.add_option("--as", options.as, "Format: csv, pcd, ply, png16 or tum")
      ->required()
      ->check(CLI::IsMember(export_formats()));
  command
      .add_option("--frames", options.frames,
                  "Only so many, the first ones; 0: all, of a sensor until interrupted")
      ->capture_default_str();
  add_json_flag(command, options.json);
  add_subscription_flags(command, options);
  command.callback([&options] {
    is_recorded(options.sensor) ? export_recording(options) : export_sensor(options);
  });
}

}  // namespace stof::host
