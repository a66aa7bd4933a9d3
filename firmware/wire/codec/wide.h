#pragma once

// Functions marked STOF_WIRE_WIDE are compiled, with all that they call, for x86 processors that
// have AVX2 and BMI2. They say the same as what is compiled for all: shifts that take one step and
// vectors twice as long are all that differs.
namespace stof::wire {

#if defined(__x86_64__)
#define STOF_WIRE_WIDE [[gnu::target("avx2,bmi,bmi2"), gnu::flatten]]
#else
#define STOF_WIRE_WIDE
#endif

// Whether this processor runs them; asked once, at start.
bool wide_available() noexcept;
// Whether they are chosen: where they are available, unless a test asks for less.
bool wide() noexcept;
void use_wide(bool wide) noexcept;

}  // namespace stof::wire
