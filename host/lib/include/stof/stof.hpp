// libstof for C++17 and later: stof/stof.h with owners and views instead of pointers. Header only,
// throws nothing of its own. Threads and lifetimes are those of stof/stof.h: what a Frame shows is
// valid until the next Sensor::next() or the end of its Sensor, unless a KeptFrame keeps it.
#ifndef STOF_STOF_HPP
#define STOF_STOF_HPP

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <stof/stof.h>

namespace stof {

using Options = stof_options;  // begin with STOF_INIT(stof_options)
using Point = stof_point;
using Calibration = stof_calibration;
using Info = stof_info;
using Health = stof_health;
using Event = stof_event;
using Link = stof_link;
using LinkEvent = stof_link_event;
using Clock = stof_clock;
using PixelPoint = stof_pixel_point;
using Setting = stof_setting;
using Statistics = stof_statistics;
using Found = stof_found;
using Recorded = stof_recorded;

inline std::string text(stof_status status) { return stof_status_text(status); }

// Pixels of one stream; T as stof_frame says.
template <typename T>
class Image {
 public:
  explicit Image(const stof_plane& plane) noexcept : plane_(&plane) {}

  bool empty() const noexcept { return plane_->data == nullptr; }
  int width() const noexcept { return static_cast<int>(plane_->width); }
  int height() const noexcept { return static_cast<int>(plane_->height); }
  std::size_t missing() const noexcept { return plane_->missing; }
  // width() pixels; 0 <= y < height(). All planes are aligned for their pixels.
  const T* row(int y) const noexcept {
    return reinterpret_cast<const T*>(static_cast<const unsigned char*>(plane_->data) +
                                      static_cast<std::size_t>(y) * plane_->stride);
  }
  T at(int x, int y) const noexcept { return row(y)[x]; }
  bool arrived(int x, int y) const noexcept {
    return plane_->marks == nullptr
               ? plane_->missing == 0
               : (plane_->marks[static_cast<std::size_t>(y) * plane_->marks_stride +
                                static_cast<std::size_t>(x)] &
                  plane_->mark) != 0;
  }

 private:
  const stof_plane* plane_;
};

class Frame {
 public:
  Frame() noexcept { c_.struct_size = sizeof c_; }
  explicit Frame(const stof_frame& frame) noexcept : c_(frame) {}

  std::uint32_t number() const noexcept { return c_.number; }
  bool complete() const noexcept { return c_.missing_packets == 0; }
  // Middle of the exposure, by the sensor's clock.
  std::chrono::nanoseconds exposure_middle() const noexcept {
    return std::chrono::nanoseconds(c_.exposure_middle_ns);
  }
  // The same by this machine's clock, as Sensor::clock() maps it; none: unknown.
  std::optional<std::chrono::steady_clock::time_point> exposure_here() const noexcept {
    return c_.exposure_here_ns == 0
               ? std::nullopt
               : std::optional(std::chrono::steady_clock::time_point(
                     std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                         std::chrono::nanoseconds(c_.exposure_here_ns))));
  }

  Image<std::uint16_t> depth() const noexcept { return Image<std::uint16_t>(c_.depth); }
  Image<std::uint16_t> interval_width() const noexcept {
    return Image<std::uint16_t>(c_.interval_width);
  }
  Image<std::uint8_t> source() const noexcept { return Image<std::uint8_t>(c_.source); }
  Image<std::uint8_t> cause() const noexcept { return Image<std::uint8_t>(c_.cause); }
  Image<std::int16_t> disparity() const noexcept { return Image<std::int16_t>(c_.disparity); }
  Image<std::uint16_t> pmd(int sample) const noexcept {
    return Image<std::uint16_t>(c_.pmd[sample]);
  }
  Image<std::uint8_t> left() const noexcept { return Image<std::uint8_t>(c_.left); }
  Image<std::uint8_t> right() const noexcept { return Image<std::uint8_t>(c_.right); }
  Image<stof_cloud_point> cloud() const noexcept { return Image<stof_cloud_point>(c_.cloud); }

  // On how many frames in a row this depth stands, itself included; 0: nobody says.
  std::uint32_t steady_frames() const noexcept { return c_.steady_frames; }
  // Of the calibration that it was made with; 0: unknown.
  std::uint32_t calibration_fingerprint() const noexcept { return c_.calibration_fingerprint; }
  std::optional<Info> info() const {
    return c_.has_info != 0 ? std::optional<Info>(c_.info) : std::nullopt;
  }
  std::optional<Calibration> calibration() const {
    return c_.has_calibration != 0 ? std::optional<Calibration>(c_.calibration) : std::nullopt;
  }

