#include "host/bridge/dds/cdr_type.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>

namespace stof::bridge {
namespace {

struct CdrMessage : ddsi_serdata {
  CdrMessage(const ddsi_sertype* of_type, ddsi_serdata_kind of_kind, recording::Buffer&& message)
      : ddsi_serdata{}, size(message.size()), bytes(std::move(message)) {
    ddsi_serdata_init(this, of_type, of_kind);
    hash = of_type->serdata_basehash;
    constexpr std::size_t kWord = 4;  // what is sent is a multiple of it
    bytes.resize((size + kWord - 1) / kWord * kWord);
  }
  std::size_t size;
  recording::Buffer bytes;
};

const CdrMessage& message_of(const ddsi_serdata* data) {
  return *static_cast<const CdrMessage*>(data);
}

// All messages of a type without a key are of one instance.
bool same_key(const ddsi_serdata* /*a*/, const ddsi_serdata* /*b*/) { return true; }

std::uint32_t size_of(const ddsi_serdata* data) {
  return static_cast<std::uint32_t>(message_of(data).size);
}

void copy_bytes(const ddsi_serdata* data, std::size_t at, std::size_t count, void* to) {
  std::memcpy(to, message_of(data).bytes.data() + at, count);
}

ddsi_serdata* borrow_bytes(const ddsi_serdata* data, std::size_t at, std::size_t count,
                           ddsrt_iovec_t* to) {
  to->iov_base = const_cast<std::byte*>(message_of(data).bytes.data()) + at;  // NOLINT: read only
  to->iov_len = count;
  return ddsi_serdata_ref(data);
}

void return_bytes(ddsi_serdata* data, const ddsrt_iovec_t* /*bytes*/) { ddsi_serdata_unref(data); }

// What stands for the instance.
ddsi_serdata* key_of(const ddsi_serdata* data) {
  auto* const key = new CdrMessage(data->type, SDK_KEY, {});
  key->type = nullptr;
  return key;
}

void free_message(ddsi_serdata* data) { delete static_cast<CdrMessage*>(data); }

std::size_t print_message(const ddsi_sertype* /*type*/, const ddsi_serdata* /*data*/, char* to,
                          std::size_t size) {
  constexpr const char* kText = "(cdr)";
  const std::size_t length = std::min(std::strlen(kText), size - 1);
  std::memcpy(to, kText, length);
  to[length] = '\0';
  return length;
}

void no_key_hash(const ddsi_serdata* /*data*/, ddsi_keyhash* to, bool /*md5*/) { *to = {}; }

// Nothing is read here: what only readers need refuses.
constexpr ddsi_serdata_ops kMessageOps{
    .eqkey = same_key,
    .get_size = size_of,
    .from_ser = [](const ddsi_sertype*, ddsi_serdata_kind, const nn_rdata*,
                   std::size_t) -> ddsi_serdata* { return nullptr; },
    .from_ser_iov = [](const ddsi_sertype*, ddsi_serdata_kind, ddsrt_msg_iovlen_t,
                       const ddsrt_iovec_t*, std::size_t) -> ddsi_serdata* { return nullptr; },
    .from_keyhash = [](const ddsi_sertype*, const ddsi_keyhash*) -> ddsi_serdata* {
      return nullptr;
    },
    .from_sample = [](const ddsi_sertype*, ddsi_serdata_kind, const void*) -> ddsi_serdata* {
      return nullptr;
    },
    .to_ser = copy_bytes,
    .to_ser_ref = borrow_bytes,
    .to_ser_unref = return_bytes,
    .to_sample = [](const ddsi_serdata*, void*, void**, void*) { return false; },
    .to_untyped = key_of,
    .untyped_to_sample = [](const ddsi_sertype*, const ddsi_serdata*, void*, void**,
                            void*) { return false; },
    .free = free_message,
    .print = print_message,
    .get_keyhash = no_key_hash,
#ifdef DDS_HAS_SHM
    .get_sample_size = size_of,
    .from_iox_buffer = [](const ddsi_sertype*, ddsi_serdata_kind, void*, void*) -> ddsi_serdata* {
      return nullptr;
    },
#endif
};

void free_type(ddsi_sertype* type) {
  ddsi_sertype_fini(type);
  delete type;
}

constexpr ddsi_sertype_ops kTypeOps{
    .version = ddsi_sertype_v0,
    .arg = nullptr,
    .free = free_type,
    .zero_samples = [](const ddsi_sertype*, void*, std::size_t) {},
    .realloc_samples = [](void**, const ddsi_sertype*, void*, std::size_t, std::size_t) {},
    .free_samples = [](const ddsi_sertype*, void**, std::size_t, dds_free_op_t) {},
    // Of types of one name.
    .equal = [](const ddsi_sertype*, const ddsi_sertype*) { return true; },
    .hash = [](const ddsi_sertype*) -> std::uint32_t { return 0; },
    .type_id = nullptr,
    .type_map = nullptr,
    .type_info = nullptr,
    .derive_sertype = nullptr,
    .get_serialized_size = nullptr,
    .serialize_into = nullptr,
};

}  // namespace

ddsi_sertype* new_cdr_type(const std::string& dds_type_name) {
  auto* const type = new ddsi_sertype{};
  ddsi_sertype_init(type, dds_type_name.c_str(), &kTypeOps, &kMessageOps, true);
  type->allowed_data_representation = DDS_DATA_REPRESENTATION_FLAG_XCDR1;
  return type;
}

ddsi_serdata* new_cdr_message(const ddsi_sertype* type, recording::Buffer&& message) {
  return new CdrMessage(type, SDK_DATA, std::move(message));
}

}  // namespace stof::bridge
