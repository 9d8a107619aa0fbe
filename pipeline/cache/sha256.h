#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "sim/base/result.h"

namespace wry::pipeline {

/// SHA-256 of bytes that come in pieces.
class Sha256 {
public:
  Sha256();
  ~Sha256();
  Sha256(Sha256&&) noexcept;
  Sha256& operator=(Sha256&&) noexcept;

  void update(std::string_view bytes);
  /// 64 lower-case hexadecimal digits; after it only destruction is allowed.
  std::string finish();

private:
  struct Context;
  std::unique_ptr<Context> m_context;
};

/// 64 lower-case hexadecimal digits.
std::string sha256_of_bytes(std::string_view bytes);

/// Errors: missing_input when the file is not there, io when it cannot be read.
Result<std::string> sha256_of_file(const std::filesystem::path& path);

} // namespace wry::pipeline
