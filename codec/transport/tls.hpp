// TLS 1.3 with certificates that nobody signed: who the peer is follows from its fingerprint and from the
// proof of the token (see pairing.hpp), so no chain is checked. For the .cpp files of this folder.
#pragma once

#include <asio/ssl/context.hpp>
#include <memory>

#include "codec/transport/identity.hpp"
#include "codec/transport/pairing.hpp"

namespace tessera::transport {

enum class Side { Server, Viewer };

/// Nothing below TLS 1.3, both sides show a certificate, no session is resumed.
Result<std::unique_ptr<asio::ssl::context>> makeTlsContext(const Identity& identity);

/// What a proof on this connection is bound to. own: the fingerprint of this side's certificate. Fails where
/// the handshake is not done or the peer showed no certificate.
Result<Binding> bindingOf(SSL* connection, Side side, const Sha256& own);

}  // namespace tessera::transport
