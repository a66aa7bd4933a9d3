# Made by scripts/wire_table.py of firmware/wire/messages.json: change that.
set(message_sources
  messages/announce.cpp
  messages/calibration.cpp
  messages/conditions.cpp
  messages/discover.cpp
  messages/event.cpp
  messages/frame_info.cpp
  messages/header.cpp
  messages/health.cpp
  messages/parity.cpp
  messages/sectors.cpp
  messages/settings_answer.cpp
  messages/settings_request.cpp
  messages/structs.cpp
  messages/subscribe.cpp
  messages/subscribed.cpp)
