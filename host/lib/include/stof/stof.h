/* libstof: frames, health and settings of a stof depth sensor. C99 and later; C++ programs may
 * prefer stof/stof.hpp, a thin wrapper of this header.
 * A recording (stof record, stof_record()) and a serial line are opened and read as a sensor is.
 *
 * Threads. A stof_sensor belongs to one thread at a time, except where a function says otherwise;
 * different sensors are independent. stof_discover() and all functions that return names may be
 * called from any thread.
 * Ownership. stof_close() frees a stof_sensor. Pointers in a stof_frame are the library's: valid
 * until the next stof_next() or stof_close() of that sensor, in a callback until it returns;
 * stof_keep() makes them yours.
 * Nothing is ever thrown or aborted for what arrives from the network.
 * Growth. Structures begin with their size where a later version may add fields at their end: set
 * it (STOF_INIT does), then an older program works with a newer library and the other way round.
 * Times are nanoseconds, of the sensor's clock unless "here" says CLOCK_MONOTONIC of this machine.
 */
#ifndef STOF_STOF_H
#define STOF_STOF_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define STOF_API __attribute__((visibility("default")))
#else
#define STOF_API
#endif

/* stof_options options = STOF_INIT(stof_options); */
#ifdef __cplusplus
#define STOF_INIT(type) stof_sized<type>()
extern "C++" {
template <typename T>
inline T stof_sized() noexcept {
  T value{};
  value.struct_size = static_cast<uint32_t>(sizeof value);
  return value;
}
}
#else
#define STOF_INIT(type) {.struct_size = (uint32_t)sizeof(type)}
#endif

typedef enum stof_status {
  STOF_OK = 0,
  STOF_TIMEOUT = 1,      /* nothing came in time: call again */
  STOF_BAD_ARGUMENT = 2, /* a null pointer, a size of 0, a text that is no address */
  STOF_UNREACHABLE = 3,  /* no such host, no such port to be had, no answer */
  STOF_LOST = 4,         /* the socket failed: close, then open again */
  STOF_NOT_YET = 5,      /* the sensor has not sent that so far */
  STOF_BUSY = 6,         /* the sensor's own thread runs: stof_stop() first */
  STOF_TOO_SMALL = 7,    /* your array is too small; the count tells what is needed */
  STOF_REFUSED = 8,      /* the sensor refused the settings; the text says why */
  STOF_NO_MEMORY = 9,
  STOF_UNSUPPORTED = 10, /* the sensor or this library cannot do that */
  STOF_INTERNAL = 11,    /* a fault of this library */
  STOF_END = 12,         /* the recording is over: open it again to begin anew */
  STOF_FILE = 13         /* a file cannot be read or written */
} stof_status;

/* A few words such as "timeout"; never NULL, also of numbers that have no name. */
STOF_API const char* stof_status_text(int status);
/* Of the library in use: "0.1.0". */
STOF_API const char* stof_version(void);
/* sizeof(name) in the library in use, of a structure of this header, "stof_frame"; 0: it has none
 * of that name. For languages that do not read this header: structures without struct_size never
 * change, the others only grow. */
STOF_API size_t stof_struct_size(const char* name);

/* ---- Opening ------------------------------------------------------------------------------- */

typedef struct stof_sensor stof_sensor;

typedef struct stof_options {
  uint32_t struct_size;
  uint32_t device_id;      /* only this one; 0: any, with keys the one that `stof` proved there */
  const char* sensor;      /* "HOST" or "HOST:PORT" (7560 without) to subscribe at; NULL: wait for a
                              sensor that was told to send here */
  const char* bind;        /* without a sensor: where to listen; NULL: every IPv4 interface */
  uint16_t port;           /* likewise; 0: 7560 */
  uint16_t reserved;       /* 0 */
  uint32_t socket_buffer;  /* bytes asked of the system; 0: 4 MiB */
  uint32_t max_pixels;     /* of one image, bounds the memory; 0: 2 Mi */
  uint32_t max_age_ms;     /* frames that arrived here longer ago, or come later than others by
                              more, are dropped and counted; 0: one period of the sensor and
                              100 ms */
  uint32_t signed_streams; /* 1: subscribe with a key of `keys`, and believe only what the sensor
                             signs for this program alone, see docs/SECURITY.md; 0: believe all */
  const char* keys; /* file of the keys that requests are signed with, as `stof pair` makes it;
                       NULL: this user's own, "": none */
  uint32_t key_id;  /* only the sensor of this key of `keys`: a number any sensor can say of itself,
                       a key it cannot; 0: any */
  uint32_t reserved_2; /* 0 */
  /* What the cameras gave as well, see stof_next_raw(); one subscriber at a time has it, and of a
   * paired sensor one with signed_streams. */
  uint32_t raw_pictures; /* the sum of STOF_RAW_...; 0: none */
  uint16_t raw_every;    /* one exposure of so many frames; 0: each */
  uint16_t raw_step;     /* one column and row of so many, at most 255; 0: each */
  uint16_t raw_part[4];  /* column, row, width, height of the pair's pictures; 0: all that follow */
  /* In the place of `sensor`, one of these two: */
  const char* recording; /* a file of stof_record() or `stof record`, see "Recordings" below */
  const char* line; /* "/dev/ttyUSB0": the sensor at the other end of a serial line, see "Serial
                       lines" below */
  uint32_t baud;    /* of the line; 0: 921,600 */
  uint32_t pace_percent; /* of the recording; 0: a frame each time that one is asked for; 100: as
                            fast as it was recorded, 200: twice as fast */
} stof_options;