  // Of the settings it was made with; 0: unknown.
  std::uint32_t settings_fingerprint() const noexcept { return c_.settings_fingerprint; }

  // Into `points`, which keeps its memory. STOF_NOT_YET: no calibration yet.
  stof_status points(std::vector<Point>& points) const { return fill_points(stof_points, points); }
  // With the pixel of each, and its grey value where the left picture is sent.
  stof_status pixel_points(std::vector<PixelPoint>& points) const {
    return fill_points(stof_pixel_points, points);
  }

  const stof_frame& c() const noexcept { return c_; }
  stof_frame* fill() noexcept { return &c_; }

 private:
  template <typename T>
  stof_status fill_points(stof_status (*make)(const stof_frame*, T*, std::size_t, std::size_t*),
                          std::vector<T>& points) const {
    points.resize(points.capacity());
    std::size_t count = 0;
    stof_status status = make(&c_, points.data(), points.size(), &count);
    if (status == STOF_TOO_SMALL) {
      points.resize(count);
      status = make(&c_, points.data(), points.size(), &count);
    }
    points.resize(status == STOF_OK ? count : 0);
    return status;
  }

  stof_frame c_{};
};

struct Answer {
  stof_status status = STOF_INTERNAL;
  std::string text;            // the document, or why not
  std::uint32_t revision = 0;  // of the active settings
  bool restart = false;        // some of them wait for the next start
};

// A frame that stays beyond the next one, without a copy; its images are valid as long as this is,
// or a copy of this: copies hold the same frame, also on other threads.
class KeptFrame {
 public:
  // Of the newest frame of a sensor. Once; not ok(): it is over, or kept already.
  explicit KeptFrame(const Frame& frame) : frame_(frame) {
    stof_kept* kept = nullptr;
    static_cast<void>(stof_keep(frame_.fill(), &kept));
    kept_.reset(kept);
  }
  KeptFrame(const KeptFrame& other) noexcept
      : frame_(other.frame_), kept_(stof_hold(other.kept_.get())) {}
  KeptFrame(KeptFrame&&) noexcept = default;
  KeptFrame& operator=(KeptFrame other) noexcept {
    frame_ = other.frame_;
    kept_ = std::move(other.kept_);
    return *this;
  }
  ~KeptFrame() = default;

  bool ok() const noexcept { return kept_ != nullptr; }
  const Frame& operator*() const noexcept { return frame_; }
  const Frame* operator->() const noexcept { return &frame_; }

 private:
  struct Release {
    void operator()(stof_kept* kept) const noexcept { stof_release(kept); }
  };
  Frame frame_;
  std::unique_ptr<stof_kept, Release> kept_;
};

// What the cameras gave for one exposure; valid until the next one, or the next frame.
class Raw {
 public:
  Raw() noexcept { c_.struct_size = sizeof c_; }
  explicit Raw(const stof_raw& raw) noexcept : c_(raw) {}
  bool complete() const noexcept { return c_.missing == 0; }
  Image<std::uint8_t> left() const noexcept { return Image<std::uint8_t>(c_.left); }
  Image<std::uint8_t> right() const noexcept { return Image<std::uint8_t>(c_.right); }
  Image<std::uint16_t> pmd(int sample) const noexcept {
    return Image<std::uint16_t>(c_.pmd[sample]);
  }
  const stof_raw& c() const noexcept { return c_; }
  stof_raw* fill() noexcept { return &c_; }

 private:
  stof_raw c_{};
};

// What a sensor's own thread calls; empty ones are not called.
struct Callbacks {
  std::function<void(const Frame&)> frame;
  std::function<void(const Health&)> health;
  std::function<void(const Event&)> event;
  std::function<void(stof_status)> failed;
  std::function<void(const LinkEvent&)> link = {};
  std::function<void(const Raw&)> raw = {};
};

class Sensor {
 public:
  // endpoint: "HOST" or "HOST:PORT". None: `why`, if given, says why not.
  static std::optional<Sensor> open(const std::string& endpoint, std::string* why = nullptr) {
    stof_options options = STOF_INIT(stof_options);
    options.sensor = endpoint.c_str();
    return open(options, why);
  }
  static std::optional<Sensor> open(const stof_options& options, std::string* why = nullptr) {
    char line[256] = {};
    stof_sensor* sensor = nullptr;
    if (stof_open(&options, &sensor, line, sizeof line) != STOF_OK) {
      if (why != nullptr) {
        *why = line;
      }
      return std::nullopt;
    }
    return Sensor(sensor);
  }

