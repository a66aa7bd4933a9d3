#pragma once

#include <string>
#include <vector>

#include "dsp/base/target.h"
#include "tests/bench/bench_work.h"

// Groups of contenders that are timed in random turns, and what comes of it.
namespace stof::bench {

struct Contender {
  std::string name;
  Work work;
  std::string peer;  // a contender of the same group; empty: stands alone
};

struct Group {
  std::string name;  // "640x480, 64 disparities"
  int threads = 1;
  std::vector<Contender> contenders;
};

// A machine that others use too makes turns longer, never shorter: the shortest is what is
// compared.
struct Outcome {
  std::string group;
  std::string name;
  std::string peer;
  int threads = 1;
  double least_ms = 0;
  double median_ms = 0;
  double spread = 0;  // between the quartiles, of the median
  double cpu_ms = 0;  // least; of the thread, of the process where there are several threads
  double ratio = 0;   // to the peer, of the shortest times; 0: no peer
  double cpu_ratio = 0;
};

// Runs every contender `rounds` times, in random turns, and prints a line for each.
std::vector<Outcome> measure(const Group& group, int rounds);

// What one of them takes more than the other, beside a peer of the same group; printed, too.
Outcome difference(const std::string& name, const Outcome& with, const Outcome& without,
                   const Outcome& peer);

// "AVX-512", "AVX2" or "NEON source".
const char* name_of(dsp::Vectors vectors);

// What is said about the machine, and all outcomes.
std::string json(const std::vector<Outcome>& outcomes, int rounds, const std::string& peer);

}  // namespace stof::bench