/* Does not wait for the sensor, but may block on a name server. `why` (may be NULL) gets one line
 * for a person when it fails. STOF_BAD_ARGUMENT, STOF_UNREACHABLE, STOF_NO_MEMORY; STOF_FILE: no
 * recording. */
STOF_API stof_status stof_open(const stof_options* options, stof_sensor** sensor, char* why,
                               size_t why_size);
/* Ends the subscription and the sensor's thread. NULL is nothing. Not from a callback. */
STOF_API void stof_close(stof_sensor* sensor);

/* ---- Frames -------------------------------------------------------------------------------- */

/* An image. Pixel (x, y) lies at (char*)data + y * stride + x * pixel_bytes. data NULL: the
 * stream is not sent, or nothing of it arrived. What did not arrive is 0. */
typedef struct stof_plane {
  const void* data;
  uint32_t width;
  uint32_t height;
  size_t stride; /* bytes from row to row */
  size_t bytes;  /* from the first to the last pixel */
  uint32_t pixel_bytes;
  uint32_t missing;     /* pixels that did not arrive */
  const uint8_t* marks; /* a byte a pixel: it arrived where (marks[..] & mark) != 0; may be NULL */
  size_t marks_stride;  /* bytes from row to row */
  uint8_t mark;
  uint8_t reserved[7];
} stof_plane;

typedef enum stof_source {
  STOF_SOURCE_NONE = 0,
  STOF_SOURCE_STEREO = 1,
  STOF_SOURCE_PMD = 2,
  STOF_SOURCE_BOTH = 3,
  STOF_SOURCE_RESOLVED = 4, /* no agreement: one sensor, or the surfaces around, decided */
  STOF_SOURCE_CONFLICT = 5  /* they disagreed: no depth */
} stof_source;

typedef enum stof_cause { /* why a depth was resolved or is missing */
                          STOF_CAUSE_NONE = 0,
                          STOF_CAUSE_MIXED_PIXEL = 1,
                          STOF_CAUSE_STEREO_AMBIGUOUS = 2,
                          STOF_CAUSE_RANGE_AMBIGUOUS = 3,
                          STOF_CAUSE_OCCLUDED = 4,
                          STOF_CAUSE_CONTRADICTION = 5,
                          STOF_CAUSE_INTERPOLATED = 6 /* no sensor told it, surfaces around did */
} stof_cause;

typedef enum stof_health_state {
  STOF_HEALTH_OK = 0,
  STOF_HEALTH_DEGRADED = 1,
  STOF_HEALTH_FAULT = 2
} stof_health_state;

/* Of the rectified left camera: no distortion, the centre of the first pixel is (0, 0). The point
 * of pixel (u, v) with depth Z is X = (u - cx) Z / fx, Y = (v - cy) Z / fy: x right, y down, z
 * forward. Z = fx baseline_m / (disparity + doff). */
typedef struct stof_calibration {
  uint32_t width; /* pixels */
  uint32_t height;
  double fx; /* pixels, as fy, cx, cy, doff */
  double fy;
  double cx;
  double cy;
  double doff; /* cx of the right camera less that of the left */
  double k[9]; /* [fx 0 cx; 0 fy cy; 0 0 1], row by row */
  double baseline_m;
  double depth_unit_m; /* of one step of depth and interval_width */
  double max_range_m;
  double period_s;    /* of the trigger */
  uint32_t pmd_width; /* 0: no PMD camera */
  uint32_t pmd_height;
  double modulation_hz;
  double r[9]; /* X_left = R X_pmd + T, row by row */
  double t[3]; /* metres */
} stof_calibration;

/* What a frame stands on: the sum of these. Where a sensor is missing, the other one goes on. */
#define STOF_SENSOR_STEREO 1
#define STOF_SENSOR_PMD 2