  Sensor(Sensor&&) noexcept = default;
  Sensor& operator=(Sensor&& other) noexcept {
    sensor_ = std::move(other.sensor_);  // its thread ends before its callbacks
    callbacks_ = std::move(other.callbacks_);
    return *this;
  }

  // None: `status`, if given, says why: STOF_TIMEOUT: call again; STOF_LOST: open again; STOF_END:
  // the recording is over.
  std::optional<Frame> next(std::chrono::milliseconds timeout, stof_status* status = nullptr) {
    Frame frame;
    const stof_status got =
        stof_next(sensor_.get(), static_cast<int>(timeout.count()), frame.fill());
    if (status != nullptr) {
      *status = got;
    }
    return got == STOF_OK ? std::optional<Frame>(frame) : std::nullopt;
  }
  int fd() const noexcept { return stof_fd(sensor_.get()); }
  std::chrono::milliseconds due() const noexcept {
    return std::chrono::milliseconds(stof_due_ms(sensor_.get()));
  }

  std::optional<Health> health() const {
    Health health = STOF_INIT(stof_health);
    return stof_get_health(sensor_.get(), &health) == STOF_OK ? std::optional<Health>(health)
                                                              : std::nullopt;
  }
  Link link() const {
    Link link = STOF_INIT(stof_link);
    static_cast<void>(stof_get_link(sensor_.get(), &link));
    return link;
  }
  std::optional<Event> next_event() {
    Event event = STOF_INIT(stof_event);
    return stof_next_event(sensor_.get(), &event) == STOF_OK ? std::optional<Event>(event)
                                                             : std::nullopt;
  }
  std::optional<LinkEvent> next_link_event() {
    LinkEvent event = STOF_INIT(stof_link_event);
    return stof_next_link_event(sensor_.get(), &event) == STOF_OK ? std::optional<LinkEvent>(event)
                                                                  : std::nullopt;
  }
  std::optional<Clock> clock() const {
    Clock clock = STOF_INIT(stof_clock);
    return stof_get_clock(sensor_.get(), &clock) == STOF_OK ? std::optional<Clock>(clock)
                                                            : std::nullopt;
  }
  // None: `status`, if given, says why, as stof_next_raw() does.
  std::optional<Raw> next_raw(stof_status* status = nullptr) {
    Raw raw;
    const stof_status got = stof_next_raw(sensor_.get(), raw.fill());
    if (status != nullptr) {
      *status = got;
    }
    return got == STOF_OK ? std::optional<Raw>(raw) : std::nullopt;
  }
  Statistics statistics() const {
    Statistics statistics = STOF_INIT(stof_statistics);
    static_cast<void>(stof_get_statistics(sensor_.get(), &statistics));
    return statistics;
  }
  std::string advice() const {
    std::string line(stof_advice(sensor_.get(), nullptr, 0) + 1, '\0');
    const std::size_t length = stof_advice(sensor_.get(), &line[0], line.size());
    line.resize(length < line.size() ? length : line.size() - 1);
    return line;
  }

  // From now on on a thread of its own; not from a callback.
  stof_status start(Callbacks callbacks) {
    auto own = std::make_unique<Callbacks>(std::move(callbacks));
    stof_callbacks c = STOF_INIT(stof_callbacks);
    c.user = own.get();
    c.frame = [](void* user, const stof_frame* frame) {
      call(static_cast<Callbacks*>(user)->frame, Frame(*frame));
    };
    c.health = [](void* user, const stof_health* health) {
      call(static_cast<Callbacks*>(user)->health, *health);
    };
    c.event = [](void* user, const stof_event* event) {
      call(static_cast<Callbacks*>(user)->event, *event);
    };
    c.failed = [](void* user, stof_status status) {
      call(static_cast<Callbacks*>(user)->failed, status);
    };
    c.link = [](void* user, const stof_link_event* event) {
      call(static_cast<Callbacks*>(user)->link, *event);
    };
    c.raw = [](void* user, const stof_raw* raw) {
      call(static_cast<Callbacks*>(user)->raw, Raw(*raw));
    };
    const stof_status status = stof_start(sensor_.get(), &c);
    if (status == STOF_OK) {
      callbacks_ = std::move(own);  // those of a thread that ended before
    }
    return status;
  }
  stof_status stop() { return stof_stop(sensor_.get()); }

