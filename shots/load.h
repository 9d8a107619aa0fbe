#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "shots/shot.h"
#include "sim/base/result.h"

namespace wry::shots {

class Table;

/// A key and a value from outside the file: --set key=value, or one parameter of a wedge.
struct Override {
  std::string
      key; ///< "material.skin.youngs_modulus"; array tables by name: "body.bunny.resolution"; "case": a sweep case
  std::string value; ///< TOML; text that is no TOML is taken as a string
  Source source;     ///< where it stands when a file's [sweep] gave it; else it is "--set" in messages
};

/// Splits "key=value" of --set. Errors: usage, when there is no "=" or no key.
Result<Override> parse_override(std::string_view text);

/// A shot file with everything it extends and all overrides, not yet checked against the schema.
class ShotDocument {
public:
  ShotDocument(std::string file, std::string directory, std::shared_ptr<const Table> root);
  const std::string& file() const { return m_file; }           ///< as named by the user
  const std::string& directory() const { return m_directory; } ///< of the file
  const Table& root() const { return *m_root; }

private:
  std::string m_file, m_directory;
  std::shared_ptr<const Table> m_root;
};

/// Limits on what is read, so that no file can hold up or bring down a run.
inline constexpr std::size_t MAX_FILE_BYTES = 1 << 20;
inline constexpr int MAX_DEPTH = 16;           ///< nested tables and arrays
inline constexpr int MAX_EXTENDS = 8;          ///< files in a chain of `extends`
inline constexpr int MAX_ERRORS = 20;          ///< reported at once
inline constexpr std::size_t MAX_ITEMS = 1000; ///< bodies, colliders, ... of one kind

/// Reads `path` and what it extends. Errors: missing_input when a file is not there; bad_input with file:line:column
/// for TOML that is not valid, cycles and files beyond the limits; io when reading fails.
Result<ShotDocument> read_document(const std::string& path);

/// The same from text; `file` names it in messages, paths in it are relative to `directory`.
Result<ShotDocument> read_document_text(std::string_view text, const std::string& file, const std::string& directory);

/// The document with overrides applied in order (the case first, whatever its place). Errors: bad_input naming --set.
Result<ShotDocument> apply_overrides(const ShotDocument& document, const std::vector<Override>& overrides);

/// Checks a document against the schema and binds it. Errors: bad_input with up to MAX_ERRORS lines, each
/// "file:line:column: key: what was found, what was expected, what to do".
Result<Shot> make_shot(const ShotDocument& document);

/// read_document, apply_overrides and make_shot in one go.
Result<Shot> load_shot(const std::string& path, const std::vector<Override>& overrides = {});

} // namespace wry::shots