typedef struct stof_info { /* how the frame was made */
  /* Of the stereo pair; in a frame of the PMD camera alone, of that. */
  int64_t exposure_begin_ns;
  int64_t exposure_end_ns;
  int64_t pmd_age_ns; /* how much older the PMD data are than the pair's */
  int64_t compute_ns;
  int64_t latency_ns; /* from the middle of the exposure to the sending of the first packet */
  uint32_t pixels_by_source[6];
  uint32_t pixels_by_cause[6];
  uint32_t settings_revision;
  uint8_t pmd_present; /* PMD data took part */
  uint8_t cloud_step;  /* side of a cloud's block, pixels; 0: no cloud */
  uint8_t sensors;     /* STOF_SENSOR_..., the sum; 0: the library is older than this field */
  uint8_t reserved;
} stof_info;

typedef struct stof_cloud_point { /* a pixel of the plane `cloud` */
  int16_t x_mm;
  int16_t y_mm;
  uint16_t depth; /* depth units; 0: no point */
  uint16_t interval_width;
} stof_cloud_point;

typedef struct stof_frame {
  uint32_t struct_size;
  uint32_t device_id;
  uint32_t session_id; /* another one at each start of the sensor */
  uint32_t number;     /* advances by one with each frame sent, wraps */
  uint32_t freshness;  /* advances with each verified new exposure */
  uint32_t health;     /* stof_health_state */
  int64_t exposure_middle_ns;
  int64_t first_packet_ns; /* here */
  int64_t last_packet_ns;  /* here */
  uint32_t packets;        /* that the frame was sent in */
  uint32_t missing_packets;
  uint32_t recovered_packets; /* made of parity */
  /* What stamps count: 0 the sensor's clock; 1 that of an emulated rig; 2 that of a recording that
     is played again: nothing of the frame is new. */
  uint8_t emulated;
  uint8_t has_info;
  uint8_t has_calibration;
  uint8_t reserved;
  stof_plane depth; /* uint16_t, depth units, Z; 0: none */
  /* uint16_t, depth units: the truth lies in depth -+ interval_width / 2 (95 %) */
  stof_plane interval_width;
  stof_plane source;    /* uint8_t, stof_source */
  stof_plane cause;     /* uint8_t, stof_cause */
  stof_plane disparity; /* int16_t, 1/16 pixel, stereo alone; INT16_MIN: none */
  stof_plane pmd[4];    /* uint16_t, the samples A0 to A3 */
  stof_plane left;      /* uint8_t, grey */
  stof_plane right;
  stof_plane cloud; /* stof_cloud_point */
  stof_info info;
  stof_calibration calibration;
  const void* self; /* the library's */
  /* Of the settings it was made with: another one, other settings. 0: unknown, or the library is
   * older than this field. */
  uint32_t settings_fingerprint;
  /* On how many frames in a row this depth stands, itself included: for how many the sensor stood.
   * 1: it stands alone; 0: nobody says (an older sensor or library, or no info arrived). */
  uint32_t steady_frames;
  /* Of the calibration that it was made with: another one, another calibration on the sensor. The
   * CRC-32C at the end of its file. `calibration` above is of this one or, until the sensor has
   * told it, absent. 0: unknown, as above. */
  uint32_t calibration_fingerprint;
  uint32_t reserved2;
  /* exposure_middle_ns by CLOCK_MONOTONIC of this machine, as stof_get_clock() maps it; 0: unknown,
   * or the library is older than this field. */
  int64_t exposure_here_ns;
  /* Of a recording: when the frame was recorded, ns since 1970; 0: of a sensor, or the library is
   * older than this field. */
  int64_t recorded_ns;
} stof_frame;

/* The next frame, also an incomplete one (missing_packets). Blocks for timeout_ms at most, 0 only
 * looks. Call it at least once a second: it keeps the subscription alive. frame->struct_size is
 * set by you. STOF_TIMEOUT, STOF_LOST, STOF_BUSY, STOF_BAD_ARGUMENT, STOF_NO_MEMORY; STOF_END: the
 * recording is over. */
STOF_API stof_status stof_next(stof_sensor* sensor, int timeout_ms, stof_frame* frame);

/* Keeps a frame beyond the next one, without a copy: its images move from the sensor to *kept, and
 * the pointers in `frame` stay valid until stof_release(), also after stof_close(). *kept NULL: a
 * new one is made, some 10 bytes a pixel. Otherwise the frame that it kept ends, and its memory is
 * the sensor's again: with a few of them in turn nothing is allocated. On the thread that
 * stof_next() gave the frame to, or in its callback, of a copy of the stof_frame.
 * STOF_BAD_ARGUMENT: also of a frame that is kept or over; then *kept is as before. STOF_NO_MEMORY.
 */
