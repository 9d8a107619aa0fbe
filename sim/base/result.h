#pragma once

#include <optional>
#include <string>
#include <utility>
#include <variant>

#include <fmt/format.h>

namespace wry {

/// Why something could not be done. The value is the exit code of the command that ends with it.
enum class ErrorCode {
  check_failed = 1,   ///< finished, but an expectation, a wedge or a check failed
  usage = 2,          ///< the command line
  bad_input = 65,     ///< a shot or a mesh that is not valid
  missing_input = 66, ///< a file or a frame that is not there
  unavailable = 69,   ///< not on this machine or not in this build
  solver = 70,        ///< the solver gave up
  out_of_memory = 71,
  cannot_write = 73, ///< not writable, or locked by another run
  io = 74,           ///< reading or writing failed, or a file is damaged
  stopped = 75,      ///< stopped by a signal; resumable
};

/// What went wrong, in words for the user: what, where, the number, the limit, what to try.
struct Error {
  ErrorCode code = ErrorCode::io;
  std::string message;
};

template <class... Args> Error make_error(ErrorCode code, fmt::format_string<Args...> format, Args&&... args) {
  return Error{code, fmt::format(format, std::forward<Args>(args)...)};
}

/// A value, or the error that kept it from being made. Used for whatever a user, a file or numerics can cause.
template <class T> class [[nodiscard]] Result {
public:
  Result(T value)
      : m_content(std::in_place_index<0>, std::move(value)) {}
  Result(Error error)
      : m_content(std::in_place_index<1>, std::move(error)) {}

  bool ok() const { return m_content.index() == 0; }
  explicit operator bool() const { return ok(); }

  T& value() & { return std::get<0>(m_content); }
  const T& value() const& { return std::get<0>(m_content); }
  T&& value() && { return std::get<0>(std::move(m_content)); }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

  const Error& error() const& { return std::get<1>(m_content); }
  Error&& error() && { return std::get<1>(std::move(m_content)); }

private:
  std::variant<T, Error> m_content;
};

template <> class [[nodiscard]] Result<void> {
public:
  Result() = default;
  Result(Error error)
      : m_error(std::move(error)) {}

  bool ok() const { return !m_error.has_value(); }
  explicit operator bool() const { return ok(); }
  const Error& error() const { return *m_error; }

private:
  std::optional<Error> m_error;
};

using Status = Result<void>;

} // namespace wry
