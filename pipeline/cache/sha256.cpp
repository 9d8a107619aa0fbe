#include "pipeline/cache/sha256.h"

#include <array>
#include <cstdio>
#include <fcntl.h>
#include <unistd.h>
#include <vector>

#include <openssl/evp.h>

#include "pipeline/cache/file_error.h"

namespace wry::pipeline {

struct Sha256::Context {
  EVP_MD_CTX* state = EVP_MD_CTX_new();
  Context() { EVP_DigestInit_ex(state, EVP_sha256(), nullptr); }
  ~Context() { EVP_MD_CTX_free(state); }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
};

Sha256::Sha256()
    : m_context(std::make_unique<Context>()) {}
Sha256::~Sha256() = default;
Sha256::Sha256(Sha256&&) noexcept = default;
Sha256& Sha256::operator=(Sha256&&) noexcept = default;

void Sha256::update(std::string_view bytes) {
  EVP_DigestUpdate(m_context->state, bytes.data(), bytes.size());
}

std::string Sha256::finish() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int size = 0;
  EVP_DigestFinal_ex(m_context->state, digest.data(), &size);
  std::string text;
  text.reserve(2 * size);
  for (unsigned int i = 0; i < size; ++i)
    text += fmt::format("{:02x}", digest[i]);
  return text;
}

std::string sha256_of_bytes(std::string_view bytes) {
  Sha256 sum;
  sum.update(bytes);
  return sum.finish();
}

Result<std::string> sha256_of_file(const std::filesystem::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0)
    return read_error(path, errno);
  Sha256 sum;
  std::vector<char> buffer(1 << 20);
  ssize_t count = 0;
  while ((count = ::read(file, buffer.data(), buffer.size())) != 0) {
    if (count < 0 && errno == EINTR)
      continue;
    if (count < 0)
      break;
    sum.update(std::string_view(buffer.data(), static_cast<std::size_t>(count)));
  }
  const int failure = errno;
  ::close(file);
  if (count < 0)
    return read_error(path, failure);
  return sum.finish();
}

} // namespace wry::pipeline
