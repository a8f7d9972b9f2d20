#include "codec/transport/srtp.hpp"

#include <algorithm>
#include <srtp2/srtp.h>

#include "codec/transport/crypto.hpp"
#include "codec/transport/rtp_packet.hpp"

namespace tessera::transport {

namespace {

// Wide: a receiver that reorders by hundreds of packets must not take them for replays.
constexpr unsigned long kReplayWindow = 1024;

srtp_err_status_t initOnce() {
  static const srtp_err_status_t status = srtp_init();
  return status;
}

Error problem(const char* what, srtp_err_status_t status) {
  switch (status) {
    case srtp_err_status_auth_fail:
      return {fmt::format("SRTP: {}: not made with this key, or altered", what)};
    case srtp_err_status_replay_fail:
    case srtp_err_status_replay_old:
      return {fmt::format("SRTP: {}: came before, or far too late", what)};
    default:
      return {fmt::format("SRTP: {}: libsrtp error {}", what, static_cast<int>(status))};
  }
}

}  // namespace

struct Srtp::State {
  srtp_t session = nullptr;
  ~State() {
    if (session != nullptr) srtp_dealloc(session);
  }
};

Srtp::Srtp(std::unique_ptr<State> state) : state_(std::move(state)) {}
Srtp::Srtp(Srtp&&) noexcept = default;
Srtp& Srtp::operator=(Srtp&&) noexcept = default;
Srtp::~Srtp() = default;

SrtpKey makeSrtpKey() {
  SrtpKey key{};
  fillRandom(key);
  return key;
}

Result<Srtp> Srtp::make(std::uint32_t source, const SrtpKey& key) {
  if (const auto status = initOnce(); status != srtp_err_status_ok)
    return tl::unexpected(problem("start", status));
  SrtpKey copy = key;
  srtp_policy_t policy{};
  srtp_crypto_policy_set_aes_gcm_128_16_auth(&policy.rtp);
  srtp_crypto_policy_set_aes_gcm_128_16_auth(&policy.rtcp);
  policy.ssrc = {ssrc_specific, source};
  policy.key = copy.data();
  policy.window_size = kReplayWindow;
  auto state = std::make_unique<State>();
  if (const auto status = srtp_create(&state->session, &policy); status != srtp_err_status_ok)
    return tl::unexpected(problem("keys", status));
  return Srtp(std::move(state));
}

Result<void> Srtp::protect(std::vector<std::uint8_t>& packet) {
  const std::size_t size = packet.size();
  packet.resize(size + SRTP_MAX_TRAILER_LEN);
  int length = static_cast<int>(size);
  const auto status = srtp_protect(state_->session, packet.data(), &length);
  packet.resize(status == srtp_err_status_ok ? static_cast<std::size_t>(length) : size);
  if (status != srtp_err_status_ok) return tl::unexpected(problem("a packet to send", status));
  return {};
}

Result<void> Srtp::unprotect(std::vector<std::uint8_t>& packet) {
  if (packet.size() < kRtpHeaderBytes + kSrtpTagBytes)
    return fail("SRTP: {} bytes are too few for a packet", packet.size());
  int length = static_cast<int>(packet.size());
  const auto status = srtp_unprotect(state_->session, packet.data(), &length);
  if (status != srtp_err_status_ok) return tl::unexpected(problem("a packet that came", status));
  packet.resize(static_cast<std::size_t>(length));
  return {};
}

}  // namespace tessera::transport
