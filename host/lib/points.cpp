#include "host/client/frame/point_cloud.h"
#include "host/lib/sensor.h"

using namespace stof;
using lib::guarded;

namespace {

stof_point to_point(const client::Point& point) noexcept {
  return {.x = point.x,
          .y = point.y,
          .z = point.z,
          .z_width = point.z_width,
          .source = static_cast<std::uint32_t>(point.source)};
}

stof_pixel_point to_pixel_point(const client::Frame& frame, int u, int v,
                                const client::Point& point) noexcept {
  stof_pixel_point out{};
  out.x = point.x;
  out.y = point.y;
  out.z = point.z;
  out.z_width = point.z_width;
  out.u = static_cast<std::uint16_t>(u);
  out.v = static_cast<std::uint16_t>(v);
  out.source = static_cast<std::uint8_t>(point.source);
  if ((frame.received.at(u, v) & client::kHasSource) != 0) {
    out.cause = static_cast<std::uint8_t>(frame.cause.at(u, v));
  }
  const auto& marks = frame.marks[client::index_of(wire::Stream::kGreyLeft)];
  if (dsp::same_size(frame.left, frame.depth) && dsp::same_size(marks, frame.left) &&
      (marks.at(u, v) & client::mark_of(wire::Stream::kGreyLeft)) != 0) {
    out.grey = frame.left.at(u, v);
    out.has_grey = 1;
  }
  return out;
}

stof_status status_of_points(Status made) noexcept {
  return made == Status::kUnsupported ? STOF_NOT_YET : lib::to_status(made);
}

}  // namespace

extern "C" {

stof_status stof_points(const stof_frame* frame, stof_point* points, size_t capacity,
                        size_t* count) {
  const lib::Taken* const taken = lib::taken_of(frame);
  if (taken == nullptr || count == nullptr || (points == nullptr && capacity != 0)) {
    return STOF_BAD_ARGUMENT;
  }
  return guarded([&] {
    *count = 0;
    const auto give = [&](const client::Point& point) {
      if (*count < capacity) {
        points[*count] = to_point(point);
      }
      ++*count;
    };
    if (taken->frame.depth.empty()) {
      client::each_cloud_point(taken->frame, give);
    } else if (const Status made = client::each_point(
                   taken->frame,
                   [&](int /*u*/, int /*v*/, const client::Point& point) { give(point); });
               made != Status::kOk) {
      return status_of_points(made);
    }
    return *count > capacity ? STOF_TOO_SMALL : STOF_OK;
  });
}

stof_status stof_pixel_points(const stof_frame* frame, stof_pixel_point* points, size_t capacity,
                              size_t* count) {
  const lib::Taken* const taken = lib::taken_of(frame);
  if (taken == nullptr || count == nullptr || (points == nullptr && capacity != 0)) {
    return STOF_BAD_ARGUMENT;
  }
  *count = 0;
  if (taken->frame.depth.empty()) {
    return STOF_UNSUPPORTED;
  }
  return guarded([&] {
    const Status made =
        client::each_point(taken->frame, [&](int u, int v, const client::Point& point) {
          if (*count < capacity) {
            points[*count] = to_pixel_point(taken->frame, u, v, point);
          }
          ++*count;
        });
    if (made != Status::kOk) {
      return status_of_points(made);
    }
    return *count > capacity ? STOF_TOO_SMALL : STOF_OK;
  });
}

}  // extern "C"