  // What is received from now on goes to `file`, until end_recording() or the end of this. `why`, if
  // given, says why not.
  stof_status record(const std::string& file, std::string* why = nullptr, bool replace = false) {
    stof_record_options options = STOF_INIT(stof_record_options);
    options.replace = replace ? 1 : 0;
    return with_line(why, [&](char* line, std::size_t size) {
      return stof_record(sensor_.get(), file.c_str(), &options, line, size);
    });
  }
  // Blocks until all is written.
  stof_status end_recording(Recorded* recorded = nullptr, std::string* why = nullptr) {
    return with_line(why, [&](char* line, std::size_t size) {
      return stof_record_end(sensor_.get(), recorded, line, size);
    });
  }
  // How far it is, or what came of the last one.
  std::optional<Recorded> recorded() const {
    Recorded recorded = STOF_INIT(stof_recorded);
    return stof_get_recorded(sensor_.get(), &recorded) == STOF_OK ? std::optional<Recorded>(recorded)
                                                                 : std::nullopt;
  }

  // Blocks for about a second when nobody answers.
  Answer settings(stof_operation operation, stof_document document = STOF_ACTIVE,
                  const std::string& text = {}) {
    Answer answer;
    std::vector<char> space(65536);
    stof_answer c = STOF_INIT(stof_answer);
    answer.status = stof_settings(sensor_.get(), operation, document, text.c_str(), space.data(),
                                  space.size(), &c);
    answer.text = space.data();
    answer.revision = c.revision;
    answer.restart = c.restart != 0;
    return answer;
  }
  Answer get(stof_document document = STOF_ACTIVE) { return settings(STOF_GET, document); }
  Answer set(const std::string& json) { return settings(STOF_SET, STOF_ACTIVE, json); }

  // One setting and what it takes: STOF_SETTING_..., or any path of docs/SETTINGS.md. `why`, if
  // given, says why not.
  std::optional<Setting> setting(const char* path, std::string* why = nullptr) {
    Setting out = STOF_INIT(stof_setting);
    char line[512] = {};
    const stof_status got = stof_get_setting(sensor_.get(), path, &out, line, sizeof line);
    if (why != nullptr) {
      *why = line;
    }
    return got == STOF_OK ? std::optional<Setting>(out) : std::nullopt;
  }
  stof_status set_integer(const char* path, std::int64_t value, std::string* why = nullptr) {
    return with_line(why, [&](char* line, std::size_t size) {
      return stof_set_integer(sensor_.get(), path, value, line, size);
    });
  }
  stof_status set_boolean(const char* path, bool value, std::string* why = nullptr) {
    return with_line(why, [&](char* line, std::size_t size) {
      return stof_set_boolean(sensor_.get(), path, value ? 1 : 0, line, size);
    });
  }
  stof_status set_text(const char* path, const std::string& value, std::string* why = nullptr) {
    return with_line(why, [&](char* line, std::size_t size) {
      return stof_set_text(sensor_.get(), path, value.c_str(), line, size);
    });
  }

  stof_sensor* c() const noexcept { return sensor_.get(); }

 private:
  struct Close {
    void operator()(stof_sensor* sensor) const noexcept { stof_close(sensor); }
  };
  explicit Sensor(stof_sensor* sensor) noexcept : sensor_(sensor) {}
  template <typename Ask>
  static stof_status with_line(std::string* why, const Ask& ask) {
    char line[512] = {};
    const stof_status status = ask(line, sizeof line);
    if (why != nullptr) {
      *why = line;
    }
    return status;
  }
  template <typename Function, typename Value>
  static void call(const Function& function, const Value& value) {
    if (function) {
      function(value);
    }
  }

  std::unique_ptr<Callbacks> callbacks_;  // ends after the sensor's thread
  std::unique_ptr<stof_sensor, Close> sensor_;
};

// The sensors near, and those at `addresses`. Blocks for `timeout`.
inline std::vector<Found> discover(
    std::chrono::milliseconds timeout = std::chrono::milliseconds(2500),
    const std::vector<std::string>& addresses = {}) {
  std::vector<const char*> texts;
  for (const std::string& address : addresses) {
    texts.push_back(address.c_str());
  }
  std::vector<Found> found(256);
  std::size_t count = 0;
  const stof_status status =
      stof_discover(static_cast<int>(timeout.count()), texts.data(), texts.size(), found.data(),
                    found.size(), sizeof(Found), &count, nullptr, 0);
  const bool good = status == STOF_OK || status == STOF_TOO_SMALL;
  found.resize(good ? (count < found.size() ? count : found.size()) : 0);
  return found;
}

}  // namespace stof

#endif
