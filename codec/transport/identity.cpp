#include "codec/transport/identity.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <iterator>
#include <memory>
#include <openssl/bio.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509.h>
#include <unistd.h>
#include <vector>

namespace tessera::transport {

namespace {

struct Free {
  void operator()(EVP_PKEY* key) const { EVP_PKEY_free(key); }
  void operator()(X509* certificate) const { X509_free(certificate); }
  void operator()(BIO* bio) const { BIO_free(bio); }
};
template <class T>
using Owned = std::unique_ptr<T, Free>;

std::string textOf(BIO* bio) {
  char* text = nullptr;
  const long size = BIO_get_mem_data(bio, &text);
  return {text, static_cast<std::size_t>(size)};
}

Sha256 fingerprintOf(X509* certificate) {
  Sha256 digest{};
  unsigned size = 0;
  X509_digest(certificate, EVP_sha256(), digest.data(), &size);
  return digest;
}

std::string read(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

Result<Identity> load(const std::filesystem::path& certificatePath, const std::filesystem::path& keyPath) {
  std::error_code error;
  using std::filesystem::perms;
  const perms mode = std::filesystem::status(keyPath, error).permissions();
  if (error) return fail("{}: {}", keyPath.string(), error.message());
  if ((mode & (perms::group_all | perms::others_all)) != perms::none)
    return fail(
        "{}: others than its owner may use it (mode {:o}); after chmod 600, or without it and {}, it works",
        keyPath.string(), static_cast<unsigned>(mode & perms::mask), certificatePath.string());
  Identity identity{read(certificatePath), read(keyPath), {}};
  const Owned<BIO> certificateText(
      BIO_new_mem_buf(identity.certificate.data(), static_cast<int>(identity.certificate.size())));
  const Owned<X509> certificate(PEM_read_bio_X509(certificateText.get(), nullptr, nullptr, nullptr));
  if (!certificate) return fail("{}: no certificate: {}", certificatePath.string(), lastCryptoError());
  const Owned<BIO> keyText(BIO_new_mem_buf(identity.key.data(), static_cast<int>(identity.key.size())));
  const Owned<EVP_PKEY> key(PEM_read_bio_PrivateKey(keyText.get(), nullptr, nullptr, nullptr));
  if (!key) return fail("{}: no key: {}", keyPath.string(), lastCryptoError());
  if (X509_check_private_key(certificate.get(), key.get()) != 1)
    return fail("{}: not the key of {}: {}", keyPath.string(), certificatePath.string(), lastCryptoError());
  identity.fingerprint = fingerprintOf(certificate.get());
  return identity;
}

}  // namespace

Result<Identity> makeIdentity() {
  const Owned<EVP_PKEY> key(EVP_PKEY_Q_keygen(nullptr, nullptr, "EC", "P-256"));
  const Owned<X509> certificate(X509_new());
  if (!key || !certificate) return fail("certificate: {}", lastCryptoError());
  std::uint64_t serial = 0;
  fillRandom({reinterpret_cast<std::uint8_t*>(&serial), sizeof(serial)});
  constexpr long kYear = 365L * 24 * 3600;
  X509_NAME* name = X509_get_subject_name(certificate.get());
  const bool made =
      X509_set_version(certificate.get(), X509_VERSION_3) == 1 &&
      ASN1_INTEGER_set_uint64(X509_get_serialNumber(certificate.get()), serial >> 1) == 1 &&
      // A day back, for the other side's clock may be behind.
      X509_gmtime_adj(X509_getm_notBefore(certificate.get()), -24L * 3600) != nullptr &&
      X509_gmtime_adj(X509_getm_notAfter(certificate.get()), 20 * kYear) != nullptr &&
      X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC, reinterpret_cast<const unsigned char*>("tessera"),
                                 -1, -1, 0) == 1 &&
      X509_set_issuer_name(certificate.get(), name) == 1 &&
      X509_set_pubkey(certificate.get(), key.get()) == 1 &&
      X509_sign(certificate.get(), key.get(), EVP_sha256()) > 0;
  if (!made) return fail("certificate: {}", lastCryptoError());

  const Owned<BIO> certificateText(BIO_new(BIO_s_mem()));
  const Owned<BIO> keyText(BIO_new(BIO_s_mem()));
  if (PEM_write_bio_X509(certificateText.get(), certificate.get()) != 1 ||
      PEM_write_bio_PrivateKey(keyText.get(), key.get(), nullptr, nullptr, 0, nullptr, nullptr) != 1)
    return fail("certificate: {}", lastCryptoError());
  return Identity{textOf(certificateText.get()), textOf(keyText.get()), fingerprintOf(certificate.get())};
}

Result<Identity> loadOrMakeIdentity(const std::filesystem::path& folder) {
  const auto certificatePath = folder / "certificate.pem";
  const auto keyPath = folder / "key.pem";
  std::error_code error;
  const bool certificate = std::filesystem::exists(certificatePath, error);
  const bool key = std::filesystem::exists(keyPath, error);
  if (certificate && key) return load(certificatePath, keyPath);
  if (certificate || key)
    return fail("{}: there without {}", (certificate ? certificatePath : keyPath).string(),
                (certificate ? keyPath : certificatePath).filename().string());
  if (std::filesystem::create_directories(folder, error))
    std::filesystem::permissions(folder, std::filesystem::perms::owner_all, error);
  if (error) return fail("{}: {}", folder.string(), error.message());
  auto identity = makeIdentity();
  if (!identity) return identity;
  for (const auto& [path, text] :
       {std::pair(&keyPath, &identity->key), {&certificatePath, &identity->certificate}})
    if (const auto written = writePrivateFile(*path, *text); !written) return tl::unexpected(written.error());
  return identity;
}

std::string showFingerprint(const Sha256& fingerprint) {
  const std::string digits = hex(fingerprint);
  std::string text;
  for (std::size_t i = 0; i < digits.size(); i += 4) text += (i == 0 ? "" : " ") + digits.substr(i, 4);
  return text;
}

Result<void> writePrivateFile(const std::filesystem::path& path, std::string_view text) {
  std::string beside = path.string() + ".XXXXXX";
  // mkstemp makes it with mode 0600: it is never readable by others, not for a moment.
  const int file = mkstemp(beside.data());
  if (file < 0) return fail("{}: {}", beside, std::strerror(errno));
  const bool written =
      write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size()) && fsync(file) == 0;
  const int problem = errno;
  close(file);
  if (written && std::rename(beside.c_str(), path.c_str()) == 0) return {};
  const int last = written ? errno : problem;
  unlink(beside.c_str());
  return fail("{}: {}", path.string(), std::strerror(last));
}

}  // namespace tessera::transport
