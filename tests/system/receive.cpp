#include <chrono>
#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include <stof/stof.hpp>

// stof_system_receive --listen PORT | --sensor HOST:PORT: prints a line of JSON for each frame and
// each event until it is killed. A frame's hash is of all pixels of depth, width and source with
// cause.
namespace {

constexpr int kBadInput = 2;

// FNV-1a, 64 bits, by bytes in raster order.
class Hash {
 public:
  template <typename T>
  void take(const stof::Image<T>& image) {
    take_number(static_cast<std::uint32_t>(image.empty() ? 0 : image.width()));
    for (int y = 0; !image.empty() && y < image.height(); ++y) {
      take_bytes(image.row(y), static_cast<std::size_t>(image.width()) * sizeof(T));
    }
  }
  std::uint64_t value() const { return value_; }

 private:
  void take_number(std::uint32_t number) { take_bytes(&number, sizeof number); }
  void take_bytes(const void* data, std::size_t size) {
    const auto* const bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) {
      value_ = (value_ ^ bytes[i]) * 0x100000001b3U;
    }
  }

  std::uint64_t value_ = 0xcbf29ce484222325U;
};

// CLOCK_MONOTONIC of this machine.
std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

void print(const stof::Frame& frame) {
  const stof_frame& c = frame.c();
  Hash hash;
  hash.take(frame.depth());
  hash.take(frame.interval_width());
  hash.take(frame.source());
  hash.take(frame.cause());
  std::printf("{\"frame\": %" PRIu32 ", \"session\": %" PRIu32 ", \"freshness\": %" PRIu32
              ", \"at_ns\": %" PRId64 ", \"middle_ns\": %" PRId64
              ", \"missing\": %u, \"health\": %u, \"hash\": \"%016" PRIx64 "\", \"depth\": %d",
              c.number, c.session_id, c.freshness, c.first_packet_ns, c.exposure_middle_ns,
              unsigned{c.missing_packets}, unsigned{c.health}, hash.value(),
              frame.depth().empty() ? 0 : 1);
  if (const auto info = frame.info()) {
    std::printf(", \"begin_ns\": %" PRId64 ", \"end_ns\": %" PRId64 ", \"latency_ns\": %" PRId64
                ", \"compute_ns\": %" PRId64 ", \"pmd_age_ns\": %" PRId64
                ", \"pmd\": %d, \"sensors\": %d, \"sources\": [%u, %u, %u, %u, %u, %u]",
                info->exposure_begin_ns, info->exposure_end_ns, info->latency_ns, info->compute_ns,
                info->pmd_age_ns, int{info->pmd_present}, int{info->sensors},
                info->pixels_by_source[0], info->pixels_by_source[1], info->pixels_by_source[2],
                info->pixels_by_source[3], info->pixels_by_source[4], info->pixels_by_source[5]);
  }
  std::printf("}\n");
}

void print(const stof::Event& event) {
  std::printf("{\"event\": \"%s\", \"active\": %u, \"severity\": \"%s\", \"at_ns\": %" PRId64
              ", \"sensor_ns\": %" PRId64 "}\n",
              stof_condition_name(event.condition), unsigned{event.active},
              stof_severity_name(event.severity), now_ns(), event.at_ns);
}

int receive(stof::Sensor& sensor) {
  while (true) {
    stof_status status = STOF_OK;
    if (const auto frame = sensor.next(std::chrono::milliseconds(200), &status)) {
      print(*frame);
    } else if (status != STOF_TIMEOUT) {
      std::fprintf(stderr, "stof_system_receive: %s\n", stof::text(status).c_str());
      return 1;
    }
    while (const auto event = sensor.next_event()) {
      print(*event);
    }
    if (std::fflush(stdout) != 0) {
      return 0;  // nobody reads
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  stof_options options = STOF_INIT(stof_options);
  const std::string how = argc == 3 ? argv[1] : "";
  if (how == "--sensor") {
    options.sensor = argv[2];
  } else if (how == "--listen") {
    options.bind = "127.0.0.1";
    options.port = static_cast<std::uint16_t>(std::atoi(argv[2]));
  } else {
    std::fprintf(stderr, "stof_system_receive: takes --listen PORT or --sensor HOST:PORT\n");
    return kBadInput;
  }
  std::string why;
  auto sensor = stof::Sensor::open(options, &why);
  if (!sensor) {
    std::fprintf(stderr, "stof_system_receive: %s\n", why.c_str());
    return 1;
  }
  std::fprintf(stderr, "open\n");
  return receive(*sensor);
}
