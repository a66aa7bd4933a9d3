#pragma once

// Where counting begins and where it ends: hints that mean nothing to any processor, known to
// count.c. A function of its own ends the block that the emulator translates at once.
namespace stof::bench {

[[gnu::noinline]] inline void count_begin() { asm volatile("hint #120" ::: "memory"); }
[[gnu::noinline]] inline void count_end() { asm volatile("hint #121" ::: "memory"); }

}  // namespace stof::bench
