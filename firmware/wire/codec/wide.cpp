#include "firmware/wire/codec/wide.h"

#include "dsp/base/check.h"

namespace stof::wire {
namespace {

// Others may ask before main().
bool& chosen() noexcept {
  static bool wide = wide_available();
  return wide;
}

}  // namespace

bool wide_available() noexcept {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("bmi") != 0 &&
         __builtin_cpu_supports("bmi2") != 0;
#else
  return false;
#endif
}

bool wide() noexcept { return chosen(); }

void use_wide(bool wide) noexcept {
  STOF_CHECK(!wide || wide_available());
  chosen() = wide;
}

}  // namespace stof::wire
