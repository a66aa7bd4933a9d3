#include <array>

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
                              "internal error"};
  static_assert(kNames.size() == STOF_INTERNAL + 1);
  return status < 0 ? kUnknown : name_in(kNames, static_cast<unsigned>(status));
}

const char* stof_version(void) { return STOF_VERSION; }

const char* stof_condition_name(unsigned condition) {
  const auto* const info = info_of(condition);
  return info == nullptr ? kUnknown : info->name;
}

const char* stof_condition_text(unsigned condition) {
  const auto* const info = info_of(condition);
  return info == nullptr ? kUnknown : info->text;
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