typedef struct stof_kept stof_kept;
STOF_API stof_status stof_keep(stof_frame* frame, stof_kept** kept);
/* One holder less, and with the last one the frame ends. NULL is nothing. From any thread. */
STOF_API void stof_release(stof_kept* kept);
/* One holder more, who calls stof_release() as well: several readers, on threads of their own, hold
 * one frame, of which there is one copy. Each has a stof_frame of his own, as a copy of the one
 * that was kept. Nobody writes to the pixels; stof_keep() into a frame that others hold as well
 * leaves it to them and makes another. Returns `kept`. From any thread of a holder; NULL is
 * nothing. */
STOF_API stof_kept* stof_hold(stof_kept* kept);

/* For poll(): readable when stof_next(sensor, 0, ...) has something to do. -1, which poll() passes
 * over: no sensor, or a recording, whose frames stof_due_ms() tells alone. */
STOF_API int stof_fd(const stof_sensor* sensor);
/* After so many milliseconds it has something to do in any case; 0: now. */
STOF_API int stof_due_ms(const stof_sensor* sensor);

typedef struct stof_point { /* metres in the rectified left camera: x right, y down, z forward */
  float x;
  float y;
  float z;
  float z_width;   /* the truth lies in z -+ z_width / 2 (95 %); -1: unknown */
  uint32_t source; /* stof_source; STOF_SOURCE_NONE: unknown */
} stof_point;

/* One point for each pixel of `depth`, or where that is not sent of `cloud`. `count` gets how many
 * there are, `points` (may be NULL when capacity is 0) the first `capacity` of them.
 * STOF_NOT_YET: no calibration yet; STOF_TOO_SMALL; STOF_BAD_ARGUMENT; STOF_NO_MEMORY. */
STOF_API stof_status stof_points(const stof_frame* frame, stof_point* points, size_t capacity,
                                 size_t* count);

typedef struct stof_pixel_point { /* a point, and the pixel that it is of */
  float x;                        /* as stof_point */
  float y;
  float z;
  float z_width;
  uint16_t u;       /* column of the depth image */
  uint16_t v;       /* row */
  uint8_t source;   /* stof_source */
  uint8_t cause;    /* stof_cause; 0: none, or it did not arrive */
  uint8_t grey;     /* of the left picture at that pixel */
  uint8_t has_grey; /* 0: the left picture is not sent, of another size, or did not arrive there */
} stof_pixel_point;

/* One for each pixel of `depth`, in raster order; otherwise as stof_points().
 * STOF_UNSUPPORTED: depth is not sent; points of the cloud have no pixel. */
STOF_API stof_status stof_pixel_points(const stof_frame* frame, stof_pixel_point* points,
                                       size_t capacity, size_t* count);

/* ---- Raw pictures -------------------------------------------------------------------------- */

/* What the cameras gave for one exposure, before rectification, bit for bit, where
 * stof_options.raw_pictures asked for it. A picture is there as a whole or not at all.
 * docs/WIRE.md, "Raw pictures". */
#define STOF_RAW_LEFT 1U
#define STOF_RAW_RIGHT 2U
#define STOF_RAW_PMD 4U
#define STOF_RAW_COMPLETE 8U /* only exposures that have all of these */

typedef struct stof_raw {
  uint32_t struct_size;
  uint32_t device_id;
  uint32_t session_id;
  uint32_t frame_number; /* of the frame that was computed from it */
  uint32_t freshness;    /* of that frame: the exposure's id */
  uint32_t number;       /* from 1, of this request */
  uint32_t dropped;      /* exposures that the sensor had no time for */
  uint32_t pictures;     /* that were sent, the sum of STOF_RAW_... */
  uint32_t missing;      /* of these, those that missed a packet */
  uint32_t reserved;
  int64_t edge_ns;
  int64_t exposure_middle_ns;
  uint16_t column; /* where the part begins, pixels of the camera */
  uint16_t row;
  uint16_t step;
  uint16_t reserved2;
  uint16_t camera_width;
  uint16_t camera_height;
  uint16_t state;
  uint16_t pmd_every;
  stof_plane left; /* uint8_t */
  stof_plane right;
  stof_plane pmd[4]; /* uint16_t, A0 to A3 */
} stof_raw;

/* The next exposure that stof_next() has received; look after each, two are kept. Valid until the
 * next stof_next_raw() or stof_next(). STOF_TIMEOUT: none. STOF_UNSUPPORTED: none was asked for.
 * STOF_REFUSED: they take a key; STOF_NOT_YET: another subscriber has them, and this one asks on.
 * STOF_BUSY, STOF_BAD_ARGUMENT. */
STOF_API stof_status stof_next_raw(stof_sensor* sensor, stof_raw* raw);

/* ---- Recordings ---------------------------------------------------------------------------- */

