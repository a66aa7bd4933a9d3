#include "firmware/upload/upload_server.h"

#include <algorithm>
#include <string_view>

#include "firmware/settings/text/as_text.h"

namespace stof::upload {

using settings::PagedWriter;
using wire::SettingsOperation;
using wire::UploadStep;

wire::SettingsAnswer UploadServer::serve(const wire::SettingsRequest& request,
                                         std::span<const std::byte> text,
                                         const firmware::Requester& by,
                                         std::span<std::byte> answer_text,
                                         std::size_t& answer_bytes) noexcept {
  if (request.operation == SettingsOperation::kDownload) {
    PagedWriter why(settings::as_writable_text(answer_text));
    Result result = Result::kOk;
    answer_bytes = download(text, answer_text, result, why);
    answer_bytes = result == Result::kOk ? answer_bytes : why.text().size();
    return {.result = result};
  }
  if (request.operation != SettingsOperation::kUpload) {
    return others_.serve(request, text, by, answer_text, answer_bytes);
  }
  PagedWriter why(settings::as_writable_text(answer_text));
  Result result = Result::kDenied;
  std::optional<wire::UploadRequest> asked;
  if (by.access != firmware::Access::kAdmin) {
    why << "upload: takes a key with role admin";
  } else if (const auto read = wire::decode_upload_request(text);
             !read || read->step > UploadStep::kAsk) {
    result = Result::kInvalid;
    why << "upload: no such request: update this program or the sensor";
  } else {
    asked = *read;
    result = serve(*asked, text.subspan(wire::kUploadRequestBytes), by, why);
  }
  if (result != Result::kOk || answer_text.size() < wire::kUploadAnswerBytes) {
    answer_bytes = why.text().size();
    return {.result = result};
  }
  const Versions versions = target_of(asked->kind)->versions();
  wire::encode_upload_answer({.wanted = wanted_,
                              .chunk = kChunkBytes,
                              .state = static_cast<std::uint16_t>(versions.state),
                              .fingerprint = versions.in_force,
                              .former = versions.former},
                             answer_text.first<wire::kUploadAnswerBytes>());
  answer_bytes = wire::kUploadAnswerBytes;
  return {.result = result};
}

Target* UploadServer::target_of(std::uint8_t kind) const noexcept {
  switch (static_cast<wire::UploadKind>(kind)) {
    case wire::UploadKind::kCalibration:
      return &calibration_;
    case wire::UploadKind::kUpdate:
      return update_;
  }
  return nullptr;
}

std::size_t UploadServer::download(std::span<const std::byte> text,
                                   std::span<std::byte> answer_text, Result& result,
                                   PagedWriter& why) const noexcept {
  const auto asked = wire::decode_download_request(text);
  Target* const target = asked ? target_of(asked->kind) : nullptr;
  if (target == nullptr) {
    result = asked ? Result::kUnsupported : Result::kInvalid;
    why << "download: no such thing: update this program or the sensor";
    return 0;
  }
  const std::span<const std::byte> whole = target->file_in_force();
  if (whole.empty() || answer_text.size() < wire::kDownloadAnswerBytes) {
    result = Result::kNotSaved;
    why << "download: this sensor cannot give it";
    return 0;
  }
  const std::size_t from = std::min<std::size_t>(asked->offset, whole.size());
  const std::size_t count =
      std::min({whole.size() - from, kChunkBytes, answer_text.size() - wire::kDownloadAnswerBytes});
  wire::encode_download_answer({.total = static_cast<std::uint32_t>(whole.size()),
                                .offset = asked->offset,
                                .fingerprint = target->versions().in_force},
                               answer_text.first<wire::kDownloadAnswerBytes>());
  std::ranges::copy(whole.subspan(from, count),
                    answer_text.subspan(wire::kDownloadAnswerBytes).begin());
  return wire::kDownloadAnswerBytes + count;
}

UploadServer::Result UploadServer::serve(const wire::UploadRequest& request,
                                         std::span<const std::byte> bytes,
                                         const firmware::Requester& by, PagedWriter& why) noexcept {
  Target* const target = target_of(request.kind);
  if (target == nullptr) {
    why << "upload: this sensor takes nothing of kind " << unsigned{request.kind}
        << ": update the sensor";
    return Result::kUnsupported;
  }
  if (request.step == UploadStep::kAsk) {
    return Result::kOk;
  }
  Identity upload{.kind = request.kind, .total = request.total, .hash = {}, .key_id = by.key_id};
  std::ranges::transform(request.hash, upload.hash.begin(),
                         [](std::uint8_t byte) { return std::byte{byte}; });
  const bool silent = by.now - heard_ > kPatience;
  if (phase_ == Phase::kOver && silent) {
    phase_ = Phase::kNone;
  }
  if (phase_ == Phase::kRunning && !silent && upload_.key_id != by.key_id) {
    why << "upload: another key uploads now: try again in half a minute";
    return Result::kBusy;
  }
  heard_ = by.now;
  if (request.step == UploadStep::kRevert) {
    phase_ = Phase::kNone;
    wanted_ = 0;
    return target->revert(by, why);
  }
  const bool known = phase_ != Phase::kNone && upload == upload_;
  if (!known || (phase_ == Phase::kOver && request.step == UploadStep::kBegin)) {
    // Whatever else is asked of it has to wait until its bytes are there.
    return begin(upload, why);
  }
  switch (request.step) {
    case UploadStep::kChunk:
      return take(request.offset, bytes, why);
    case UploadStep::kCommit:
      return commit(by, why);
    default:
      return Result::kOk;
  }
}

void UploadServer::drop_ended_keys(const wire::KeyTable& keys) noexcept {
  if (upload_.key_id != 0 && keys.find(upload_.key_id) == nullptr) {
    phase_ = Phase::kNone;
    wanted_ = 0;
  }
}

UploadServer::Result UploadServer::begin(const Identity& upload, PagedWriter& why) noexcept {
  phase_ = Phase::kNone;
  wanted_ = 0;
  if (upload.total == 0) {
    why << "upload: there is nothing in it: check the file";
    return Result::kInvalid;
  }
  const Result result = target_of(upload.kind)->begin(upload.total, why);
  if (result == Result::kOk) {
    phase_ = Phase::kRunning;
    upload_ = upload;
    digest_.restart();
  }
  return result;
}

UploadServer::Result UploadServer::take(std::uint32_t offset, std::span<const std::byte> bytes,
                                        PagedWriter& why) noexcept {
  if (phase_ != Phase::kRunning || offset != wanted_ || bytes.empty()) {
    return Result::kOk;  // the answer says what is wanted
  }
  if (bytes.size() > upload_.total - wanted_) {
    why << "upload: a chunk ends behind the " << upload_.total << " bytes that were told";
    return Result::kInvalid;
  }
  const Result result = target_of(upload_.kind)->write(bytes, why);
  if (result != Result::kOk) {
    return result == Result::kBusy ? result : end(result, why);
  }
  digest_.add(bytes);
  wanted_ += static_cast<std::uint32_t>(bytes.size());
  return result;
}

UploadServer::Result UploadServer::commit(const firmware::Requester& by,
                                          PagedWriter& why) noexcept {
  if (phase_ == Phase::kOver) {
    why << std::string_view(told_.data(), told_bytes_);
    return ended_;
  }
  if (wanted_ < upload_.total) {
    return Result::kOk;  // the answer says what is wanted
  }
  wire::StreamingDigest of_all = digest_;
  if (of_all.finish() != upload_.hash) {
    why << "upload: what came has another hash: it was damaged, or changed meanwhile; upload it "
           "again";
    return end(Result::kInvalid, why);
  }
  const Result result = target_of(upload_.kind)->commit(by, why);
  return result == Result::kBusy ? result : end(result, why);
}

UploadServer::Result UploadServer::end(Result result, PagedWriter& why) noexcept {
  phase_ = Phase::kOver;
  ended_ = result;
  told_bytes_ = std::min(why.text().size(), told_.size());
  std::ranges::copy(why.text().substr(0, told_bytes_), told_.begin());
  return result;
}

}  // namespace stof::upload
