#pragma once

#include "host/recording/mcap/indexed_reader.h"
#include "host/recording/mcap/stream_reader.h"

// Readers of MCAP files that may hold any bytes: nothing outside the file is read, and memory is
// bounded by Limits. Chunks are stored or of zstd.