/* A recording is an MCAP file (docs/RECORDING.md) of a sensor's frames, health, events, calibration
 * and settings. stof_open() with stof_options.recording reads one, also one that was cut; what of
 * it is damaged is left out and counted as stof_statistics.packets_refused. stof_next() then gives
 * frame after frame, each also where the program is slow; stof_frame.emulated is 2, recorded_ns
 * says when it was, missing pixels are missing as they were, and a cloud is not in it. Health,
 * events and restarts come with the frame that they belong to, ages count in the recording's time,
 * and nothing is silent. STOF_UNSUPPORTED: settings, clock, raw pictures (stofd --replay takes
 * those). */

typedef struct stof_record_options {
  uint32_t struct_size;
  uint32_t replace; /* 1: a file of that name is replaced; 0: it is refused */
} stof_record_options;

typedef struct stof_recorded {
  uint32_t struct_size;
  uint32_t recording;      /* 1: it goes on */
  uint64_t frames;         /* handed to the disk; at the end: in the file */
  uint64_t frames_dropped; /* the disk was too slow for them */
  uint64_t bytes;          /* of the file, at the end; before it 0 */
  uint32_t failed;         /* 1: the disk took no more; what was whole before is kept */
  uint32_t indexed;        /* at the end: 1; 0: `stof recover` makes the index */
} stof_recorded;

/* From now on what stof_next(), or the sensor's thread, receives goes to `file`, by custom
 * NAME.mcap, too: written by a thread of its own, on the disk after a second, so that a slow disk
 * keeps no receiver waiting. Settings are asked for beside it. Raw pictures are not in it: `stof
 * record --raw`. options NULL: none. `why` (may be NULL) gets one line when it fails. From any
 * thread. STOF_FILE: the file is there, or cannot be made; STOF_BUSY: it is recorded already;
 * STOF_UNSUPPORTED: of a recording. STOF_BAD_ARGUMENT, STOF_NO_MEMORY. */
STOF_API stof_status stof_record(stof_sensor* sensor, const char* file,
                                 const stof_record_options* options, char* why, size_t why_size);
/* Ends it: blocks until all that was received is written. A file without any frame is removed.
 * stof_close() does the same. `recorded` and `why` may be NULL. From any thread.
 * STOF_NOT_YET: nothing is recorded. STOF_FILE: the disk took less than that, `why` says why. */
STOF_API stof_status stof_record_end(stof_sensor* sensor, stof_recorded* recorded, char* why,
                                     size_t why_size);
/* How far it is; after its end what came of the last one. From any thread. STOF_NOT_YET: none was
 * begun. */
STOF_API stof_status stof_get_recorded(stof_sensor* sensor, stof_recorded* recorded);

/* ---- Serial lines --------------------------------------------------------------------------- */

/* stof_options.line: what the sensor's settings serial.* send there (docs/WIRE.md, "Serial lines"),
 * where serial.mode is `stof`, and serial.profile `coarse` or `medium`: small depth maps, whose
 * stof_calibration says in what unit they are, health and events. Of the profile `sectors` health
 * and events come, and no frame. There is no subscription, and nothing is signed: whoever holds the
 * cable is the sensor. Settings are asked over the same line, without keys; a profile is changed
 * so. STOF_LOST: the line failed, as where it was pulled out. STOF_BAD_ARGUMENT of stof_open():
 * with `sensor`, `recording`, signed_streams, key_id or raw_pictures; STOF_UNREACHABLE: no such
 * line. */

/* ---- Health and events --------------------------------------------------------------------- */

typedef struct stof_health {
  uint32_t struct_size;
  uint32_t active;   /* bit k: condition k is active, see stof_condition_name() */
  uint32_t severity; /* 0 info, 1 minor, 2 major, 3 critical */
  uint32_t reaction; /* of the robot: 0 go on, 1 tell somebody, 2 slow down, 3 stop */
  uint64_t uptime_ms;
  double rate_hz; /* frames of the last second */
  double latency_s;
  double longest_latency_s;
  uint64_t frames_published;
  uint64_t packets_sent;
  uint32_t subscribers;
  uint32_t settings_revision;
  /* Counters since the sensor's start, each as its namesake of "Health" in docs/WIRE.md. 0 where
   * the library is older. */
  uint64_t edges;
  uint64_t mispaired;
  uint64_t timeouts;
  uint64_t deadline_misses;
  uint64_t link_drops;
  uint64_t accepted;
  uint64_t truncated;
  uint64_t bad_magic;
  uint64_t bad_version;
  uint64_t bad_length;
  uint64_t bad_crc;
  uint64_t bad_field;
  uint64_t not_control;
  uint64_t foreign;
  uint64_t too_short;
  uint64_t cookies;
  uint64_t busy;
  uint64_t overrun;
  uint64_t forged;
  uint64_t replayed;
  uint64_t serial_sent;
  uint64_t serial_dropped;
  uint64_t serial_refused;
  /* By this machine's clock, when the function was called. */
  int64_t age_ns;  /* since it arrived */
  uint32_t silent; /* 1: no frame for three periods and 20 ms: what stands above is of before */
  uint32_t reserved;
} stof_health;

