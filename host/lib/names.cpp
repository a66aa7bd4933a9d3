#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <string_view>

#include "firmware/wire/messages/conditions.h"
#include "host/client/value_names.h"
#include "host/lib/include/stof/stof.h"

namespace {

using stof::client::name_in;

constexpr const char* kUnknown = "unknown";

const stof::wire::ConditionInfo* info_of(unsigned condition) noexcept {
  return condition < stof::wire::kConditions
             ? stof::wire::info_of(static_cast<stof::wire::Condition>(condition))
             : nullptr;
}

}  // namespace

extern "C" {

const char* stof_status_text(int status) {
  constexpr std::array kNames{"ok",
                              "timeout",
                              "bad argument",
                              "unreachable",
                              "connection lost",
                              "not yet known",
                              "busy",
                              "array too small",
                              "refused by the sensor",
                              "out of memory",
                              "unsupported",
                              "internal error",
                              "end of the recording",
                              "file cannot be used"};
  static_assert(kNames.size() == STOF_FILE + 1);
  return status < 0 ? kUnknown : name_in(kNames, static_cast<unsigned>(status));
}

const char* stof_version(void) { return STOF_VERSION; }

size_t stof_struct_size(const char* name) {
  struct Size {
    std::string_view name;
    std::size_t size;
  };
#define STOF_SIZE(type) \
  Size { #type, sizeof(type) }
  constexpr std::array kSizes{
      STOF_SIZE(stof_options), STOF_SIZE(stof_plane),          STOF_SIZE(stof_calibration),
      STOF_SIZE(stof_info),    STOF_SIZE(stof_cloud_point),    STOF_SIZE(stof_frame),
      STOF_SIZE(stof_point),   STOF_SIZE(stof_health),         STOF_SIZE(stof_event),
      STOF_SIZE(stof_link),    STOF_SIZE(stof_callbacks),      STOF_SIZE(stof_statistics),
      STOF_SIZE(stof_answer),  STOF_SIZE(stof_found),          STOF_SIZE(stof_pixel_point),
      STOF_SIZE(stof_raw),     STOF_SIZE(stof_link_event),     STOF_SIZE(stof_clock),
      STOF_SIZE(stof_setting), STOF_SIZE(stof_record_options), STOF_SIZE(stof_recorded)};
#undef STOF_SIZE
  if (name == nullptr) {
    return 0;
  }
  const auto* const found = std::ranges::find(kSizes, std::string_view(name), &Size::name);
  return found == kSizes.end() ? 0 : found->size;
}

const char* stof_condition_name(unsigned condition) {
  const auto* const info = info_of(condition);
  return info == nullptr ? kUnknown : info->name;
}

const char* stof_condition_text(unsigned condition) {
  const auto* const info = info_of(condition);
  return info == nullptr ? kUnknown : info->text;
}

const char* stof_link_condition_name(unsigned condition) {
  constexpr std::array kNames{"silent", "restarted", "forged", "delayed", "no key"};
  return std::has_single_bit(condition)
             ? name_in(kNames, static_cast<unsigned>(std::countr_zero(condition)))
             : kUnknown;
}

const char* stof_severity_name(unsigned severity) {
  return name_in(std::array{"info", "minor", "major", "critical"}, severity);
}

const char* stof_reaction_name(unsigned reaction) {
  return name_in(std::array{"none", "watch", "slow", "stop"}, reaction);
}

const char* stof_source_name(unsigned source) {
  return name_in(stof::client::kSourceNames, source);
}

const char* stof_cause_name(unsigned cause) { return name_in(stof::client::kCauseNames, cause); }

const char* stof_health_name(unsigned health) {
  return name_in(stof::client::kHealthNames, health);
}

}  // extern "C"
