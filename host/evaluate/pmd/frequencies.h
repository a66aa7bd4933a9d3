#pragma once

#include "host/evaluate/pmd/recordings/find.h"

namespace stof::host {

// Two modulation frequencies: what is accepted, and whether its turns are right.
struct FrequencyRow {
  std::string name;
  double first_mhz = 0;
  double second_mhz = 0;
  double period_m = 0;   // after which readings repeat
  double nearest_m = 0;  // of the truth
  double farthest_m = 0;
  double min_ratio = 0;
  long pixels = 0;
  long accepted = 0;
  long wrong = 0;  // of the accepted: by half a turn of the first frequency or more
  double median_error_m = 0;
};

struct FrequencyStudy {
  std::filesystem::path folder;
  std::vector<FrequencyRow> rows;
};

// At a modulation ratio of 0.25 in both frequencies.
dataset::Loaded<FrequencyStudy> study_frequencies(const PmdSet& set, const PmdSources& sources);

}  // namespace stof::host