typedef struct stof_event {
  uint32_t struct_size;
  uint32_t sequence;
  uint32_t condition; /* see stof_condition_name() */
  uint32_t severity;
  uint32_t reaction;
  uint32_t active; /* 1: it began, 0: it ended */
  uint32_t count;  /* how often it has begun */
  uint32_t value;  /* depends on the condition */
  int64_t at_ns;
} stof_event;

/* The newest that stof_next() has read, from any thread. STOF_NOT_YET. */
STOF_API stof_status stof_get_health(stof_sensor* sensor, stof_health* health);
/* The next event, each once; look after every stof_next(). STOF_TIMEOUT: none. STOF_BUSY. */
STOF_API stof_status stof_next_event(stof_sensor* sensor, stof_event* event);
/* From any thread; never NULL, "unknown" for what this library does not know. */
STOF_API const char* stof_condition_name(unsigned condition); /* "stereo_lost" */
STOF_API const char* stof_condition_text(unsigned condition); /* a sentence */
STOF_API const char* stof_severity_name(unsigned severity);
STOF_API const char* stof_reaction_name(unsigned reaction);
STOF_API const char* stof_source_name(unsigned source);
STOF_API const char* stof_cause_name(unsigned cause);
STOF_API const char* stof_health_name(unsigned health);

/* What is known by this machine's clock, whatever the sensor says. */
#define STOF_LINK_SILENT 1U    /* no frame for three periods and 20 ms */
#define STOF_LINK_RESTARTED 2U /* for a second, and until the first frame after a start */
/* In the last 2 s came what no sensor can have sent, or what is not signed and should be. Not
 * believed. */
#define STOF_LINK_FORGED 4U
/* In the last 2 s frames came later than others before by more than max_age_ms: not delivered. */
#define STOF_LINK_DELAYED 8U
/* Of signed streams: whoever answers says that the sensor knows none of your keys: pair with it. */
#define STOF_LINK_NO_KEY 16U

typedef struct stof_link {
  uint32_t struct_size;
  uint32_t conditions;        /* the sum of STOF_LINK_... */
  int64_t frame_age_ns;       /* since the newest frame arrived here; -1: there was none */
  int64_t health_age_ns;      /* likewise of what stof_get_health() tells */
  int64_t calibration_age_ns; /* likewise */
  uint32_t restarts;          /* of the sensor since stof_open(), as far as stof_next() has seen */
  uint32_t reserved;
} stof_link;

/* As of now, also while nobody calls stof_next(). From any thread. */
STOF_API stof_status stof_get_link(stof_sensor* sensor, stof_link* link);

/* The same as events. A restart is one that begins and never ends: whoever reads them all misses
 * none, however short it was. */
typedef struct stof_link_event {
  uint32_t struct_size;
  uint32_t condition; /* one of STOF_LINK_... */
  uint32_t active;    /* 1: it began, 0: it ended */
  uint32_t count;     /* how often it has begun */
  int64_t at_ns;      /* here, when stof_next() saw it */
} stof_link_event;

/* The next one, each once, in their order; 64 are kept, the newest. stof_next() makes them, also
 * one that ends with STOF_TIMEOUT. STOF_TIMEOUT: none. STOF_BUSY. */
STOF_API stof_status stof_next_link_event(stof_sensor* sensor, stof_link_event* event);
/* "silent"; from any thread, never NULL. */
STOF_API const char* stof_link_condition_name(unsigned condition);

/* From the sensor's clock to this machine's CLOCK_MONOTONIC: here = sensor + offset_ns. Of the
 * smallest difference between arrival and sending of the last 2 to 4 seconds. It is too large by
 * the way of the quickest packet (tenths of a millisecond in a wired network), which nobody can
 * measure by listening, and follows clocks that drift by 200 ppm within a millisecond. */
typedef struct stof_clock {
  uint32_t struct_size;
  uint32_t reserved;
  int64_t offset_ns;
  int64_t spread_ns; /* by how much the ways of these frames differed */
  int64_t age_ns;    /* of the newest frame that it was made of */
} stof_clock;

/* From any thread. STOF_NOT_YET: no frame has told it. STOF_UNSUPPORTED: stamps are emulated time,
 * or of a recording (stof_frame.emulated). */
STOF_API stof_status stof_get_clock(stof_sensor* sensor, stof_clock* clock);

/* ---- A thread of its own ------------------------------------------------------------------- */

/* Called on the sensor's thread, one at a time; any of them may be NULL. Return soon: while one
 * runs nothing is received, and after 100 ms or so packets are lost. */
