#pragma once

#include <string>

#include "host/recording/cdr.h"

struct ddsi_serdata;  // NOLINT: names of Cyclone
struct ddsi_sertype;  // NOLINT

// Messages that are serialised already, as Cyclone DDS takes them: types without a key, of which it
// knows the name and nothing else. One thread may make messages while Cyclone's send earlier ones.
namespace stof::bridge {

// Owned by whoever it is handed to: dds_create_topic_sertype().
ddsi_sertype* new_cdr_type(const std::string& dds_type_name);

// One message of that type, with its encapsulation; owned by dds_writecdr().
ddsi_serdata* new_cdr_message(const ddsi_sertype* type, recording::Buffer&& message);

}  // namespace stof::bridge
