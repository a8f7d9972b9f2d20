#include "codec/transport/tls.hpp"

#include <asio/buffer.hpp>
#include <asio/ssl/error.hpp>
#include <asio/ssl/verify_context.hpp>
#include <openssl/ssl.h>
#include <string_view>

namespace tessera::transport {

Result<std::unique_ptr<asio::ssl::context>> makeTlsContext(const Identity& identity) {
  auto context = std::make_unique<asio::ssl::context>(asio::ssl::context::tlsv13);
  SSL_CTX* native = context->native_handle();
  asio::error_code error;
  if (SSL_CTX_set_min_proto_version(native, TLS1_3_VERSION) != 1) return fail("TLS: 1.3 is not to be had");
  context->use_certificate(asio::buffer(identity.certificate), asio::ssl::context::pem, error);
  if (!error) context->use_private_key(asio::buffer(identity.key), asio::ssl::context::pem, error);
  if (error) return fail("TLS: own certificate: {}", error.message());
  // A resumed session would come without the peer's certificate.
  SSL_CTX_set_session_cache_mode(native, SSL_SESS_CACHE_OFF);
  SSL_CTX_set_num_tickets(native, 0);
  SSL_CTX_set_options(native, SSL_OP_NO_TICKET);
  context->set_verify_mode(asio::ssl::verify_peer | asio::ssl::verify_fail_if_no_peer_cert, error);
  if (!error) context->set_verify_callback([](bool, asio::ssl::verify_context&) { return true; }, error);
  if (error) return fail("TLS: {}", error.message());
  return context;
}

Result<Binding> bindingOf(SSL* connection, Side side, const Sha256& own) {
  Binding binding;
  constexpr std::string_view label = "EXPORTER-Channel-Binding";
  if (SSL_version(connection) != TLS1_3_VERSION ||
      SSL_export_keying_material(connection, binding.exporter.data(), binding.exporter.size(), label.data(),
                                 label.size(), nullptr, 0, 0) != 1)
    return fail("TLS: no channel binding: {}", lastCryptoError());
  X509* certificate = SSL_get0_peer_certificate(connection);
  if (certificate == nullptr) return fail("TLS: the peer showed no certificate");
  Sha256 peer{};
  unsigned size = 0;
  if (X509_digest(certificate, EVP_sha256(), peer.data(), &size) != 1)
    return fail("TLS: the peer's certificate: {}", lastCryptoError());
  binding.serverCertificate = side == Side::Server ? own : peer;
  binding.viewerCertificate = side == Side::Server ? peer : own;
  return binding;
}

}  // namespace tessera::transport