typedef struct stof_callbacks {
  uint32_t struct_size;
  void (*frame)(void* user, const stof_frame* frame);
  void (*health)(void* user, const stof_health* health); /* when a new one came */
  void (*event)(void* user, const stof_event* event);
  void (*failed)(void* user, stof_status status); /* the last call: the thread has ended */
  void* user;
  void (*link)(void* user, const stof_link_event* event);
  void (*raw)(void* user, const stof_raw* raw);
} stof_callbacks;

/* STOF_BUSY: it runs already. STOF_BAD_ARGUMENT, STOF_INTERNAL: the system gives no thread. */
STOF_API stof_status stof_start(stof_sensor* sensor, const stof_callbacks* callbacks);
/* Returns when no callback runs or will run. STOF_BUSY: called from a callback. */
STOF_API stof_status stof_stop(stof_sensor* sensor);

/* ---- What became of the packets ------------------------------------------------------------ */

typedef struct stof_statistics { /* since stof_open() */
  uint32_t struct_size;
  uint32_t socket_buffer; /* bytes that the system granted */
  uint64_t packets;
  uint64_t packets_ok;
  uint64_t packets_refused; /* damaged, cut short, of another version, contradicting themselves */
  uint64_t packets_unknown; /* of a newer sensor */
  uint64_t packets_foreign; /* of another sensor or an ended session */
  uint64_t packets_duplicate;
  uint64_t packets_late;
  uint64_t packets_missing;
  uint64_t packets_recovered;
  uint64_t frames_complete;
  uint64_t frames_incomplete;
  uint64_t frames_stale;   /* showed the past: not delivered */
  uint64_t frames_lost;    /* nothing of them arrived */
  uint64_t frames_dropped; /* nobody took them, or the sensor started again */
  uint64_t sessions;
  uint64_t socket_drops;        /* found the socket's buffer full */
  uint64_t packets_old;         /* waited in this machine's queue for too long */
  uint64_t packets_implausible; /* no sensor can have sent them: forged, or a fault */
  uint64_t frames_old;          /* waited for too long, or held back: not delivered */
  uint64_t resynchronised;      /* the order of frames was wrong and begun anew */
  uint64_t packets_not_signed;  /* where signed_streams was asked for: not signed, or for others */
  uint64_t packets_forged;      /* likewise: with a wrong signature */
} stof_statistics;

/* From any thread. */
STOF_API stof_status stof_get_statistics(stof_sensor* sensor, stof_statistics* statistics);
/* One line: what to change on this machine to lose less, or that the sensor signs streams as
 * another release does; empty: nothing. Returns its length, which may exceed what fitted. From any
 * thread.
 */
STOF_API size_t stof_advice(stof_sensor* sensor, char* text, size_t size);

/* ---- Settings ------------------------------------------------------------------------------ */

typedef enum stof_operation {
  STOF_GET = 0,    /* a document, JSON */
  STOF_SET = 1,    /* text: a JSON object; changes those fields, or nothing if one is refused */
  STOF_STAGE = 2,  /* the same to the staged settings */
  STOF_COMMIT = 3, /* the staged settings become the active ones and are saved */
  STOF_REVERT = 4, /* what is staged is forgotten */
  STOF_PRESET = 5, /* text: a preset's name */
  STOF_SAVE = 6,   /* the active settings are those of the next start */
  STOF_RESET = 7   /* every field's default */
} stof_operation;

typedef enum stof_document { /* of STOF_GET */
                             STOF_ACTIVE = 0,
                             STOF_STAGED = 1,
                             STOF_SAVED = 2,
                             STOF_DEFAULTS = 3,
                             STOF_SCHEMA = 4 /* the JSON Schema of all of these */
} stof_document;

typedef struct stof_answer {
  uint32_t struct_size;
  uint32_t revision; /* of the active settings: advances with every change */
  uint32_t restart;  /* 1: some of them wait for the next start */
  uint32_t reserved;
  size_t text_length; /* of the whole text, without the final 0 */
} stof_answer;

/* Asks the sensor of stof_options::sensor over a socket of its own; blocks for about a second when
 * nobody answers. From any thread. `in`: the text, NULL: none. `out`: the answer's text, ended by
 * 0, cut where out_size is too small; of a refusal which field and what it takes. `answer` may be
 * NULL. With a key of the sensor requests are signed, and
 * only answers that it signed are believed. STOF_REFUSED (also: it takes a key, or the file of keys
 * cannot be used), STOF_UNREACHABLE, STOF_UNSUPPORTED (no sensor was named, or an operation it
 * does not know), STOF_TOO_SMALL (of STOF_GET), STOF_BAD_ARGUMENT, STOF_NO_MEMORY, STOF_LOST. */
STOF_API stof_status stof_settings(stof_sensor* sensor, stof_operation operation,
                                   stof_document document, const char* in, char* out,
                                   size_t out_size, stof_answer* answer);

