#include "dsp/base/lanes_neon.h"
#include "dsp/stereo/cost/arms_body.h"
