#include "host/cli/sensor/stats.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "host/cli/failure.h"
#include "host/cli/help_text.h"
#include "host/cli/json_output.h"
#include "host/cli/live/reception.h"
#include "host/cli/output.h"
#include "host/cli/recording/damage_text.h"
#include "host/cli/recording/file_state.h"
#include "host/cli/recording/reading_progress.h"
#include "host/cli/recording/recorded_link.h"
#include "host/cli/sensor/find_sensor.h"
#include "host/cli/view/status_line.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

double arrival_s(const client::Frame& frame) {
  return std::chrono::duration<double>(frame.last_packet.time_since_epoch()).count();
}

// Between two frames of one session.
std::uint64_t frames_between(std::uint32_t before, std::uint32_t after) {
  const std::uint32_t step = after - before;  // wraps as the numbers do
  return step > 0 && step < (1U << 31) ? step - 1 : 0;
}

// ", 2 records in it are damaged, ..."; empty where nothing is.
std::string damage_behind(const StreamStats& stats) {
  return stats.damage && stats.damage->records != 0
             ? ", " + damage_text(stats.damage->records, stats.damage->bytes)
             : "";
}

void print(const StatsOptions& options, const StreamStats& stats) {
  if (options.json) {
    say_json(stats_json(stats));
  } else {
    say_text(stats_text(stats));
  }
}

StreamStats receive_stats(const StatsOptions& options) {
  StreamStats stats;
  Reception reception(
      options,
      {.frame = [&](const client::Frame& frame) { stats.figures.take(frame, arrival_s(frame)); },
       .line =
           [&](const std::string& line) {
             if (!options.json) {
               say(line);
             }
           }});
  std::optional<client::Time> began;
  reception.run([&] {
    const client::Time now = client::Time::clock::now();
    if (!began && reception.frames() != 0) {
      began = now;
    }
    return began && now - *began >= std::chrono::duration<double>(options.seconds);
  });
  stats.source = reception.place();
  stats.device = reception.device();
  stats.counts = reception.receiver().statistics();
  stats.silences = reception.link().silences();
  stats.restarts = reception.link().restarts();
  if (reception.frames() == 0) {
    reception.fail();
  }
  print(options, stats);
  if (const std::string advice = reception.receiver().advice(); !advice.empty() && !options.json) {
    say(advice);
  }
  if (reception.silent()) {
    reception.fail();
  }
  return stats;
}

void stats(const StatsOptions& options) {
  if (!is_recorded(options.sensor)) {
    receive_stats(options);
    return;
  }
  const StreamStats stats = stats_of_file(options.sensor, options.json);
  print(options, stats);
  if (stats.damage->records != 0) {
    throw Failure(Exit::kFailure, options.sensor + ": " +
                                      damage_text(stats.damage->records, stats.damage->bytes) +
                                      ": stof recover FILE OUT writes what is sound");
  }
}

}  // namespace

StreamStats stats_of_file(const std::string& file, bool json) {
  auto reader = value_or_fail(recording::FrameReader::open(file));
  StreamStats stats{.source = file};
  std::optional<wire::Origin> origin;
  std::uint32_t number = 0;
  std::uint32_t file_number = 1;
  RecordedLink link;
  ReadingProgress progress(file, json);
  while (const std::optional<recording::RecordedFrame> frame = reader.next()) {
    if (frame->file != std::exchange(file_number, frame->file)) {
      stats.figures.begin_anew();
      stats.silences += std::exchange(link, RecordedLink()).silences();
      origin.reset();
    }
    stats.figures.take(frame->view(), static_cast<double>(frame->log_time) / 1e9);
    ++(frame->missing_packets == 0 ? stats.counts.frames_complete : stats.counts.frames_incomplete);
    stats.counts.packets_missing += frame->missing_packets;
    stats.counts.packets_ok += frame->packets - std::min(frame->packets, frame->missing_packets);
    const bool starts = origin && origin->session_id != frame->origin.session_id;
    link.frame(frame->log_time,
               std::chrono::nanoseconds(frame->calibration ? frame->calibration->period_ns : 0),
               starts);
    if (origin && !starts) {
      stats.counts.frames_lost += frames_between(number, frame->stamp.number);
    } else {
      stats.restarts += starts ? 1U : 0U;
      ++stats.counts.sessions;
    }
    origin = frame->origin;
    number = frame->stamp.number;
    progress.show(reader.position(), reader.size());
  }
  stats.silences += link.silences();
  stats.damage =
      Damage{.records = reader.damaged(), .bytes = reader.damaged_bytes(), .state = reader.state()};
  if (stats.figures.frames() == 0) {
    throw Failure(Exit::kFailure, file + ": holds no frame" + damage_behind(stats) +
                                      ": stof info says what it holds");
  }
  stats.device = origin->device_id;
  return stats;
}

