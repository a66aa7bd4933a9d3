#pragma once

#include <string>

#include "firmware/wire/frame_info.h"
#include "firmware/wire/messages/event.h"
#include "firmware/wire/messages/health.h"
#include "host/client/frame/frame.h"
#include "host/client/session/link_watch.h"

// Messages of a sensor about itself, in words.
namespace stof::host {

// "stereo_lost began: a stereo camera is gone; bring the robot to a safe stop".
std::string event_line(const wire::EventReport& event);

// ", active: stereo_lost drift"; empty where nothing is wrong.
std::string active_text(const wire::HealthReport& health);

// Of a recording: recording::ToldLenses.
std::string lenses_contradict_text();
// ", link: silent restarted forged traffic"; empty where nothing is wrong.
std::string link_text(const client::LinkState& link);

// "good", "major trouble".
const char* severity_text(wire::Severity severity);
// "slow down: expect gaps": what the robot should do.
const char* reaction_text(wire::Reaction reaction);

// "health: good, up 12 s, 30.0 frames/s, latency 21.0 ms mean 33.1 ms longest, 2 subscribers".
std::string health_line(const wire::HealthReport& health);

// "the stereo pair alone", "the PMD camera alone"; empty: both.
const char* alone_text(wire::Sensors sensors);

// Of frames with a recording's clock.
inline constexpr const char* kReplayLine =
    "REPLAY: a recording is played again, nothing of it is new";

// "streams: depth 640x480, source 640x480, pmd 224x172 x 4".
std::string streams_line(const client::Frame& frame);

}  // namespace stof::host
