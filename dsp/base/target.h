#pragma once

// The only place that knows which variant of a kernel this build runs. Every kernel has a `ref`
// (the meaning, plain as the formula) and a `neon` (equal to it, bit for bit; through SIMDe on
// x86). Callers write best::kernel(...).
namespace stof::dsp {

namespace ref {}
namespace neon {}
namespace best = neon;

}  // namespace stof::dsp
