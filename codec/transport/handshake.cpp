#include "codec/transport/handshake.hpp"

#include <algorithm>

namespace tessera::transport {

namespace {

constexpr const char* kWrongProof =
    "the pairing token is not the same on both sides, or someone sits between them";

HandshakeStep refusal(const Versions& spoken, RefusalReason reason, std::string why) {
  HandshakeStep step;
  step.refused = Refusal{reason, spoken, std::move(why)};
  step.send = encode(*step.refused);
  return step;
}

HandshakeStep refusedByPeer(const Versions& spoken, const Record& record) {
  const auto theirs = readRefusal(record.body);
  if (!theirs) return refusal(spoken, RefusalReason::Protocol, theirs.error().message);
  HandshakeStep step;
  step.refused = *theirs;
  step.byPeer = true;
  return step;
}

std::string outOfTurn(const Record& record) {
  return fmt::format("a {} out of turn in the handshake", nameOf(record.kind));
}

void append(Bytes& to, const Bytes& from) { to.insert(to.end(), from.begin(), from.end()); }

}  // namespace

ServerHandshake::ServerHandshake(const Versions& spoken, std::optional<SecureTerms> terms, const Ready& ready)
    : spoken_(spoken), terms_(std::move(terms)), ready_(ready) {
  fillRandom(own_);
}

HandshakeStep ServerHandshake::refuse(RefusalReason reason, std::string why) {
  wants_ = Wants::Nothing;
  return refusal(spoken_, reason, std::move(why));
}

HandshakeStep ServerHandshake::receive(const Record& record) {
  if (wants_ == Wants::Hello && record.kind == RecordKind::Hello) return hello(record);
  if (wants_ == Wants::Proof && record.kind == RecordKind::Proof) return proof(record);
  if (record.kind == RecordKind::Refusal && wants_ != Wants::Nothing) {
    wants_ = Wants::Nothing;
    return refusedByPeer(spoken_, record);
  }
  return refuse(RefusalReason::Protocol, outOfTurn(record));
}

HandshakeStep ServerHandshake::hello(const Record& record) {
  const auto hello = readHello(record.body);
  if (!hello) return refuse(RefusalReason::Protocol, hello.error().message);
  const auto common = wire::commonVersion(spoken_, hello->versions);
  if (!common)
    return refuse(RefusalReason::Version, fmt::format("this server speaks {}, the viewer {}: none is common",
                                                      describe(spoken_), describe(hello->versions)));
  if (hello->secure != terms_.has_value())
    return refuse(RefusalReason::Security, terms_ ? "this server asks for a pairing token"
                                                  : "this server has no pairing token to compare");
  version_ = *common;
  viewers_ = hello->nonce;
  HandshakeStep step;
  step.send = encode(Welcome{version_, own_});
  if (terms_) {
    wants_ = Wants::Proof;
  } else {
    append(step.send, encode(ready_));
    wants_ = Wants::Nothing;
    step.done = true;
  }
  return step;
}

HandshakeStep ServerHandshake::proof(const Record& record) {
  const auto proof = readProof(record.body);
  if (!proof) return refuse(RefusalReason::Protocol, proof.error().message);
  if (!same(*proof, prove(terms_->key, Prover::Viewer, terms_->binding, viewers_, own_)))
    return refuse(RefusalReason::Token, kWrongProof);
  HandshakeStep step;
  step.send = encodeProof(prove(terms_->key, Prover::Server, terms_->binding, viewers_, own_));
  append(step.send, encode(ready_));
  wants_ = Wants::Nothing;
  step.done = true;
  return step;
}

ClientHandshake::ClientHandshake(const Versions& spoken, std::optional<SecureTerms> terms)
    : spoken_(spoken), terms_(std::move(terms)) {
  fillRandom(own_);
}

Bytes ClientHandshake::begin() const { return encode(Hello{spoken_, terms_.has_value(), own_}); }

HandshakeStep ClientHandshake::refuse(RefusalReason reason, std::string why) {
  wants_ = Wants::Nothing;
  return refusal(spoken_, reason, std::move(why));
}

HandshakeStep ClientHandshake::receive(const Record& record) {
  if (wants_ == Wants::Welcome && record.kind == RecordKind::Welcome) return welcome(record);
  if (wants_ == Wants::Proof && record.kind == RecordKind::Proof) return proof(record);
  if (wants_ == Wants::Ready && record.kind == RecordKind::Ready) return ready(record);
  if (record.kind == RecordKind::Refusal && wants_ != Wants::Nothing) {
    wants_ = Wants::Nothing;
    return refusedByPeer(spoken_, record);
  }
  if (record.kind == RecordKind::Ready && wants_ == Wants::Proof)
    return refuse(RefusalReason::Token, "the server did not prove that it has the pairing token");
  return refuse(RefusalReason::Protocol, outOfTurn(record));
}

HandshakeStep ClientHandshake::welcome(const Record& record) {
  const auto welcome = readWelcome(record.body);
  if (!welcome) return refuse(RefusalReason::Protocol, welcome.error().message);
  if (welcome->version < spoken_.oldest || welcome->version > spoken_.newest)
    return refuse(RefusalReason::Version, fmt::format("the server chose version {}, this viewer speaks {}",
                                                      welcome->version, describe(spoken_)));
  version_ = welcome->version;
  servers_ = welcome->nonce;
  HandshakeStep step;
  wants_ = terms_ ? Wants::Proof : Wants::Ready;
  if (terms_) step.send = encodeProof(prove(terms_->key, Prover::Viewer, terms_->binding, own_, servers_));
  return step;
}

HandshakeStep ClientHandshake::proof(const Record& record) {
  const auto proof = readProof(record.body);
  if (!proof) return refuse(RefusalReason::Protocol, proof.error().message);
  if (!same(*proof, prove(terms_->key, Prover::Server, terms_->binding, own_, servers_)))
    return refuse(RefusalReason::Token, kWrongProof);
  wants_ = Wants::Ready;
  return {};
}

HandshakeStep ClientHandshake::ready(const Record& record) {
  const auto ready = readReady(record.body);
  if (!ready) return refuse(RefusalReason::Protocol, ready.error().message);
  if (ready->srtpKey.has_value() != terms_.has_value())
    return refuse(RefusalReason::Security, terms_ ? "the server gave no key for the video"
                                                  : "the server gave a key for the video on a plain channel");
  ready_ = *ready;
  wants_ = Wants::Nothing;
  HandshakeStep step;
  step.done = true;
  return step;
}

}  // namespace tessera::transport