std::string stats_text(const StreamStats& stats) {
  const StreamFigures& figures = stats.figures;
  std::string text = stats.source + ", sensor " +
                     (stats.device ? std::to_string(*stats.device) : "unknown") + "\n";
  const auto line = [&text](const char* name, const std::string& what) {
    text += printed("  %-18s", name) + what + "\n";
  };
  line("frames", printed("%llu in %.2f s", static_cast<unsigned long long>(figures.frames()),
                         figures.seconds()) +
                     (figures.rate_hz() ? printed(", %.2f a second", *figures.rate_hz()) : ""));
  line("loss", summary_line(stats.counts));
  if (stats.damage && stats.damage->records != 0) {
    line("file", damage_text(stats.damage->records, stats.damage->bytes) +
                     ": what lies in them counts as lost");
  } else if (stats.damage && !is_whole(stats.damage->state)) {
    line("file", file_state_text(stats.damage->state, 0));
  }
  if (stats.damage && stats.damage->state.files > 1) {
    line("files", files_text(stats.damage->state));
  }
  if (figures.arrivals_back() > 0) {
    line("order",
         printed("%llu %s a frame lies behind a later one: nothing is measured between them",
                 static_cast<unsigned long long>(figures.arrivals_back()),
                 figures.arrivals_back() == 1 ? "time" : "times"));
  }
  line("interval, ms", spread_text(figures.interval_ms()));
  line("latency, ms", spread_text(figures.latency_ms()) +
                          (figures.latency_ms() ? "" : " (only where one clock stamps both ends)"));
  line("in the sensor, ms", spread_text(figures.sensor_latency_ms()));
  line("computing, ms", spread_text(figures.compute_ms()));
  if (figures.coverage()) {
    line("coverage", printed("%.1f %% of the pixels have a depth", 100 * *figures.coverage()));
  }
  line("link", printed("%u %s silent, %u %s of the sensor", stats.silences,
                       stats.silences == 1 ? "time" : "times", stats.restarts,
                       stats.restarts == 1 ? "restart" : "restarts"));
  return text;
}

nlohmann::ordered_json stats_json(const StreamStats& stats) {
  const StreamFigures& figures = stats.figures;
  using Json = nlohmann::ordered_json;
  const auto number = [](const std::optional<double>& value) {
    return value ? Json(*value) : Json(nullptr);
  };
  const Json counts = statistics_json(stats.counts);
  return {{"source", stats.source},
          {"device_id", stats.device ? Json(*stats.device) : Json(nullptr)},
          {"seconds", figures.seconds()},
          {"received_frames", figures.frames()},
          {"rate_hz", number(figures.rate_hz())},
          {"interval_ms", spread_json(figures.interval_ms())},
          {"latency_ms", spread_json(figures.latency_ms())},
          {"sensor_latency_ms", spread_json(figures.sensor_latency_ms())},
          {"compute_ms", spread_json(figures.compute_ms())},
          {"coverage", number(figures.coverage())},
          {"frames", counts["frames"]},
          {"packets", counts["packets"]},
          {"out_of_order", figures.arrivals_back()},
          {"silences", stats.silences},
          {"restarts", stats.restarts},
          {"damaged", stats.damage ? Json(stats.damage->records) : Json(nullptr)},
          {"damaged_bytes", stats.damage ? Json(stats.damage->bytes) : Json(nullptr)},
          {"state", stats.damage ? Json(file_state_text(stats.damage->state, stats.damage->records))
                                 : Json(nullptr)},
          {"files", stats.damage ? Json(stats.damage->state.files) : Json(nullptr)}};
}

void add_stats(CLI::App& app, StatsOptions& options) {
  CLI::App& command = *app.add_subcommand(
      "stats", "Rate, jitter, latency and loss by cause, of a sensor or a recording");
  show_example(command, "stof stats 192.168.1.20 --seconds 10",
               "Ends with 0 (measured), 1 (no frame came, the sensor fell silent, records of the "
               "recording are damaged, or the output cannot be written) or 2 (bad input).");
  add_reading_flags(command, options, options.json);
  command.add_option("--seconds", options.seconds, "How long, from the first frame")
      ->check(CLI::Range(0.1, 86400.0))
      ->capture_default_str();
  command.callback([&options, &command] {
    judge_reading_flags(command, options.sensor);
    stats(options);
  });
}

}  // namespace stof::host
