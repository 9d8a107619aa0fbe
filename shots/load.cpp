#include "shots/load.h"

#include "shots/bind.h"
#include "shots/check.h"
#include "shots/ladders.h"
#include "shots/resolved_tree.h"
#include "shots/sweep_plan.h"

namespace wry::shots {

ShotDocument::ShotDocument(std::string file, std::string directory, std::shared_ptr<const Table> root)
    : m_file(std::move(file))
    , m_directory(std::move(directory))
    , m_root(std::move(root)) {}

Result<Shot> make_shot(const ShotDocument& document) {
  Diagnostics diagnostics;
  Table checked = check_document(document, diagnostics);
  plan_sweep(document.root(), diagnostics);
  plan_accuracy(document.root(), diagnostics);
  plan_stress(document.root(), diagnostics);
  Shot shot = bind_shot(checked, document.file(), document.directory());
  check_rules(shot, diagnostics);
  if (!diagnostics.empty()) {
    return diagnostics.error();
  }
  shot.resolved = std::make_shared<const ResolvedTree>(ResolvedTree{std::move(checked)});
  return shot;
}

Result<Shot> load_shot(const std::string& path, const std::vector<Override>& overrides) {
  const Result<ShotDocument> document = read_document(path);
  if (!document) {
    return document.error();
  }
  const Result<ShotDocument> changed = apply_overrides(*document, overrides);
  return changed ? make_shot(*changed) : Result<Shot>(changed.error());
}

} // namespace wry::shots