typedef enum stof_setting_kind {
  STOF_SETTING_INTEGER = 0,
  STOF_SETTING_BOOLEAN = 1,
  STOF_SETTING_CHOICE = 2, /* one of some words */
  STOF_SETTING_TEXT = 3
} stof_setting_kind;

/* Paths of settings that programs change most; docs/SETTINGS.md has all. */
#define STOF_SETTING_NAME "name"                       /* text */
#define STOF_SETTING_PERIOD_MS "period_ms"             /* integer */
#define STOF_SETTING_MAX_RANGE_MM "depth.max_range_mm" /* integer */
#define STOF_SETTING_PRESET "depth.preset"             /* choice */
#define STOF_SETTING_TEMPORAL "depth.temporal"         /* boolean */
#define STOF_SETTING_GUIDED "depth.guided"             /* boolean */
#define STOF_SETTING_STREAM_DEPTH "streams.depth"      /* choice, as the next ones */
#define STOF_SETTING_STREAM_WIDTH "streams.width"
#define STOF_SETTING_STREAM_SOURCE "streams.source"
#define STOF_SETTING_STREAM_DISPARITY "streams.disparity"
#define STOF_SETTING_STREAM_PMD_RAW "streams.pmd_raw"
#define STOF_SETTING_STREAM_GREY_LEFT "streams.grey_left"
#define STOF_SETTING_STREAM_GREY_RIGHT "streams.grey_right"
#define STOF_SETTING_STREAM_CLOUD "streams.cloud"
#define STOF_SETTING_CLOUD_STEP "streams.cloud_step" /* integer */
#define STOF_SETTING_PARITY "streams.parity"         /* boolean */

/* A setting and what it takes, as this sensor says: one of another version may take more. The
 * installer's limits (limits.*) may allow less. */
typedef struct stof_setting {
  uint32_t struct_size;
  uint32_t kind;   /* stof_setting_kind */
  int64_t value;   /* integer; boolean 0 or 1; choice: its place among `choices`; text: 0 */
  int64_t minimum; /* likewise; of texts 0 and the most bytes */
  int64_t maximum;
  int64_t default_value; /* likewise; of texts 0 */
  uint32_t at_restart;   /* 1: a change is in force after the next start, where it was saved */
  uint32_t reserved;
  char text[64];     /* the value as text: "10000", "true", "fit" */
  char unit[16];     /* "mm"; empty: none */
  char choices[160]; /* of a choice: "off raw rvl fit" */
} stof_setting;

/* The active value. Asks as stof_settings() does, the first time also for the schema; `why` (may be
 * NULL) gets one line when it fails. STOF_BAD_ARGUMENT: the sensor has no setting of that path; the
 * others as stof_settings(). From any thread. */
STOF_API stof_status stof_get_setting(stof_sensor* sensor, const char* path, stof_setting* setting,
                                      char* why, size_t why_size);
/* Changes one setting until the next start (STOF_SAVE keeps it). What the sensor does not take is
 * STOF_REFUSED, and `why` says what it takes; STOF_BAD_ARGUMENT: a path or text that no setting
 * can have. From any thread. */
STOF_API stof_status stof_set_integer(stof_sensor* sensor, const char* path, int64_t value,
                                      char* why, size_t why_size);
STOF_API stof_status stof_set_boolean(stof_sensor* sensor, const char* path, int value, char* why,
                                      size_t why_size);
/* Also of choices. */
STOF_API stof_status stof_set_text(stof_sensor* sensor, const char* path, const char* value,
                                   char* why, size_t why_size);

/* ---- Finding sensors ----------------------------------------------------------------------- */

#define STOF_FOUND_BY_MDNS 1U
#define STOF_FOUND_BY_BEACON 2U
#define STOF_FOUND_DIRECTLY 4U /* it answered this machine */

typedef struct stof_found {
  char serial[17]; /* all texts end with 0 */
  char name[33];
  char version[17];
  char board[17];
  char endpoint[84]; /* for stof_options::sensor */
  uint32_t device_id;
  uint32_t found_by; /* the sum of STOF_FOUND_... */
  int32_t health;    /* stof_health_state; -1: unknown, as the rest */
  float rate_hz;
  uint32_t subscribers;
  uint32_t most_subscribers;
} stof_found;

/* Blocks for timeout_ms; 2,500 is good. addresses: HOST[:PORT] to ask besides, NULL when
 * address_count is 0. found_size: sizeof(stof_found). `count` gets how many there are.
 * STOF_TOO_SMALL, STOF_BAD_ARGUMENT, STOF_NO_MEMORY. */
STOF_API stof_status stof_discover(int timeout_ms, const char* const* addresses,
                                   size_t address_count, stof_found* found, size_t capacity,
                                   size_t found_size, size_t* count, char* why, size_t why_size);

#ifdef __cplusplus
}
#endif

#endif
