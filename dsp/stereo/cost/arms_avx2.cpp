#include "dsp/base/lanes_avx2.h"
#include "dsp/stereo/cost/arms_body.h"
